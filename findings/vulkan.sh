# Sourced by findings that ask a driver of Mesa by Vulkan itself, as `vulkan.sh DRIVER`: `python` of findings/mesa.sh with vulkan
# 1.3.275.1. Debian's glslang-tools and spirv-tools are installed where they are missing (as root).

packages=()
command -v glslangValidator >/dev/null || packages+=(glslang-tools)
command -v spirv-dis >/dev/null || packages+=(spirv-tools)
[ ${#packages[@]} -eq 0 ] || { apt-get update -q && apt-get install -y -q --no-install-recommends "${packages[@]}"; } >/dev/null
. "$(dirname "$0")/mesa.sh" "$1" vulkan==1.3.275.1 cffi==2.1.1
