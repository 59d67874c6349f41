#!/usr/bin/env bash
# Lavapipe (Mesa): what a shader writes to a target of ten bits (A2B10G10R10_UNORM_PACK32), the usual format of normals in a G-buffer.
# Expected: the number times 1023, rounded to the nearest, as the same driver stores eight bits as the number times 255.
# Seen, with Debian 12's Mesa 22.3.6 (Mesa 25.0.7 does the same): the number times 1024, cut off. So small numbers lie up to a whole step
# too low and large ones up to a step too high, and normals that are stored as n / 2 + 1 / 2 lean away from zero. Vulkan allows either
# neighbour, so that images of such a G-buffer differ from those of a GPU by a step.
#
# findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/tenbits.py" <<'PY'
import sys

import numpy as np
from lavapipe import draw

SIDE = 256
SHADER = """
@fragment
fn shade(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let number = (floor(pixel.x) + 256.0 * floor(pixel.y)) / 65535.0;
    return vec4f(number, number, number, 1.0);
}
"""
numbers = np.arange(SIDE * SIDE) / (SIDE * SIDE - 1)


def stored(image_format, most):
    """The bits that are stored for each number."""
    return np.frombuffer(draw(SHADER, [], image_format, (SIDE, SIDE), 4), np.uint32) & most


def largest_step(bits, most):
    """The greatest distance of stored bits from the number, in steps."""
    return np.abs(bits - numbers * most).max()


eight, ten = stored("rgba8unorm", 255), stored("rgb10a2unorm", 1023)
print(f"eight bits: at most {largest_step(eight, 255):.3f} of a step beside the number; ten bits: {largest_step(ten, 1023):.3f}")
cut = np.minimum(np.floor(numbers * 1024), 1023)
nearest = np.rint(numbers * 1023)
print(f"ten bits are the number times 1024, cut off, in {(ten == cut).mean():.2%}, and the nearest in {(ten == nearest).mean():.2%}")
if largest_step(eight, 255) > 0.51 or (ten == cut).mean() < 0.999:
    sys.exit("this changed: eight bits were the nearest, and ten bits the number times 1024, cut off")
PY
python "$scratch/tenbits.py"
