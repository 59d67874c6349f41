#!/usr/bin/env bash
# MTL, the materials of OBJ: a colour of 0.5 (Kd) is half of the light, or a number on the curve of sRGB, by the reader. Expected: one
# reading, which the glTF that is made of the file shows, since the factors of glTF are linear.
# Seen: obj2gltf 3.2.0 and trimesh 5.2.0 take 0.5 as linear, and trimesh rounds it to a byte on the way (128/255). three.js 0.187.0
# takes it as sRGB, so that its GLTFExporter writes 0.214. It does so with Ks and Ke too: the reflection of plastic, 0.04, becomes
# 0.003, and a lamp of 0.5 shines with 0.214. trimesh's glTF has no emission.
set -euo pipefail

. "$(dirname "$0")/npm.sh" three@0.187.0 obj2gltf@3.2.0
python3 -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 numpy==2.4.6 pillow==12.0.0
printf 'newmtl plastic\nKd 0.5 0.5 0.5\nKs 0.04 0.04 0.04\nKe 0.5 0.5 0.5\nNs 100\n' >scene.mtl
printf 'mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl plastic\nf 1 2 3\n' >scene.obj
node node_modules/obj2gltf/bin/obj2gltf.js -i scene.obj -o obj2gltf.gltf >/dev/null
venv/bin/python - <<'PY'
import trimesh

made = trimesh.exchange.gltf.export_gltf(trimesh.load("scene.obj", force="scene"))
with open("trimesh.gltf", "wb") as file:
    file.write(made["model.gltf"])
PY
cat >read.mjs <<'JS'
import fs from "fs";
import * as THREE from "three";
import { GLTFExporter } from "three/examples/jsm/exporters/GLTFExporter.js";
import { MTLLoader } from "three/examples/jsm/loaders/MTLLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";

// The one part of a browser that the exporter needs.
globalThis.FileReader = class {
  async readAsDataURL(blob) {
    this.result = "data:application/octet-stream;base64," + Buffer.from(await blob.arrayBuffer()).toString("base64");
    this.onloadend();
  }
};
console.warn = () => {};
const materials = new MTLLoader().parse(fs.readFileSync("scene.mtl", "utf8"), "");
materials.preload();
const scene = new OBJLoader().setMaterials(materials).parse(fs.readFileSync("scene.obj", "utf8"));
const phong = materials.materials.plastic;
const files = {
  obj2gltf: JSON.parse(fs.readFileSync("obj2gltf.gltf", "utf8")),
  trimesh: JSON.parse(fs.readFileSync("trimesh.gltf", "utf8")),
  "three.js": await new GLTFExporter().parseAsync(scene),
};
const seen = {};
for (const [name, { materials: [{ pbrMetallicRoughness: { baseColorFactor }, emissiveFactor }] }] of Object.entries(files)) {
  seen[name] = `${baseColorFactor[0].toFixed(4)} ${emissiveFactor ? emissiveFactor[0].toFixed(4) : "none"}`;
  console.log(`${name}: base colour and emission in glTF ${seen[name]}`);
}
seen.specular = phong.specular.r.toFixed(4);
console.log(`three.js ${THREE.REVISION}: Ks of 0.04 is ${seen.specular}`);
const wanted = { obj2gltf: "0.5000 0.5000", trimesh: "0.5020 none", "three.js": "0.2140 0.2140", specular: "0.0031" };
const holds = JSON.stringify(seen) === JSON.stringify(wanted);
if (!holds) console.error(`this changed: it was ${JSON.stringify(wanted)}`);
process.exit(holds ? 0 : 1);
JS
node read.mjs
