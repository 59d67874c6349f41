# Sourced by findings about lavapipe, Mesa's Vulkan driver for CPUs: `python` of findings/mesa.sh with wgpu 0.32.0 and numpy 2.4.6.

. "$(dirname "$0")/mesa.sh" lvp wgpu==0.32.0 numpy==2.4.6
