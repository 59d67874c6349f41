#!/usr/bin/env python3
"""Makes docs/four.png, the picture at the top of the README: one view as direct light alone, by `ssct`, by `unified`
and as the truth (the world reference). Each is rendered with four times the rows and columns and averaged down, the truth
like the others, so that no picture owes its smoothness to anything but the method.

Needs Pillow (python3 -m pip install pillow), a release build of ssct, and a few minutes, nearly all for the truth.

Usage: scripts/picture.py [OUT.png]        SSCT=path/to/ssct in the environment names another program
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = os.environ.get("SSCT", str(ROOT / "target/release/ssct"))
WIDTH, HEIGHT, FINER = 480, 270, 4
GAP, CAPTION = 6, 24

VIEW = ["--scene", "rooms", "--view", "corridor", "--roughness", "0.1", "--size", f"{WIDTH * FINER}x{HEIGHT * FINER}"]
# The truth takes at most 32 rays for each rendered pixel. Each pixel of the picture averages 4 x 4 of
# these, and so at most 512 rays.
PICTURES = [
    ("direct light", ["--reflectivity", "0"]),
    ("ssct, the thesis's method", ["--method", "ssct"]),
    ("unified, this project's method", ["--method", "unified"]),
    ("truth: rays through the triangles", ["--method", "reference", "--standard-error", "0.05", "--max-rays", "32"]),
]


def main():
    """Renders the pictures, each with its caption below, and writes them as one sheet of two columns."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs/four.png"
    font = ImageFont.load_default(size=15)
    sheet = Image.new("RGB", (2 * WIDTH + GAP, 2 * (HEIGHT + CAPTION) + GAP), "white")
    draw = ImageDraw.Draw(sheet)
    with tempfile.TemporaryDirectory() as folder:
        for n, (caption, options) in enumerate(PICTURES):
            file = Path(folder) / f"{n}.png"
            cache = ["--cache", folder] if "reference" in options else []
            subprocess.run([PROGRAM, "render", *VIEW, *options, *cache, "-o", str(file)], check=True)
            left, top = (n % 2) * (WIDTH + GAP), (n // 2) * (HEIGHT + CAPTION + GAP)
            sheet.paste(Image.open(file).convert("RGB").resize((WIDTH, HEIGHT), Image.Resampling.BOX), (left, top))
            draw.text((left + 2, top + HEIGHT + 3), caption, fill="black", font=font)
    # 256 colours take a third of the bytes, and the eye sees no difference.
    sheet.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(out, optimize=True)


main()
