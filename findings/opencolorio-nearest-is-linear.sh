#!/usr/bin/env bash
# OpenColorIO: the interpolation "nearest" of look-up tables is accepted, kept, given back, and not done. Tables are interpolated
# linearly, in memory and from files, on the CPU and in shaders. Expected: the nearest entry, or the error that "cubic" gives.
# Seen, with OpenColorIO 2.6.0: a table of 0, 0.2 and 1 gives 0.52 for 0.7 and not 0.2. A table of three dimensions gives 0.7 and not 1,
# and its texture for the shader is declared linear. So a table of classes or steps becomes a ramp, without a word.
set -euo pipefail

. "$(dirname "$0")/python.sh" opencolorio==2.6.0 numpy==2.3.4
printf 'Version 1\nFrom 0.0 1.0\nLength 3\nComponents 1\n{\n0.0\n0.2\n1.0\n}\n' >steps.spi1d
printf 'LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n' >cube.cube
venv/bin/python - <<'PY'
import sys

import PyOpenColorIO as ocio

config = ocio.Config.CreateRaw()


def red(transform):
    """Red of 0.7 behind the transform, without any of the faster and less exact ways."""
    found = config.getProcessor(transform).getOptimizedCPUProcessor(ocio.OPTIMIZATION_NONE).applyRGB([0.7, 0.7, 0.7])
    return round(found[0], 3)


table = ocio.Lut1DTransform(length=3, inputHalfDomain=False)
for i, value in enumerate((0.0, 0.2, 1.0)):
    table.setValue(i, value, value, value)
table.setInterpolation(ocio.INTERP_NEAREST)
cube = ocio.FileTransform("cube.cube", interpolation=ocio.INTERP_NEAREST)
shader = ocio.GpuShaderDesc.CreateShaderDesc()
config.getProcessor(cube).getOptimizedGPUProcessor(ocio.OPTIMIZATION_NONE).extractGpuShaderInfo(shader)
seen = {
    "table": (red(table), table.getInterpolation().name),
    "file of one dimension": red(ocio.FileTransform("steps.spi1d", interpolation=ocio.INTERP_NEAREST)),
    "file of three": (red(cube), cube.getInterpolation().name),
    "its texture": [texture.interpolation.name for texture in shader.get3DTextures()],
}
try:
    table.setInterpolation(ocio.INTERP_CUBIC)
    seen["cubic"] = red(table)
except ocio.Exception as error:
    seen["cubic"] = str(error)
for name, found in seen.items():
    print(f"{name}: {found}")
wanted = [(0.52, "INTERP_NEAREST"), 0.52, (0.7, "INTERP_NEAREST"), ["INTERP_LINEAR"]]
if list(seen.values())[:4] != wanted or "does not support" not in str(seen["cubic"]):
    sys.exit(f"this changed: it was {wanted}, and an error for cubic")
PY
