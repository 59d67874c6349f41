#!/usr/bin/env bash
# Blender's glTF exporter follows a link to an image through nodes that glTF has no word for, and leaves out what they do. A map of
# glossiness that an Invert node makes one of roughness is written as it is: what is smooth in Blender is rough in the file.
# Expected: the inverted image, the factor alone, or a warning.
# Seen, with Blender 5.2.3: an image of 0.25, inverted, is roughness 0.75 in Blender, and its map in the file has 64 of 255, with the
# factor 1. Nothing is said.
set -euo pipefail
. "$(dirname "$0")/blender.sh" pillow==12.0.0
blender <<'PY'
import os

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_plane_add()
material = bpy.data.materials.new("floor")
bpy.context.object.data.materials.append(material)
tree = material.node_tree
image = bpy.data.images.new("gloss", 4, 4)
image.colorspace_settings.name = "Non-Color"
image.pixels = [0.25, 0.25, 0.25, 1.0] * 16
texture, invert = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeInvert")
texture.image = image
tree.links.new(texture.outputs["Color"], invert.inputs["Color"])
tree.links.new(invert.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Roughness"])
bpy.ops.export_scene.gltf(filepath=os.path.abspath("floor.gltf"), export_format="GLTF_SEPARATE")
PY
grep -i 'warn' log || true
venv/bin/python - <<'PY'
import json

from PIL import Image

with open("floor.gltf") as file:
    made = json.load(file)
pbr = made["materials"][0]["pbrMetallicRoughness"]
source = made["textures"][pbr["metallicRoughnessTexture"]["index"]]["source"]
green = Image.open(made["images"][source]["uri"]).convert("RGB").getpixel((0, 0))[1]
print(f"roughness map {green} of 255, factor {pbr.get('roughnessFactor', 1)}")
raise SystemExit(0 if green in (63, 64) and "roughnessFactor" not in pbr else 1)
PY
