#!/usr/bin/env bash
# PFM, the format of pictures and depths as plain floats: the third line of the header has a scale, whose sign says the order of the bytes.
# Descriptions of the format give the absolute value as the scale of the samples. Expected: readers multiply by it, or all ignore it.
# Seen: for samples of 8 and the scale 4, Mitsuba 3.9.1 and OpenImageIO 3.2.2 give 32, and OpenCV 5.0.0 gives 2. The three agree on a scale
# of 1, which is what each of them writes.
set -euo pipefail

. "$(dirname "$0")/python.sh" openimageio==3.2.2.0 mitsuba==3.9.1 opencv-python-headless==5.0.0.93 numpy==2.3.4
venv/bin/python - <<'PY'
import sys

import cv2
import mitsuba as mi
import numpy as np
import OpenImageIO as oiio

mi.set_variant("scalar_rgb")
readers = {
    "Mitsuba": lambda name: np.array(mi.Bitmap(name)),
    "OpenImageIO": lambda name: oiio.ImageBuf(name).get_pixels(oiio.FLOAT),
    "OpenCV": lambda name: cv2.imread(name, cv2.IMREAD_UNCHANGED),
}
seen = []
for scale in ("-1.0", "-4.0", "4.0"):
    samples = np.full((2, 2), 8.0, "<f4" if scale[0] == "-" else ">f4")
    with open("eights.pfm", "wb") as file:
        file.write(f"Pf\n2 2\n{scale}\n".encode() + samples.tobytes())
    found = {name: np.unique(read("eights.pfm")).tolist() for name, read in readers.items()}
    seen.append(f"scale {scale}: " + ", ".join(f"{name} {values}" for name, values in found.items()))
print("\n".join(seen))
wanted = [
    "scale -1.0: Mitsuba [8.0], OpenImageIO [8.0], OpenCV [8.0]",
    "scale -4.0: Mitsuba [32.0], OpenImageIO [32.0], OpenCV [2.0]",
    "scale 4.0: Mitsuba [32.0], OpenImageIO [32.0], OpenCV [2.0]",
]
if seen != wanted:
    sys.exit("this changed: it was\n" + "\n".join(wanted))
PY
