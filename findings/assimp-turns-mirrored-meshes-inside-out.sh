#!/usr/bin/env bash
# Assimp, from glTF 2.0 to OBJ: a node that mirrors its mesh by a negative scale. Expected: triangles with their corners in the other
# order, since glTF turns the front of such a mesh around, and OBJ has no nodes that could say so.
# Seen, with Debian 12's Assimp 5.2.5: the corners are moved and keep their order, while the normals stay on the right side. So the front
# by the order of corners is the back by the normal: renderers that leave out backs show a hole, and those that reflect at the side of
# the order reflect on the wrong one. A mesh without a mirror comes out right.
#
# Debian's assimp-utils is installed where it is missing (as root).
set -euo pipefail

command -v assimp >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends assimp-utils; } >/dev/null
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
# One triangle with its front towards +z, and the same triangle mirrored in x beside it.
cat >halves.gltf <<'JSON'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
 "nodes": [{"mesh": 0, "name": "plain"}, {"mesh": 0, "name": "mirrored", "translation": [3, 0, 0], "scale": [-1, 1, 1]}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
 "accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
  {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"}],
 "bufferViews": [{"buffer": 0, "byteLength": 72}],
 "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/"}]}
JSON
assimp export halves.gltf halves.obj >/dev/null
python3 - <<'PY'
import sys

vertices, normals, triangles = [], [], []
for line in open("halves.obj"):
    word, *rest = line.split() or [""]
    if word == "v":
        vertices.append([float(x) for x in rest])
    elif word == "vn":
        normals.append([float(x) for x in rest])
    elif word == "f":
        triangles.append([[int(n) for n in corner.split("/") if n] for corner in rest])


def front(a, b, c):
    """The z of the normal by the order of the corners, which lie in a plane of equal z."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


sides = {}
for corners in triangles:
    places = [vertices[corner[0] - 1] for corner in corners]
    side = "mirrored" if max(x for x, _, _ in places) > 1.5 else "plain"
    sides[side] = (front(*places), normals[corners[0][-1] - 1][2])
for name, (by_order, by_normal) in sorted(sides.items()):
    print(f"{name}: front by the order of corners towards z = {by_order:+.0f}, by the normal {by_normal:+.0f}")
if sides != {"plain": (1.0, 1.0), "mirrored": (-1.0, 1.0)}:
    sys.exit("this changed: the mirrored triangle had its front on the side away from its normal")
PY
echo "assimp-utils $(dpkg-query -W -f '${Version}' assimp-utils)"
