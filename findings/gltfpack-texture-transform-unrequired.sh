#!/usr/bin/env bash
# gltfpack: texture coordinates become whole numbers of 16 bits, which are right through KHR_texture_transform alone. The extension is
# listed as used and not as required, so that a viewer without it shows a sixteenth of one repeat of a texture in place of 16 repeats, and
# reports no error. Expected: what every texture coordinate of the file depends on is required, as KHR_mesh_quantization of the same file is.
# Seen, with gltfpack 1.3.0: coordinates from 0 to 16 are stored as 0 to 1/16, since they have 12 bits of the 16, and a transform of the
# material multiplies them by 256.
set -euo pipefail

. "$(dirname "$0")/npm.sh" gltfpack@1.3.0
node - <<'JS'
const numbers = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 16, 0, 0, 16]);
const pixel = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";
require("fs").writeFileSync("in.gltf", JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, material: 0 }] }],
  materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }],
  textures: [{ source: 0 }], images: [{ uri: "data:image/png;base64," + pixel }],
  accessors: [
    { bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
    { bufferView: 1, componentType: 5126, count: 3, type: "VEC2" },
  ],
  bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: 24 }],
  buffers: [{ byteLength: 60, uri: "data:application/octet-stream;base64," + Buffer.from(numbers.buffer).toString("base64") }],
}));
JS
npx gltfpack -i in.gltf -o out.glb >/dev/null
npx gltfpack -v 2>&1 | head -n 1
node - <<'JS'
const bytes = require("fs").readFileSync("out.glb");
const made = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));
const coordinates = made.accessors[made.meshes[0].primitives[0].attributes.TEXCOORD_0];
const texture = made.materials[0].pbrMetallicRoughness.baseColorTexture;
const name = "KHR_texture_transform";
const scale = texture.extensions?.[name]?.scale[1];
console.log(`coordinates: component type ${coordinates.componentType}, normalised ${coordinates.normalized === true}, times ${scale}`);
console.log(`used: ${made.extensionsUsed}`);
console.log(`required: ${made.extensionsRequired}`);
const holds = coordinates.componentType === 5123 && scale > 255 && scale < 257 && made.extensionsUsed.includes(name)
  && !made.extensionsRequired.includes(name);
process.exit(holds ? 0 : 1);
JS
