#!/usr/bin/env bash
# gltf-transform png: the command that writes textures as PNG leaves AVIF images as they are and reports success, since its option
# --formats does not name AVIF by default. Expected: a command named after a format brings every image to it, or says which it left.
set -euo pipefail

. "$(dirname "$0")/npm.sh" @gltf-transform/cli@4.5.1 sharp@0.34.4
node - <<'JS'
const sharp = require("sharp");
const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);
const uvs = new Float32Array([0, 0, 1, 0, 0, 1]);
(async () => {
  const png = await sharp({ create: { width: 16, height: 16, channels: 3, background: { r: 200, g: 80, b: 40 } } }).png().toBuffer();
  const bytes = Buffer.concat([Buffer.from(positions.buffer), Buffer.from(uvs.buffer)]);
  require("fs").writeFileSync("in.gltf", JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }], textures: [{ source: 0 }],
    images: [{ uri: "data:image/png;base64," + png.toString("base64") }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 3, type: "VEC2" }],
    bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: 24 }],
    buffers: [{ byteLength: 60, uri: "data:application/octet-stream;base64," + bytes.toString("base64") }],
  }));
})();
JS
npx gltf-transform avif in.gltf avif.glb >/dev/null
npx gltf-transform png avif.glb png.glb
npx gltf-transform png avif.glb all.glb --formats '*' >/dev/null
printf 'gltf-transform %s\n' "$(npx gltf-transform --version)"
node - <<'JS'
const kind = (file) => {
  const bytes = require("fs").readFileSync(file);
  return JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12))).images[0].mimeType;
};
const [plain, all] = [kind("png.glb"), kind("all.glb")];
console.log(`after png: ${plain}; after png --formats "*": ${all}`);
process.exit(plain === "image/avif" && all === "image/png" ? 0 : 1);
JS
