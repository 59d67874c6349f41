#!/usr/bin/env bash
# trimesh, which loads an OBJ file with its MTL file and exports glTF. Expected: a surface that is no metal, since MTL's Kd, Ks and Ns
# describe none; and the roughness and metalness of a material that states both, as Blender writes them (Pr, Pm).
# Seen, with trimesh 5.2.0: no material has a metallicFactor, whose default in glTF is 1, so that every surface is a metal that reflects
# in the colour of Kd. Pr and Pm are read and left out: the roughness comes from Ns alone, as the fourth root of 2 / (Ns + 2).
set -euo pipefail

. "$(dirname "$0")/python.sh" trimesh==5.2.0 numpy==2.4.6 pillow==12.0.0
cat >scene.mtl <<'MTL'
newmtl plastic
Kd 0.5 0.5 0.5
Ks 0.04 0.04 0.04
Ns 100

newmtl steel
Kd 0.5 0.5 0.5
Ns 100
Pr 0.25
Pm 1
MTL
cat >scene.obj <<'OBJ'
mtllib scene.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
usemtl plastic
f 1 2 3
usemtl steel
f 1 2 4
OBJ
venv/bin/python - <<'PY'
import json
import sys

import trimesh

scene = trimesh.load("scene.obj", force="scene")
kept = {name: mesh.visual.material.kwargs for name, mesh in scene.geometry.items()}
print("read beside Kd, Ks and Ns:", {name: {k: kwargs[k] for k in ("pr", "pm") if k in kwargs} for name, kwargs in kept.items()})
materials = json.loads(trimesh.exchange.gltf.export_gltf(scene)["model.gltf"])["materials"]
factors = [m["pbrMetallicRoughness"] for m in materials]
for m, pbr in zip(materials, factors):
    print(m.get("name", "a material without a name"), {k: v for k, v in pbr.items() if k != "baseColorFactor"})
root = (2 / 102) ** 0.25
if any("metallicFactor" in pbr or abs(pbr["roughnessFactor"] - root) > 1e-6 for pbr in factors) or len(factors) != 2:
    sys.exit("this changed: two materials without a metallicFactor, as rough as Ns says, were seen")
PY
