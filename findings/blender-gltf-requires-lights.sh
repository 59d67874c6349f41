#!/usr/bin/env bash
# Blender's glTF exporter lists KHR_lights_punctual as required in every file with a light, so that a viewer that knows no lights must
# refuse the whole file. Expected: the extension is used and not required, since a scene without its lights is still that scene.
# Seen, with Blender 5.2.3: one lamp beside one plane makes the extension required. A lamp that is an area is no light in glTF: it
# becomes an empty node without a word, and the extension is then neither used nor required.
set -euo pipefail
. "$(dirname "$0")/blender.sh"
blender <<'PY'
import os

import bpy

for kind in ("POINT", "AREA"):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add()
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", kind))
    bpy.context.collection.objects.link(lamp)
    bpy.ops.export_scene.gltf(filepath=os.path.abspath(f"{kind}.gltf"), export_format="GLTF_SEPARATE", export_lights=True)
PY
venv/bin/python - <<'PY'
import json

said = []
for kind in ("POINT", "AREA"):
    with open(f"{kind}.gltf") as file:
        made = json.load(file)
    lamp = next(node for node in made["nodes"] if node["name"] == "Lamp")
    said.append(f"{kind}: used {made.get('extensionsUsed')}, required {made.get('extensionsRequired')}, lamp {sorted(lamp)}")
print("\n".join(said))
lights = "['KHR_lights_punctual']"
holds = said[0].startswith(f"POINT: used {lights}, required {lights}") and said[1].startswith("AREA: used None, required None")
raise SystemExit(0 if holds else 1)
PY
