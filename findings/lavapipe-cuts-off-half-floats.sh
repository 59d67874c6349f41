#!/usr/bin/env bash
# Lavapipe (Mesa): what a shader writes to a target of half floats (R16G16B16A16_SFLOAT) is cut off toward zero, and not rounded to the
# nearest half float. Expected: the nearest, as pack2x16float of the same driver gives it, and infinity above 65520.
# Seen, with Debian 12's Mesa 22.3.6: all 256 numbers lie at or below what was written, by half of the last place on average, and 1e6
# becomes 65504. Numbers that the shader itself rounds by pack2x16float first come out without a lean. Vulkan leaves the rounding open,
# so that averages over many frames in half floats lean to dark here and not on a driver that rounds.
#
# findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/half.py" <<'PY'
import sys

import numpy as np
from lavapipe import draw

SIDE = 256
SHADER = """
@fragment
fn shade(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let number = 1.0 + floor(pixel.x) * 0.0037;
    return vec4f(number, unpack2x16float(pack2x16float(vec2f(number))).x, 1e6, 1.0);
}
"""
data = draw(SHADER, [], "rgba16float", (SIDE, 1), 8)
found = np.frombuffer(data, np.float16).reshape(SIDE, 4).astype(np.float64)
numbers = 1.0 + np.arange(SIDE) * 0.0037
leans = {}
for name, column in (("written", 0), ("rounded first", 1)):
    error = (found[:, column] - numbers) * 1024.0  # in units of the last place, which is 1/1024 from 1 to 2
    leans[name] = error.mean()
    print(f"{name}: {(error > 1e-3).sum()} of {SIDE} above, mean error {error.mean():+.2f} of the last place")
print(f"1e6 becomes {found[0, 2]:.0f}")
above = (found[:, 0] - numbers > 1e-6).sum()
if above or leans["written"] > -0.4 or abs(leans["rounded first"]) > 0.1 or found[0, 2] != 65504:
    sys.exit("this changed: none lay above, by half of the last place on average, and 1e6 became 65504")
PY
python "$scratch/half.py"
