#!/usr/bin/env bash
# Assimp, from glTF 2.0 to glTF 2.0: the alpha of the base colour is multiplied with itself each time a file is read and written.
# Expected: the same colour, since red, green and blue of that colour keep their values.
# Seen, with Debian 12's Assimp 5.2.5: alpha 0.9 becomes 0.81, and 0.6561 the second time. A material with the mask's threshold 0.5 and an
# alpha of 0.6 is seen in the first file, and has the alpha 0.36 and vanishes in the second. Nothing is said.
#
# Installs Debian's assimp-utils where they are missing (as root).
set -euo pipefail

command -v assimp >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends assimp-utils; } >/dev/null
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >first.gltf <<'JSON'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "materials": [{"name": "glass", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 0.9]}, "alphaMode": "BLEND"},
  {"name": "leaf", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 0.6]}, "alphaMode": "MASK", "alphaCutoff": 0.5}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}, {"attributes": {"POSITION": 0}, "material": 1}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri":
  "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
JSON
assimp export first.gltf second.gltf -fgltf2 >/dev/null
assimp export second.gltf third.gltf -fgltf2 >/dev/null
echo "assimp $(dpkg-query -W -f='${Version}' assimp-utils 2>/dev/null || echo '(not from Debian)')"
python3 - <<'PY'
import json
import sys

seen = []
for name in ("first", "second", "third"):
    with open(f"{name}.gltf") as file:
        made = {m["name"]: m for m in json.load(file)["materials"]}
    colors = {key: [round(part, 4) for part in made[key]["pbrMetallicRoughness"]["baseColorFactor"]] for key in ("glass", "leaf")}
    seen.append(f"{name}: glass {colors['glass']}, leaf {colors['leaf']}, {made['leaf']['alphaMode']}")
print("\n".join(seen))
wanted = [
    "first: glass [0.8, 0.4, 0.2, 0.9], leaf [0.8, 0.4, 0.2, 0.6], MASK",
    "second: glass [0.8, 0.4, 0.2, 0.81], leaf [0.8, 0.4, 0.2, 0.36], MASK",
    "third: glass [0.8, 0.4, 0.2, 0.6561], leaf [0.8, 0.4, 0.2, 0.1296], MASK",
]
if seen != wanted:
    sys.exit("this changed: it was\n" + "\n".join(wanted))
PY
