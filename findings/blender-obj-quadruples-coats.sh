#!/usr/bin/env bash
# Blender's OBJ exporter with PBR extensions: Pc is four times the weight of the coat, so that a weight of 0.5 is written as 2, while Ps is
# the weight of the sheen as it stands. Without the extensions, Ks is the level of specular, 0.5 for every default material, whose
# reflection along the normal is 0.04. Expected: Pc is the weight, 0 to 1, and Ks the specular colour.
set -euo pipefail
. "$(dirname "$0")/blender.sh"
blender <<'PY'
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
for weight in (0.0, 0.25, 0.5, 1.0):
    made = bpy.data.materials.new(f"coat{weight}")
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Coat Weight"].default_value = shader.inputs["Sheen Weight"].default_value = weight
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.data.materials.append(made)
bpy.ops.wm.obj_export(filepath="pbr.obj", export_pbr_extensions=True)
bpy.ops.wm.obj_export(filepath="plain.obj")
PY
found=$(awk '/^newmtl/ {name = $2} /^P[cs] / {printf "%s %s %.2f; ", name, $1, $2}' pbr.mtl)
printf '%s\n' "$found"
grep '^Ks' plain.mtl | sort | uniq -c
[ "$found" = "coat0.0 Ps 0.00; coat0.0 Pc 0.00; coat0.25 Ps 0.25; coat0.25 Pc 1.00; coat0.5 Ps 0.50; coat0.5 Pc 2.00; coat1.0 Ps 1.00; coat1.0 Pc 4.00; " ]
[ "$(grep '^Ks' plain.mtl | sort -u)" = "Ks 0.500000 0.500000 0.500000" ]
