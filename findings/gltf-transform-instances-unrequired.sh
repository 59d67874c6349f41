#!/usr/bin/env bash
# gltf-transform optimize: five nodes with one mesh or more become EXT_mesh_gpu_instancing, whose copies exist in the extension
# alone. The extension is listed as used and not as required, so that a viewer without the extension shows one of twenty
# copies and reports no error. Expected: what moves geometry is required, as the meshopt compression of the same file is.
set -euo pipefail

. "$(dirname "$0")/npm.sh" @gltf-transform/cli@4.5.1
node - <<'JS'
const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);
const nodes = [...Array(20).keys()].map((k) => ({ mesh: 0, translation: [2 * k, 0, 0] }));
require("fs").writeFileSync("in.gltf", JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: nodes.map((_, k) => k) }], nodes,
  meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
  bufferViews: [{ buffer: 0, byteLength: 36 }],
  buffers: [{ byteLength: 36, uri: "data:application/octet-stream;base64," + Buffer.from(positions.buffer).toString("base64") }],
}));
JS
npx gltf-transform optimize in.gltf out.glb >/dev/null
printf 'gltf-transform %s\n' "$(npx gltf-transform --version)"
node - <<'JS'
const bytes = require("fs").readFileSync("out.glb");
const made = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));
const placing = made.nodes.filter((node) => node.mesh !== undefined).length;
console.log(`nodes with a mesh: ${placing} of 20`);
console.log(`used: ${made.extensionsUsed}`);
console.log(`required: ${made.extensionsRequired}`);
const name = "EXT_mesh_gpu_instancing";
const holds = placing === 1 && made.extensionsUsed.includes(name) && !made.extensionsRequired.includes(name);
process.exit(holds ? 0 : 1);
JS
