#!/usr/bin/env bash
# naga, the shader translator of wgpu: x != x, the usual test for "not a number" where a language has no isnan, as in WGSL. Expected: true
# of NaN, as in the SPIR-V that comes in (OpFUnordNotEqual); or, if the driver knew no NaN, !(x == x) false too.
# Seen, with wgpu 0.32.0 for Python and Debian 12's lavapipe: x != x is false and !(x == x) true of the same NaN, from SPIR-V and
# from WGSL alike. WGSL allows this, since a compiler may take NaN for absent. So a test that is right in Vulkan without naga fails behind
# it; !(x == x) held here.
#
# findings/lavapipe.sh and Debian's glslang-tools and spirv-tools, installed where they are missing (as root), are what this needs.
set -euo pipefail

packages=()
command -v glslangValidator >/dev/null || packages+=(glslang-tools)
command -v spirv-dis >/dev/null || packages+=(spirv-tools)
[ ${#packages[@]} -eq 0 ] || { apt-get update -q && apt-get install -y -q --no-install-recommends "${packages[@]}"; } >/dev/null
. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/nan.comp" <<'GLSL'
#version 450
layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Given { float x[1]; };
layout(std430, binding = 1) buffer Seen { uint seen[3]; };
void main() {
    float x = x[0];
    seen[0] = uint(x != x);
    seen[1] = uint(!(x == x));
    seen[2] = uint(!(x < 1.0));
}
GLSL
cat >"$scratch/nan.wgsl" <<'WGSL'
@group(0) @binding(0) var<storage, read_write> given: array<f32, 1>;
@group(0) @binding(1) var<storage, read_write> seen: array<u32, 3>;
@compute @workgroup_size(1)
fn main() {
    let x = given[0];
    seen[0] = u32(x != x);
    seen[1] = u32(!(x == x));
    seen[2] = u32(!(x < 1.0));
}
WGSL
glslangValidator -V "$scratch/nan.comp" -o "$scratch/nan.spv" >/dev/null
spirv-val "$scratch/nan.spv"
echo "instructions OpFUnordNotEqual in the SPIR-V: $(spirv-dis "$scratch/nan.spv" | grep -c 'OpFUnordNotEqual')"
cat >"$scratch/nan.py" <<'PY'
import pathlib
import sys

import numpy as np
import wgpu
from lavapipe import array_buffer, compute, read

folder = pathlib.Path(sys.argv[1])


def tests(code, value):
    """What a shader says of a value: x != x, !(x == x), !(x < 1)."""
    seen = array_buffer(np.zeros(3, np.uint32))
    compute(code, [array_buffer(np.array([value], np.float32)), seen])
    return read(seen, np.uint32).tolist()


print(f"wgpu {wgpu.__version__}, wgpu-native {'.'.join(map(str, wgpu.backends.wgpu_native.lib_version_info))}")
codes = {"SPIR-V": (folder / "nan.spv").read_bytes(), "WGSL": (folder / "nan.wgsl").read_text()}
seen = {name: (tests(code, np.nan), tests(code, 0.5)) for name, code in codes.items()}
for name, (nan, number) in seen.items():
    print(f"{name}: x != x, !(x == x), !(x < 1) of NaN {nan}, of 0.5 {number}")
if any(found != ([0, 1, 1], [0, 0, 0]) for found in seen.values()):
    sys.exit("this changed: it was [0, 1, 1] of NaN and [0, 0, 0] of 0.5")
PY
python "$scratch/nan.py" "$scratch" 2>"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
