#!/usr/bin/env bash
# naga, the shader translator of wgpu: the remainder of two signed whole numbers in SPIR-V (OpSMod, which glslang makes of GLSL's % for
# int). Expected: the remainder, for all numbers of 32 bits.
# Seen, with wgpu 0.32.0 for Python and Debian 12's glslangValidator: 17 % 5 is 2, but 16777219 % 10 is -1 and 2147483647 % 10 is -33. The
# translator takes the quotient by a division of 32-bit floats, which tell whole numbers apart up to 16777216. The same
# line as WGSL gives 9 and 7. Hashes, random numbers and places in large buffers are wrong or negative, in SPIR-V alone.
#
# findings/lavapipe.sh and Debian's glslang-tools and spirv-tools, installed where they are missing (as root), are what this needs.
set -euo pipefail

packages=()
command -v glslangValidator >/dev/null || packages+=(glslang-tools)
command -v spirv-dis >/dev/null || packages+=(spirv-tools)
[ ${#packages[@]} -eq 0 ] || { apt-get update -q && apt-get install -y -q --no-install-recommends "${packages[@]}"; } >/dev/null
. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/rest.comp" <<'GLSL'
#version 450
layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Numbers { int numbers[9]; };
void main() {
    for (int i = 0; i < 3; i++) numbers[6 + i] = numbers[2 * i] % numbers[2 * i + 1];
}
GLSL
cat >"$scratch/rest.wgsl" <<'WGSL'
@group(0) @binding(0) var<storage, read_write> numbers: array<i32, 9>;
@compute @workgroup_size(1)
fn main() {
    for (var i = 0; i < 3; i++) { numbers[6 + i] = numbers[2 * i] % numbers[2 * i + 1]; }
}
WGSL
glslangValidator -V "$scratch/rest.comp" -o "$scratch/rest.spv" >/dev/null
spirv-val "$scratch/rest.spv"
echo "instructions OpSMod in the SPIR-V: $(spirv-dis "$scratch/rest.spv" | grep -c 'OpSMod')"
cat >"$scratch/rest.py" <<'PY'
import pathlib
import sys

import numpy as np
import wgpu
from lavapipe import array_buffer, compute, read

folder = pathlib.Path(sys.argv[1])
GIVEN = [17, 5, 16777219, 10, 2147483647, 10, 0, 0, 0]


def rests(code):
    """The three remainders that a shader computes."""
    numbers = array_buffer(np.array(GIVEN, np.int32))
    compute(code, [numbers])
    return read(numbers, np.int32)[6:].tolist()


spirv, wgsl = rests((folder / "rest.spv").read_bytes()), rests((folder / "rest.wgsl").read_text())
print(f"wgpu {wgpu.__version__}, wgpu-native {'.'.join(map(str, wgpu.backends.wgpu_native.lib_version_info))}")
print(f"{GIVEN[:6:2]} % {GIVEN[1:6:2]}: {spirv} as SPIR-V, {wgsl} as WGSL")
if spirv != [2, -1, -33] or wgsl != [2, 9, 7]:
    sys.exit("this changed: it was [2, -1, -33] as SPIR-V and [2, 9, 7] as WGSL")
PY
python "$scratch/rest.py" "$scratch" 2>"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
