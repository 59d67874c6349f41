#!/usr/bin/env bash
# lavapipe's anisotropic filter of images that are magnified. Expected: a sampler with maxAnisotropy 16 shows a magnified image as one
# without anisotropy does, in even ramps between the texels, since a pixel's footprint is smaller than a texel and as long as wide.
# Seen, with Debian 12's lavapipe of Mesa 22.3.6: two thirds of 64 x 64 pixels that show 4 x 4 texels differ, by up to 0.17 where two
# texels differ by 1. Neighbouring pixels differ by up to 0.12 instead of 0.06, along circles around the texels: the picture of a
# texture from nearby has discs in place of ramps.
#
# findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/magnify.py" <<'PY'
import sys

import numpy as np
from lavapipe import device, draw, image

texels = np.zeros((4, 4, 4), np.float16)
texels[::2, ::2, 0] = 1
view = image(texels, "rgba16float")
SHADER = """
@group(0) @binding(0) var map: texture_2d<f32>;
@group(0) @binding(1) var filtered: sampler;
@fragment
fn shade(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return vec4f(textureSample(map, filtered, pixel.xy / 64.0).x);
}
"""


def magnified(anisotropy):
    """The image in 64 x 64 pixels, by a sampler with so much anisotropy."""
    sampler = device.create_sampler(address_mode_u="repeat", address_mode_v="repeat", min_filter="linear",
                                    mag_filter="linear", mipmap_filter="linear", max_anisotropy=anisotropy)
    data = draw(SHADER, [view, sampler], "rgba32float", (64, 64), 16)
    return np.frombuffer(data, np.float32).reshape(64, 64, 4)[..., 0]


plain, anisotropic = magnified(1), magnified(16)
steps = [np.abs(np.diff(picture, axis=1)).max() for picture in (plain, anisotropic)]
difference = np.abs(plain - anisotropic)
print(f"greatest step between neighbouring pixels: {steps[0]:.3f} without anisotropy, {steps[1]:.3f} with it")
print(f"they differ in {np.mean(difference > 0.01):.0%} of the pixels, by up to {difference.max():.3f}")
if not (steps[0] < 0.07 and steps[1] > 0.1 and np.mean(difference > 0.01) > 0.5):
    sys.exit("this changed: the anisotropic filter magnified with jumps")
PY
python "$scratch/magnify.py"
