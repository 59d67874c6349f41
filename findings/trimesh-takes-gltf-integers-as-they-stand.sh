#!/usr/bin/env bash
# trimesh and glTF 2.0: two parts of accessors are ignored without a word. "normalized" is one, so that texture coordinates of 16 bits
# are 65535 and not 1, and colours of 16 bits keep their lower byte. "sparse" is the other, so that the vertices it replaces stay.
# Expected: the values of the specification, since both belong to glTF itself and not to an extension, or an error.
# Seen, with trimesh 5.1.0: the texture coordinates (1, 0.5) become (65535, 32769), half of red becomes no red, and a vertex of the
# height 9 stays at 0. Khronos's glTF-Validator finds no error in the three files.
set -euo pipefail

. "$(dirname "$0")/npm.sh" gltf-validator@2.0.0-dev.3.10
python3 -m venv venv
venv/bin/pip install --quiet trimesh==5.1.0 numpy==2.3.4 pillow==12.0.0
venv/bin/python - <<'PY'
import base64
import json
import subprocess
import sys

import numpy as np
import trimesh

PIXEL = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
CHECK = """
require("gltf-validator").validateString(require("fs").readFileSync("in.gltf", "utf8"))
  .then((report) => process.exit(report.issues.numErrors));
"""


def load(attribute, values, accessor, **more):
    """A triangle with one more attribute, as trimesh reads it."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    parts = [positions, *values]
    views, offset = [], 0
    for part in parts:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": part.nbytes})
        offset += part.nbytes
    data = b"".join(part.tobytes() for part in parts)
    primitive = {"attributes": {"POSITION": 0, attribute: 1}, **({"material": 0} if "materials" in more else {})}
    first = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}], "accessors": [first, {"count": 3, **accessor}],
        "bufferViews": views,
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        **more,
    }
    with open("in.gltf", "w") as file:
        json.dump(gltf, file)
    subprocess.run(["node", "-e", CHECK], check=True)
    return next(iter(trimesh.load_scene("in.gltf", process=False).geometry.values()))


coordinates = np.array([[0, 0], [65535, 32768], [0, 65535]], np.uint16)
textured = load("TEXCOORD_0", [coordinates], {"bufferView": 1, "componentType": 5123, "normalized": True, "type": "VEC2"},
                textures=[{"source": 0}], images=[{"uri": "data:image/png;base64," + PIXEL}],
                materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])
reds = np.array([[32768, 0, 0, 65535]] * 3, np.uint16)
coloured = load("COLOR_0", [reds], {"bufferView": 1, "componentType": 5123, "normalized": True, "type": "VEC4"})
moved = load("POSITION", [np.array([2, 0], np.uint16), np.array([0, 1, 9], np.float32)], {
    "bufferView": 0, "componentType": 5126, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 9],
    "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}},
})
seen = [textured.visual.uv[1].tolist(), coloured.visual.vertex_colors[0].tolist(), moved.vertices[2].tolist()]
print(f"texture coordinates (1, 0.5): {seen[0]}\ncolour (0.5, 0, 0, 1) in bytes: {seen[1]}\nvertex (0, 1, 9): {seen[2]}")
wanted = [[65535.0, 32769.0], [0, 0, 0, 255], [0.0, 1.0, 0.0]]
if seen != wanted:
    sys.exit(f"this changed: it was {wanted}")
PY
