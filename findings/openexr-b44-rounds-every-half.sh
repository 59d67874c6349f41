#!/usr/bin/env bash
# OpenEXR's lossy codecs differ in what they keep. B44 rounds every channel of half floats, whatever its name, and keeps 32-bit floats
# to the bit, while DWAA and LJ2K (number 12) round channels with names of colours and keep all others, of either kind. PXR24 rounds
# 32-bit floats alone; HTJ2K and ZSTD (13) round nothing. Expected from "lossy" and "lossless": one rule for all channels.
set -euo pipefail

. "$(dirname "$0")/python.sh" openexr==3.5.3 numpy==2.3.4
venv/bin/python - <<'PY'
import sys

import numpy as np
import OpenEXR

rng = np.random.default_rng(1)


def keeps(codec, kind, names):
    channels = {name: rng.random((64, 64)).astype(kind) for name in names}
    header = {"compression": getattr(OpenEXR, codec), "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {name: values.copy() for name, values in channels.items()}).write("a.exr")
    read = OpenEXR.File("a.exr", separate_channels=True).channels()
    return all(np.array_equal(values, read[name].pixels) for name, values in channels.items())


print("OpenEXR", OpenEXR.__version__)
expected = {  # half colours, half data, float colours, float data: kept to the bit?
    "B44_COMPRESSION": (False, False, True, True),
    "DWAA_COMPRESSION": (False, True, False, True),
    "LJ2K_COMPRESSION": (False, True, False, True),
    "PXR24_COMPRESSION": (True, True, False, False),
    "HTJ2K32_COMPRESSION": (True, True, True, True),
    "ZSTD_COMPRESSION": (True, True, True, True),
}
holds = True
for codec, wanted in expected.items():
    found = tuple(keeps(codec, kind, names) for kind in (np.float16, np.float32) for names in ("RGB", ["Z", "N.X", "N.Z"]))
    number = int(getattr(OpenEXR, codec))
    print(f"{codec} ({number}): half colours, half data, float colours, float data kept: {found}")
    holds &= found == wanted
sys.exit(0 if holds else 1)
PY
