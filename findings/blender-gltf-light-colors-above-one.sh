#!/usr/bin/env bash
# Blender's glTF exporter puts the temperature of a lamp into its colour, whose red part then is above 1. Expected: 0 to 1, as the schema
# of KHR_lights_punctual bounds each part, with the rest in the intensity.
# Seen, with Blender 5.2.3: a white lamp of 3000 K has the colour 1.77, 0.84, 0.27. A reader that clamps it makes the lamp dimmer and
# less red, and one that checks the schema refuses the file.
set -euo pipefail
. "$(dirname "$0")/blender.sh"
blender <<'PY'
import os

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
light = bpy.data.lights.new("Lamp", "POINT")
light.use_temperature, light.temperature = True, 3000
bpy.context.collection.objects.link(bpy.data.objects.new("Lamp", light))
bpy.ops.export_scene.gltf(filepath=os.path.abspath("lamp.gltf"), export_format="GLTF_SEPARATE", export_lights=True)
PY
venv/bin/python - <<'PY'
import json

with open("lamp.gltf") as file:
    color = json.load(file)["extensions"]["KHR_lights_punctual"]["lights"][0]["color"]
print("colour", [round(part, 2) for part in color])
raise SystemExit(0 if color[0] > 1.5 else 1)
PY
