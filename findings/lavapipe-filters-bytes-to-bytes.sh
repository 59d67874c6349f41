#!/usr/bin/env bash
# Mesa's lavapipe rounds what its linear filter makes of an 8-bit texture to 8 bits again.
#
# Expected: between two texels of 100/255 and 104/255, a linear filter gives as many values as there are places that the device
# tells apart (subTexelPrecisionBits: 256), as it does for the same texels in R8G8B8A8_SRGB or R16G16B16A16_SFLOAT.
# Seen, with Debian 12's Mesa 22.3.6: R8G8B8A8_UNORM gives five values, the multiples of 1/255. A normal map that is seen from near is
# a staircase of normals, and each of the three steps of a trilinear filter rounds. Mesa 25.0.7 does the same, and Mesa 26.1.6 rounds
# otherwise, so that images with normal maps differ between versions (mean FLIP of up to 0.07). With
# GALLIVM_PERF=no_aos_sampling all three filter in floating point and agree.
#
# findings/lavapipe.sh installs what this needs.
set -euo pipefail

wanted=$'fixed point: unorm 5, srgb 256, half 256\nfloating point: unorm 256, srgb 256, half 256'
. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/filter.py" <<'PY'
import numpy as np
from lavapipe import array_buffer, compute, device, image, read

PLACES = 256
SHADER = """
@group(0) @binding(0) var map: texture_2d<f32>;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var<storage, read_write> seen: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let place = vec2f(0.25 + 0.5 * f32(thread.x) / 256.0, 0.5);
    seen[thread.x] = textureSampleLevel(map, linear, place, 0.0).r;
}
"""


def values(name, texels):
    """The number of values between two texels of a format."""
    view = image(np.repeat(texels, 4).reshape(1, 2, 4), name)
    seen = array_buffer(np.zeros(PLACES, np.float32))
    compute(SHADER, [view, device.create_sampler(mag_filter="linear", min_filter="linear"), seen], PLACES // 64)
    return len(np.unique(read(seen, np.float32)))


bytes_, halves = np.array([100, 104], np.uint8), np.array([100 / 255, 104 / 255], np.float16)
print(f"unorm {values('rgba8unorm', bytes_)}, srgb {values('rgba8unorm-srgb', bytes_)}, "
      f"half {values('rgba16float', halves)}")
PY
fixed=$(python "$scratch/filter.py" 2>/dev/null)
floating=$(GALLIVM_PERF=no_aos_sampling python "$scratch/filter.py" 2>/dev/null)
seen="fixed point: $fixed"$'\n'"floating point: $floating"
echo "$seen"
if [ "$seen" != "$wanted" ]; then
    echo "this changed: it was \"$wanted\"" >&2
    exit 1
fi
