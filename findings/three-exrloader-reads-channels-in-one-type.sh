#!/usr/bin/env bash
# three.js' EXRLoader and an OpenEXR file whose channels have different types, such as colour as half floats beside an alpha of 32-bit
# floats, or one colour that is half as precise as the others. Expected: each channel read as its own type, or an error.
# Seen, with three 0.187.0 and files of OpenEXR 3.5.3: every channel is read as the type of R, without an error, whatever the compression.
# An alpha of 1 beside half floats becomes 0 and 1.875, and a green of 0, 1, 2, 3 between 32-bit floats becomes numbers such as 32.06.
# Images that are exchanged with three.js should therefore have one type for all channels.
set -euo pipefail

. "$(dirname "$0")/python.sh" openexr==3.5.3 numpy==2.4.6
npm init -y >/dev/null
npm install --silent --no-fund --no-audit three@0.187.0 >/dev/null
venv/bin/python - <<'PY'
import numpy as np
import OpenEXR

HEIGHT, WIDTH = 4, 6
row = np.repeat(np.arange(HEIGHT, dtype=np.float32)[:, None], WIDTH, axis=1)
column = np.repeat(np.arange(WIDTH, dtype=np.float32)[None, :], HEIGHT, axis=0)
values = {"R": column, "G": row, "B": np.full_like(row, 0.25), "A": np.ones_like(row)}
files = {"one-type": "", "float-alpha": "RGB", "half-green": "G"}
for name, halves in files.items():
    for codec in ("NO", "ZIP", "PIZ"):
        header = {"compression": getattr(OpenEXR, f"{codec}_COMPRESSION"), "type": OpenEXR.scanlineimage}
        channels = {n: v.astype(np.float16 if n in halves else np.float32) for n, v in values.items()}
        with OpenEXR.File(header, channels) as file:
            file.write(f"{name}-{codec}.exr")
PY
cat >read.mjs <<'JS'
import fs from 'node:fs';
import { FloatType } from 'three';
import { EXRLoader } from 'three/examples/jsm/loaders/EXRLoader.js';

// How many pixels of each channel differ from what was written; the loader turns images upside down.
const wrong = {};
for (const name of ['one-type', 'float-alpha', 'half-green']) {
    for (const codec of ['NO', 'ZIP', 'PIZ']) {
        const bytes = fs.readFileSync(`${name}-${codec}.exr`);
        const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
        const { data, width, height } = new EXRLoader().setDataType(FloatType).parse(buffer);
        const counts = [0, 0, 0, 0];
        for (let y = 0; y < height; ++y)
            for (let x = 0; x < width; ++x)
                [x, height - 1 - y, 0.25, 1].forEach((expected, channel) => {
                    counts[channel] += data[4 * (y * width + x) + channel] !== expected;
                });
        wrong[`${name} ${codec}`] = counts.join(' ');
        const last = 4 * (width - 1);
        console.log(`${name}, ${codec}: wrong pixels in R G B A: ${counts.join(' ')} of ${width * height}; last of the row`,
            Array.from(data.slice(last, last + 4)));
    }
}
const seen = { 'one-type': /^0 0 0 0$/, 'float-alpha': /^0 0 0 [1-9]\d*$/, 'half-green': /^0 [1-9]\d* 0 0$/ };
if (!Object.entries(wrong).every(([key, counts]) => seen[key.split(' ')[0]].test(counts))) {
    console.error('this changed: the channel of another type alone was wrong');
    process.exit(1);
}
JS
node read.mjs
