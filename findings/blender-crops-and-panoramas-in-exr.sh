#!/usr/bin/env bash
# Blender's multilayer OpenEXR files. A cropped region gets a display window of its own that begins at 0, 0, so that the file does not
# say where the region lay. OpenEXR's data window is for that. Panoramas have distances in Depth, and perspectives planar depth.
# Expected: the data window has the place of the region, and Depth means the same for every camera.
# Seen with Blender 5.2.3: the right upper quarter of 64×32 pixels has the display window [[0, 0], [31, 15]].
set -euo pipefail
. "$(dirname "$0")/blender.sh" openexr==3.5.3
blender "$folder" <<'PY'
import sys

import bpy
import numpy as np
import OpenEXR

folder = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
bpy.ops.mesh.primitive_cube_add(size=40)
bpy.ops.object.camera_add(location=(1, 2, 3), rotation=(1.2, 0.0, 0.4))
scene.camera = bpy.context.object
scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.render.resolution_x, scene.render.resolution_y = 64, 32
layer = scene.view_layers[0]
layer.use_pass_z = layer.use_pass_position = True
image = scene.render.image_settings
image.media_type, image.file_format, image.color_depth = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER", "32"
image.use_exr_interleave = True


def render(name):
    scene.render.filepath = f"{folder}/{name}.exr"
    bpy.ops.render.render(write_still=True)
    return OpenEXR.File(f"{folder}/{name}.exr", separate_channels=True)


scene.render.use_border = scene.render.use_crop_to_border = True
scene.render.border_min_x, scene.render.border_min_y = 0.5, 0.5
window = [side.tolist() for side in render("crop").header()["displayWindow"]]
print("crop", window)
scene.render.use_border = False


def off(name, planar):
    channels = render(name).channels()
    place = np.stack([channels[f"ViewLayer.Position.{axis}"].pixels for axis in "XYZ"], axis=-1)
    to = place - np.array(scene.camera.matrix_world.translation)
    forward = -np.array(scene.camera.matrix_world.col[2][:3])
    expected = to @ forward if planar else np.linalg.norm(to, axis=-1)
    return float(abs(channels["ViewLayer.Depth.Z"].pixels - expected).max())


perspective = off("perspective", True)
scene.camera.data.type, scene.camera.data.panorama_type = "PANO", "EQUIRECTANGULAR"
panorama = off("panorama", False)
print(f"perspective: off the planar depth by {perspective:.3f} m; panorama: off the distance by {panorama:.3f} m")
holds = window == [[0, 0], [31, 15]] and perspective < 0.2 and panorama < 0.2
print("holds" if holds else "changed")
PY
grep -v 'Blender\|INFO\|render  \|Fra:' log | tail -8
grep -q '^holds$' log
