#!/usr/bin/env bash
# OpenImageIO and an OpenEXR file with the numbers of objects as 32-bit whole numbers (UINT), beside depth or colour as floats. Expected:
# whole numbers are copied as they are, since the copy has a channel of the same type, and whoever asks for whole numbers gets them.
# Seen, with OpenImageIO 3.2.2: the copy is declared UINT, and 16777217 and 16777219 in it are 16777216 and 16777220. ImageBuf
# keeps one type for all channels, and makes whole numbers floats between 0 and 1. A file with numbers alone is exact in ImageBuf and by
# oiiotool --native, which does not help beside floats. Hashes, which use all 32 bits, then name no object.
set -euo pipefail

. "$(dirname "$0")/python.sh" openimageio==3.2.2.0 openexr==3.5.3 numpy==2.4.6
cat >copy.py <<'PY'
import subprocess
import sys

import numpy as np
import OpenEXR
import OpenImageIO as oiio

numbers = np.array([[16777217, 16777218, 16777219]], np.uint32)
depth = np.array([[1.0, 2.0, 3.0]], np.float32)


def read(name):
    """The numbers in a file, by OpenEXR itself."""
    with OpenEXR.File(name, separate_channels=True) as file:
        pixels = file.channels()["id"].pixels
        return pixels[0].tolist() if pixels.dtype == np.uint32 else pixels.dtype


header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
seen = {}
for name, channels in (("numbers alone", {"id": numbers}), ("beside depth", {"id": numbers, "Z": depth})):
    OpenEXR.File(header, channels).write("given.exr")
    given = read("given.exr")
    oiio.ImageBuf("given.exr").write("copy.exr")
    seen[f"{name}, ImageBuf"] = read("copy.exr")
    for options in ([], ["--native"]):
        subprocess.run(["venv/bin/oiiotool", *options, "given.exr", "-o", "copy.exr"], check=True)
        seen[f"{name}, oiiotool {' '.join(options)}".rstrip()] = read("copy.exr")
print(f"OpenImageIO {oiio.__version__}, given {given}")
for name, found in seen.items():
    print(f"{name}: {found}")
exact, rounded = numbers[0].tolist(), [16777216, 16777218, 16777220]
if given != exact or list(seen.values()) != [exact, rounded, exact, rounded, rounded, rounded]:
    sys.exit("this changed: numbers beside depth were rounded by all three, and alone by oiiotool without --native")
PY
venv/bin/python copy.py
