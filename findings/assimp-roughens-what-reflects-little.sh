#!/usr/bin/env bash
# Assimp, from OBJ to glTF 2.0: the roughness of a material with a Phong exponent (Ns). Expected: one that grows as Ns falls, whatever the
# strength of the reflection is (Ks), since Ks says how much a surface reflects and Ns how sharply.
# Seen, with Debian 12's Assimp 5.2.5: roughness = 1 - sqrt(Ns / 1000) * Ks. A polished plastic with Ns 1000 and Ks 0.04 becomes 0.96, which
# shows no reflection at all, and the same polish with Ks 1 becomes 0. Without Ks there is no roughness, and glTF's default, 1, holds.
#
# Debian's assimp-utils is installed where it is missing (as root).
set -euo pipefail

command -v assimp >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends assimp-utils; } >/dev/null
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
{ echo 'mtllib scene.mtl' && printf 'v %s\n' '0 0 0' '1 0 0' '0 1 0'; } >scene.obj
for ns in 1000 100 10; do
    for ks in 1 0.5 0.04; do
        printf 'newmtl %s-%s\nKd 0.5 0.5 0.5\nKs %s %s %s\nNs %s\n' "$ns" "$ks" "$ks" "$ks" "$ks" "$ns" >>scene.mtl
        printf 'usemtl %s-%s\nf 1 2 3\n' "$ns" "$ks" >>scene.obj
    done
done
printf 'newmtl 1000-none\nKd 0.5 0.5 0.5\nNs 1000\n' >>scene.mtl
printf 'usemtl 1000-none\nf 1 2 3\n' >>scene.obj
assimp export scene.obj scene.gltf -f gltf2 >/dev/null
python3 - <<'PY'
import json
import sys

roughness = {m["name"]: m["pbrMetallicRoughness"].get("roughnessFactor") for m in json.load(open("scene.gltf"))["materials"]}
changed = roughness["1000-none"] is not None
print("Ns    Ks    roughness")
for ns in (1000, 100, 10):
    for ks in ("1", "0.5", "0.04"):
        found = roughness[f"{ns}-{ks}"]
        print(f"{ns:<5} {ks:<5} {found:.3f}")
        changed |= abs(found - (1 - (ns / 1000) ** 0.5 * float(ks))) > 1e-3
if changed:
    sys.exit("this changed: the roughness was 1 - sqrt(Ns / 1000) * Ks, and left out without Ks")
PY
echo "assimp-utils $(dpkg-query -W -f '${Version}' assimp-utils)"
