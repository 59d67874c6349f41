#!/usr/bin/env bash
# obj2gltf: the PBR keys of MTL (Pr, Pm) are ignored. A rough metal becomes a dielectric of roughness 1; with --metallicRoughness, Ks
# becomes the metalness and Ns the roughness as it stands, so that a plain MTL file gives a roughnessFactor of 900, which glTF 2.0
# does not allow. Expected: Pr and Pm are roughnessFactor and metallicFactor, or the value is clamped.
set -euo pipefail

. "$(dirname "$0")/npm.sh" obj2gltf@3.2.0
printf 'mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl metal\nf 1 2 3\nusemtl shiny\nf 1 3 2\n' >a.obj
printf 'newmtl metal\nKd 0.8 0.6 0.4\nPr 0.25\nPm 1.0\nnewmtl shiny\nKd 0.2 0.2 0.2\nKs 0.5 0.5 0.5\nNs 900\n' >a.mtl
npx obj2gltf -i a.obj -o plain.gltf >/dev/null
npx obj2gltf -i a.obj -o metallic.gltf --metallicRoughness >/dev/null
printf 'obj2gltf %s\n' "$(npx obj2gltf --version)"
node - <<'JS'
const of = (file, name) =>
  JSON.parse(require("fs").readFileSync(file)).materials.find((m) => m.name === name).pbrMetallicRoughness;
const metal = of("plain.gltf", "metal"), shiny = of("metallic.gltf", "shiny");
console.log(`Pr 0.25, Pm 1: roughnessFactor ${metal.roughnessFactor}, metallicFactor ${metal.metallicFactor}`);
console.log(`Ns 900, Ks 0.5 with --metallicRoughness: roughnessFactor ${shiny.roughnessFactor}, metallicFactor ${shiny.metallicFactor}`);
const holds = metal.roughnessFactor === 1 && metal.metallicFactor === 0 && shiny.roughnessFactor === 900;
process.exit(holds ? 0 : 1);
JS
