#!/usr/bin/env bash
# Copies a scene file whose places were written for left-handed coordinates and that does not say so: the copy says it
# (coordinates = "left"), and names the same files by their whole paths. A file that names its coordinates is copied as it is.
#
#   scripts/left_handed.sh FILE.scene.toml COPY.scene.toml
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

file=${1:?usage: scripts/left_handed.sh FILE.scene.toml COPY.scene.toml}
copy=${2:?usage: scripts/left_handed.sh FILE.scene.toml COPY.scene.toml}
folder=$(cd "$(dirname "$file")" && pwd)
mkdir -p "$(dirname "$copy")"
{
    grep -q '^coordinates *=' "$file" || echo 'coordinates = "left"'
    sed "s|^file = \"\([^/]\)|file = \"$folder/\1|" "$file"
} >"$copy"
