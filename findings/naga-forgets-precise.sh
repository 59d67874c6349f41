#!/usr/bin/env bash
# naga, the shader translator of wgpu and Firefox: a number that GLSL declares `precise`, which SPIR-V marks NoContraction, so that no
# compiler joins its product and sum to one rounding. Expected: the mark is kept, or the shader is refused.
# Seen, with naga-cli 30.0.1 and Debian 12's glslangValidator: from SPIR-V to SPIR-V both marks are gone, and the exit status is 0. A
# line of the log, which wgpu shows to whoever asks for warnings, says "Unknown decoration NoContraction". Metal's and HLSL's output have
# no word for it either. The same shader as GLSL is refused: "Unknown variable: precise". A shader whose rays must hit what a program on
# the CPU computes to the bit may therefore do otherwise behind naga.
#
# Cargo compiles naga-cli, which takes minutes. Debian's glslang-tools and spirv-tools are installed where they are missing (as root).
set -euo pipefail

packages=()
command -v glslangValidator >/dev/null || packages+=(glslang-tools)
command -v spirv-dis >/dev/null || packages+=(spirv-tools)
[ ${#packages[@]} -eq 0 ] || { apt-get update -q && apt-get install -y -q --no-install-recommends "${packages[@]}"; } >/dev/null
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cargo install --quiet --locked --root . naga-cli --version 30.0.1
cat >square.comp <<'GLSL'
#version 450
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Numbers { float numbers[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    precise float less = numbers[i] * numbers[i] - 1.0;
    numbers[i] = less;
}
GLSL
glslangValidator -V --quiet square.comp -o square.spv
marks() { spirv-dis "$1" | grep -c 'OpDecorate .* NoContraction' || true; }
bin/naga square.spv through.spv 2>log
bin/naga square.spv through.metal 2>/dev/null
bin/naga square.spv through.hlsl 2>/dev/null
before=$(marks square.spv) after=$(marks through.spv) words=$(cat through.metal through.hlsl | grep -c precise || true)
echo "$(bin/naga --version): marked before $before, after $after; 'precise' in Metal and HLSL: $words"
head -n 1 log
refused=0
bin/naga --input-kind glsl --shader-stage compute square.comp again.spv >said 2>&1 || refused=1
grep -o 'Unknown variable: precise' said || true
if [ "$before/$after/$words/$refused" != 2/0/0/1 ] || ! grep -q 'Unknown decoration NoContraction' log; then
    echo 'this changed: two marks were lost with a warning, and GLSL was refused' >&2
    exit 1
fi
