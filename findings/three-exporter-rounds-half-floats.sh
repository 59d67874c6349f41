#!/usr/bin/env bash
# three.js, GLTFExporter and attributes of half floats (Float16BufferAttribute), which the renderer draws as any others: each number is
# cut off to a whole one. Expected: floats of 32 bits, which hold every half float, or an error, since glTF has no half floats.
# Seen, with three.js 0.187.0: x of 0.25, 0.75 and 1.5 become 0, 0 and 1, as integers of 16 bits. The exporter says nothing. The least and
# greatest values in the file are still 0.25 and 1.5, so that Khronos's glTF-Validator finds errors in what was made.
set -euo pipefail

. "$(dirname "$0")/npm.sh" three@0.187.0 gltf-validator@2.0.0-dev.3.10
cat >export.mjs <<'JS'
import * as THREE from "three";
import { GLTFExporter } from "three/examples/jsm/exporters/GLTFExporter.js";
import validator from "gltf-validator";

// The one part of a browser that the exporter needs.
globalThis.FileReader = class {
  async readAsDataURL(blob) {
    this.result = "data:application/octet-stream;base64," + Buffer.from(await blob.arrayBuffer()).toString("base64");
    this.onloadend();
  }
};
const numbers = [0.25, 0.5, 0, 0.75, 0.5, 0, 1.5, 1, 0];
const kinds = {
  float: new THREE.Float32BufferAttribute(numbers, 3),
  half: new THREE.Float16BufferAttribute(numbers.map(THREE.DataUtils.toHalfFloat), 3),
};
const seen = {};
for (const [kind, attribute] of Object.entries(kinds)) {
  const geometry = new THREE.BufferGeometry().setAttribute("position", attribute);
  const inside = [0, 1, 2].map((i) => attribute.getX(i));
  const gltf = await new GLTFExporter().parseAsync(new THREE.Mesh(geometry));
  const accessor = gltf.accessors[gltf.meshes[0].primitives[0].attributes.POSITION];
  const view = gltf.bufferViews[accessor.bufferView];
  const bytes = Buffer.from(gltf.buffers[0].uri.split(",")[1], "base64").subarray(view.byteOffset ?? 0);
  const isFloat = accessor.componentType === 5126;
  const read = (i) => (isFloat ? bytes.readFloatLE(i * (view.byteStride ?? 12)) : bytes.readUInt16LE(i * view.byteStride));
  const { numErrors } = (await validator.validateString(JSON.stringify(gltf))).issues;
  seen[kind] = `x ${inside} in three.js, ${[0, 1, 2].map(read)} in the file of type ${accessor.componentType}, errors ${numErrors > 0}`;
  console.log(`${kind}: ${seen[kind]}`);
}
const holds = seen.float === "x 0.25,0.75,1.5 in three.js, 0.25,0.75,1.5 in the file of type 5126, errors false"
  && seen.half === "x 0.25,0.75,1.5 in three.js, 0,0,1 in the file of type 5123, errors true";
if (!holds) console.error("this changed: half floats became 0, 0 and 1 of the type 5123");
process.exit(holds ? 0 : 1);
JS
node export.mjs
