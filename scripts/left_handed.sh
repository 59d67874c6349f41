#!/usr/bin/env bash
# Copies a scene file with left-handed places that does not declare them. The copy gets the line coordinates = "left", unless the
# file declares its coordinates already. The copy names meshes and images by absolute paths.
#
#   scripts/left_handed.sh FILE.scene.toml COPY.scene.toml
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

file=${1:?usage: scripts/left_handed.sh FILE.scene.toml COPY.scene.toml}
copy=${2:?usage: scripts/left_handed.sh FILE.scene.toml COPY.scene.toml}
[ ! "$file" -ef "$copy" ] || { echo "left_handed.sh: COPY must be another file than $file" >&2 && exit 2; }
folder=$(cd "$(dirname "$file")" && pwd | sed 's/[|&\\]/\\&/g')
mkdir -p "$(dirname "$copy")"
{
    grep -q '^coordinates *=' "$file" || echo 'coordinates = "left"'
    sed -E "s|^( *file *= *['\"])([^/'\"])|\1$folder/\2|" "$file"
} >"$copy"
