#!/usr/bin/env bash
# Lavapipe (Mesa): how often it compiles one pipeline while the images that it samples have other sizes. Expected: once, since no size
# is part of a pipeline, and shaders ask for it.
# Seen, with Debian 12's Mesa 22.3.6: once for images whose sides are no powers of two, once more where the width is one, once more
# where the height is, and once more where both are. The driver compiles a shader at its first dispatch or draw, and each of these
# counts as another shader. A program that draws at 64x36 after 66x37 stutters once more, and tests that use sizes of all four kinds
# spend up to four times as long on compiling.
#
# findings/lavapipe.sh installs what this needs. The driver's cache on the disk has one file for each shader that was compiled.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/sizes.py" <<'PY'
import os
import sys
import time

os.environ["MESA_SHADER_CACHE_DIR"] = cache = os.path.join(sys.argv[1], "cache")
import lavapipe
import numpy as np

CODE = """
@group(0) @binding(0) var map: texture_2d<f32>;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var<storage, read_write> seen: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) thread: u32) {
    seen[thread] = textureSampleLevel(map, linear, vec2f(f32(thread) / 64.0, 0.3), 0.0).r;
}
"""
sampler = lavapipe.device.create_sampler(mag_filter="linear", min_filter="linear")
compiled, before = [], 0
sizes = [(66, 37), (90, 51), (500, 300), (64, 37), (32, 51), (66, 32), (90, 64), (64, 64), (32, 16)]
for width, height in sizes:
    view = lavapipe.image(np.full((height, width, 4), 0.5, np.float16), "rgba16float")
    seen = lavapipe.array_buffer(np.zeros(64, np.float32))
    lavapipe.compute(CODE, [view, sampler, seen])
    assert lavapipe.read(seen, np.float32).all()
    # A thread of the driver writes the files.
    time.sleep(1)
    files = sum(len(names) for _, _, names in os.walk(cache))
    compiled.append(files - before)
    before = files
print(", ".join(f"{w}x{h}: {n}" for (w, h), n in zip(sizes, compiled)))
anew = [n > 0 for n in compiled]
sys.exit(0 if anew == [True, False, False, True, False, True, False, True, False] else "this has changed: it compiled anew for each kind of size")
PY
python "$scratch/sizes.py" "$scratch"
