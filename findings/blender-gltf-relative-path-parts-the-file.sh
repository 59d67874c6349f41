#!/usr/bin/env bash
# Blender as a Python module: export_scene.gltf(filepath="NAME.gltf"), with a path that names no folder, writes NAME.gltf into the working
# folder, and its NAME.bin and images into the root of the file system. Expected: all of them beside each other, as the file's own
# references say.
# Seen, with Blender 5.2.3, as root; another user is refused the second file and is left with the first. An absolute path is right.
set -euo pipefail
. "$(dirname "$0")/blender.sh"
name=plane-$$
trap 'rm -rf "$folder" "/$name.bin"' EXIT
blender "$name" <<'PY' || true
import sys

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_plane_add()
bpy.ops.export_scene.gltf(filepath=f"{sys.argv[1]}.gltf", export_format="GLTF_SEPARATE")
PY
echo "$name.gltf in the working folder: $([ -e "$name.gltf" ] && echo yes || echo no)"
echo "$name.bin beside it: $([ -e "$name.bin" ] && echo yes || echo no), in /: $([ -e "/$name.bin" ] && echo yes || echo no)"
[ -e "$name.gltf" ] && [ ! -e "$name.bin" ]
