#!/usr/bin/env bash
# OpenEXR for Python, with an image that is part of a larger NumPy array: one channel of three, the colour of four channels, an image
# with its axes moved, an array in Fortran's order. Expected: the pixels that the array shows, or an error.
# Seen, with OpenEXR 3.5.3 (3.3.4 and 3.4.4 do the same) and numpy 2.4.6: no error, and a file of the right size whose pixels are the
# numbers that lie in memory one after the other, from the first one on. The middle channel of an image of 0, 1, 2, … has 1, 2, 3 in
# place of 1, 4, 7. Depth or normals that a renderer hands out as parts of one array are therefore written wrongly, without a word;
# numpy.ascontiguousarray before the writing helps.
set -euo pipefail

. "$(dirname "$0")/python.sh" openexr==3.5.3 numpy==2.4.6
venv/bin/python - <<'PY'
import sys

import numpy as np
import OpenEXR

HEIGHT, WIDTH = 4, 5
SCAN_LINES = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}


def written(name, pixels):
    with OpenEXR.File(dict(SCAN_LINES), {name: pixels}) as file:
        file.write("image.exr")
    with OpenEXR.File("image.exr") as file:
        return file.channels()[name].pixels


def counted(*shape):
    return np.arange(np.prod(shape), dtype=np.float32).reshape(shape)


cases = {
    "one channel of three": ("Z", counted(HEIGHT, WIDTH, 3)[:, :, 1]),
    "three channels of four": ("RGB", counted(HEIGHT, WIDTH, 4)[..., :3]),
    "axes moved": ("RGB", np.moveaxis(counted(3, HEIGHT, WIDTH), 0, -1)),
    "Fortran's order": ("Z", np.asfortranarray(counted(HEIGHT, WIDTH))),
}
wrong = 0
for case, (name, pixels) in cases.items():
    found, copied = written(name, pixels), written(name, np.ascontiguousarray(pixels))
    assert np.array_equal(copied, pixels), "a copy in C's order is written as it is"
    assert found.shape == pixels.shape
    wrong += not np.array_equal(found, pixels)
    print(f"{case}: {pixels.ravel()[:4]} became {found.ravel()[:4]}")
if wrong != len(cases):
    sys.exit("this changed: all were written otherwise than the array shows them")
PY
