#!/usr/bin/env bash
# three.js, EXRExporter with half floats, which is its default: every number is cut off toward zero. Expected: the nearest half float, as
# OpenEXR's own library writes it, and infinity for infinity.
# Seen, with three.js 0.187.0: of 1022 numbers between 1 and 2, none is stored above what was given, and the mean is half of the last place
# too low. Infinity is stored as 65504. As 32-bit floats, all are exact. ToHalfFloat of Babylon.js 9.35.0 cuts off alike and keeps infinity.
# Pictures that go through such files more than once, with work in between, become darker.
set -euo pipefail

. "$(dirname "$0")/npm.sh" three@0.187.0 @babylonjs/core@9.35.0
cat >export.mjs <<'JS'
import { FromHalfFloat, ToHalfFloat } from "@babylonjs/core/Misc/textureTools.js";
import * as THREE from "three";
import { EXRExporter } from "three/examples/jsm/exporters/EXRExporter.js";
import { EXRLoader } from "three/examples/jsm/loaders/EXRLoader.js";

console.warn = () => {};
const WIDTH = 1024;
const PLACE = 2 ** -10; // of half floats between 1 and 2
const given = Array.from({ length: WIDTH - 2 }, (_, i) => 1 + (i + ((i % 16) + 0.5) / 16) / WIDTH);
const pixels = new Float32Array(4 * WIDTH);
[...given, 1e6, Infinity].forEach((value, i) => (pixels[4 * i] = value));
const texture = new THREE.DataTexture(pixels, WIDTH, 1, THREE.RGBAFormat, THREE.FloatType);

const describe = (values) => {
  const places = given.map((value, i) => (values[i] - value) / PLACE);
  const lean = places.reduce((sum, p) => sum + p, 0) / places.length;
  const above = places.filter((p) => p > 0).length;
  return { above, lean: Math.round(lean * 10) / 10 || 0, large: values[WIDTH - 2], infinity: values[WIDTH - 1] };
};
const exported = async (settings) => {
  const bytes = await new EXRExporter().parse(texture, settings);
  const { data } = new EXRLoader().setDataType(THREE.FloatType).parse(bytes.slice().buffer);
  return describe(Array.from({ length: WIDTH }, (_, i) => data[4 * i]));
};
const seen = {
  "three.js, default": await exported({}),
  "three.js, floats": await exported({ type: THREE.FloatType }),
  "Babylon.js": describe([...given, 1e6, Infinity].map((value) => FromHalfFloat(ToHalfFloat(value)))),
};
for (const [name, found] of Object.entries(seen)) console.log(name, found);
const [half, float, babylon] = Object.values(seen);
const low = ({ above, lean }) => above === 0 && lean === -0.5;
const holds = low(half) && low(babylon) && half.infinity === 65504 && half.large === 65504 && babylon.infinity === Infinity
  && float.infinity === Infinity && float.large === 1e6 && float.lean === 0;
if (!holds) console.error("this changed: half floats were cut off, and infinity was 65504 in three.js alone");
process.exit(holds ? 0 : 1);
JS
node export.mjs
