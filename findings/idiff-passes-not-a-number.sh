#!/usr/bin/env bash
# OpenImageIO's idiff and ImageBufAlgo.compare, which many renderers use to test their pictures: a pixel that is not a number differs from
# nothing. Expected: NaN where the reference has a number is a failure, as any other wrong value is.
# Seen, with OpenImageIO 3.2.2: a picture of nothing but NaN passes against a reference of 5, with the exit code 0 and without a word. One
# infinite value passes too, although the API states an infinite greatest error. One value of 5.4 fails.
set -euo pipefail

. "$(dirname "$0")/python.sh" openimageio==3.2.2.0 numpy==2.3.4
venv/bin/python - <<'PY'
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio


def write(name, values):
    image = oiio.ImageBuf(oiio.ImageSpec(16, 16, 3, oiio.FLOAT))
    image.set_pixels(oiio.ROI(0, 16, 0, 16, 0, 1, 0, 3), values.astype(np.float32))
    image.write(name)
    return image


reference = np.full((16, 16, 3), 5.0)
expected = write("reference.exr", reference)
seen = []
for kind, value, share in (("all NaN", np.nan, 1.0), ("one NaN", np.nan, 0.0), ("one infinite", np.inf, 0.0), ("one 5.4", 5.4, 0.0)):
    values = reference.copy()
    values[0, 0, 0] = value
    if share:
        values[:] = value
    result = oiio.ImageBufAlgo.compare(expected, write("picture.exr", values), 1e-6, 1e-6)
    run = subprocess.run(["venv/bin/idiff", "reference.exr", "picture.exr"], capture_output=True, text=True)
    word = run.stdout.split()[-1]
    seen.append(f"{kind}: {word}, exit code {run.returncode}; API: {result.nfail} pixels fail, greatest error {result.maxerror:.2g}")
print("\n".join(seen))
wanted = [
    "all NaN: PASS, exit code 0; API: 0 pixels fail, greatest error nan",
    "one NaN: PASS, exit code 0; API: 0 pixels fail, greatest error inf",
    "one infinite: PASS, exit code 0; API: 0 pixels fail, greatest error inf",
    "one 5.4: FAILURE, exit code 2; API: 1 pixels fail, greatest error 0.4",
]
if seen != wanted:
    sys.exit("this changed: it was\n" + "\n".join(wanted))
PY
