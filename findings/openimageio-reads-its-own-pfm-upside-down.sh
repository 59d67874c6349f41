#!/usr/bin/env bash
# OpenImageIO and PFM, whose rows go from the bottom to the top: the writer turns the rows over. The reader does so only where it is
# given a configuration, be it an empty one. Expected: ImageBuf gives back the picture that ImageBuf wrote, and an empty configuration
# changes nothing.
# Seen, with OpenImageIO 3.2.2: rows of 0, 1 and 2 come back as 2, 1 and 0 by ImageBuf and by ImageInput.open(name). They come back in order
# by ImageInput.open(name, ImageSpec()) and by the program oiiotool. OpenCV reads the file in order too.
set -euo pipefail

. "$(dirname "$0")/python.sh" openimageio==3.2.2.0 numpy==2.3.4 opencv-python-headless==5.0.0.93
venv/bin/python - <<'PY'
import subprocess
import sys

import cv2
import numpy as np
import OpenImageIO as oiio

rows = np.repeat(np.arange(3, dtype=np.float32), 2).reshape(3, 2, 1)
image = oiio.ImageBuf(oiio.ImageSpec(2, 3, 1, oiio.FLOAT))
image.set_pixels(oiio.ROI(0, 2, 0, 3, 0, 1, 0, 1), rows)
image.write("rows.pfm")


def column(pixels):
    return [int(value) for value in np.asarray(pixels).reshape(3, 2)[:, 0]]


def opened(*configuration):
    file = oiio.ImageInput.open("rows.pfm", *configuration)
    return column(file.read_image(oiio.FLOAT))


subprocess.run(["venv/bin/oiiotool", "rows.pfm", "-o", "rows.exr"], check=True)
seen = {
    "ImageBuf": column(oiio.ImageBuf("rows.pfm").get_pixels(oiio.FLOAT)),
    "open(name)": opened(),
    "open(name, ImageSpec())": opened(oiio.ImageSpec()),
    "oiiotool": column(oiio.ImageBuf("rows.exr").get_pixels(oiio.FLOAT)),
    "OpenCV": column(cv2.imread("rows.pfm", cv2.IMREAD_UNCHANGED)),
}
for name, found in seen.items():
    print(f"{name}: {found}")
if list(seen.values()) != [[2, 1, 0], [2, 1, 0], [0, 1, 2], [0, 1, 2], [0, 1, 2]]:
    sys.exit("this changed: the first two were upside down, and the other three in order")
PY
