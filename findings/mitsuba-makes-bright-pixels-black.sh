#!/usr/bin/env bash
# Mitsuba 3: a bright pixel in a PNG or JPEG picture. Expected: whatever is above 1 becomes 255, the greatest value of a byte.
# Seen, with Mitsuba 3.9.1 on x86-64: with the curve of sRGB, as write_bitmap has it for pictures of 8 bits, 2000 becomes 255, and 3000,
# 65504 and infinity become 0. So the reflection of a lamp may have a black core. Without the curve they become 255. Flat grey of 0.5,
# which is 187.5 of 255, becomes a pattern of 187 and 188, and cannot be compared to the bit with a picture that was rounded.
set -euo pipefail

. "$(dirname "$0")/python.sh" mitsuba==3.9.1 numpy==2.4.6 pillow==13.0.0
venv/bin/python - <<'PY'
import sys

import mitsuba
import numpy as np
from PIL import Image

mitsuba.set_variant("scalar_rgb")


def stored(value, name):
    """The values of a flat picture's pixels in the file."""
    mitsuba.util.write_bitmap(name, np.full((64, 64, 3), value, np.float32), write_async=False)
    return np.unique(np.array(Image.open(name))).tolist()


def plain(value):
    """The byte of a value without the curve of sRGB."""
    picture = mitsuba.Bitmap(np.full((1, 1, 3), value, np.float32))
    kind, byte = mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.UInt8
    return int(np.array(picture.convert(kind, byte, srgb_gamma=False))[0, 0, 0])


values = [0.5, 1.0, 2000.0, 3000.0, 65504.0, float("inf")]
print(f"Mitsuba {mitsuba.__version__}")
png, jpeg, bytes_ = [stored(v, "flat.png") for v in values], [stored(v, "flat.jpg") for v in values[1:]], [plain(v) for v in values[1:]]
for name, given, found in (("PNG", values, png), ("JPEG", values[1:], jpeg), ("without the curve", values[1:], bytes_)):
    print(f"{name}:", ", ".join(f"{v:g} is {f}" for v, f in zip(given, found)))
if png != [[187, 188], [255], [255], [0], [0], [0]] or jpeg != png[1:] or bytes_ != [255] * 5:
    sys.exit("this changed: from 3000 on, pixels with the curve were 0, and 255 without it")
PY
