#!/usr/bin/env bash
# Renders one room from six files, and joins the pictures to one (docs/formats.md). The files are glTF, OBJ, OBJ with PBR
# extensions, glTF with meshes packed by meshopt, glTF with copies by EXT_mesh_gpu_instancing, and the G-buffer that Cycles
# renders.
#   scripts/room_pictures.sh SSCT ROOM.glb FOLDER    PYTHON is a Python 3.13 with bpy 5.2.3, numpy and pillow
# It needs npm for gltf-transform, which packs the meshes.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
ssct=$(realpath "$1")
room=$(realpath "$2")
mkdir -p "$3"
folder=$(realpath "$3")
here=$(dirname "$(realpath "$0")")
size=480x270

"$PYTHON" "$here/room_files.py" "$room" "$folder" --size "$size" --samples 64 >"$folder/blender.log" 2>&1
npx --yes @gltf-transform/cli@4.5.1 meshopt "$room" "$folder/meshopt.glb" >/dev/null
cp "$room" "$folder/room.glb"
# OBJ has no lights and no camera. The scene files of the OBJ files therefore have the lights and the camera of the glTF file.
for scene in room.glb plain.scene.toml pbr.scene.toml meshopt.glb instanced.glb; do
    "$ssct" render --scene "$folder/$scene" --method unified --size "$size" -o "$folder/${scene%%.*}.png"
done
"$ssct" gbuffer reflect "$folder/room.exr" --gbuffer-map "$folder/map.toml" --method unified -o "$folder/exr.png"
"$PYTHON" - "$folder" <<'PY'
import sys

from PIL import Image, ImageDraw

folder = sys.argv[1]
names = [("room", "glTF"), ("plain", "OBJ of Blender"), ("pbr", "OBJ with PBR keys"), ("meshopt", "glTF, meshopt"),
         ("instanced", "glTF, instanced"), ("exr", "G-buffer of Cycles")]
images = [(Image.open(f"{folder}/{name}.png").convert("RGB"), label) for name, label in names]
width, height = images[0][0].size
sheet = Image.new("RGB", (3 * width + 8, 2 * height + 4), "white")
for k, (image, label) in enumerate(images):
    ImageDraw.Draw(image).text((8, 6), label, fill="white", stroke_width=2, stroke_fill="black")
    sheet.paste(image, (k % 3 * (width + 4), k // 3 * (height + 4)))
sheet.save(f"{folder}/formats.png")
PY
echo "$folder/formats.png"
