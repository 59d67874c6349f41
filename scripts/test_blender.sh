#!/usr/bin/env bash
# Renders the scene of examples/gbuffer-maps with Blender 5.2 as a Python module, in the ways of docs/gbuffer-maps.md. Reads each
# frame by its map, and fails if ssct refuses a frame or warns about it. About a cropped frame, ssct must warn.
#   scripts/test_blender.sh SSCT FOLDER    SSCT is the command, FOLDER gets the virtual environment and the frames
# It needs Python 3.13 and the package bpy, which pip installs (400 MB). Without Python 3.13 it says so, and ends with status 2.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
ssct=$(realpath "$1")
folder=$2
cd "$(dirname "$0")/../examples/gbuffer-maps"

say() { printf 'test-blender: %s\n' "$*" >&2; }

if ! python=$(command -v "${PYTHON:-python3.13}") || ! "$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 13))'; then
    say "there is no Python 3.13, for which Blender 5.2 is built; PYTHON names another one"
    exit 2
fi
mkdir -p "$folder"
if ! [ -x "$folder/venv/bin/python" ]; then
    "$python" -m venv "$folder/venv"
fi
if ! "$folder/venv/bin/python" -c 'import bpy' 2>/dev/null; then
    say "the package bpy is not there; pip installs it"
    "$folder/venv/bin/pip" install --quiet bpy==5.2.3
fi

# Renders FOLDER/NAME.exr with arguments of blender_scene.py.
frame() { # name, arguments...
    local name=$1
    shift
    "$folder/venv/bin/python" blender_scene.py "$folder/$name.exr" --samples 4 "$@" >"$folder/$name.log" 2>&1 ||
        { tail -20 "$folder/$name.log" >&2; say "$name: Blender failed"; exit 1; }
}

# Reads a frame by a map. Fails unless ssct warns with the given text, or, without a text, if it warns at all.
doubts() { # frame, map, [text]
    local said
    said=$("$ssct" gbuffer convert "$folder/$1.exr" --gbuffer-map "$2" -o "$folder/$1-ours.exr" 2>&1) ||
        { say "$1: $said"; exit 1; }
    case "$said" in
    *"${3:-}"*) [ -n "${3:-}" ] || [ -z "$said" ] || { say "$1: $said"; exit 1; } ;;
    *) say "$1: expected \"$3\", and it says: ${said:-nothing}"; exit 1 ;;
    esac
    say "$1: as expected"
}

frame plain --file-output
doubts plain blender.toml
doubts plain-node blender-file-output.toml
frame interleaved --interleave --half --codec PIZ
doubts interleaved blender.toml
frame stereo --stereo
for view in left right; do
    { echo "view = \"$view\""; cat blender.toml; } >"$folder/stereo-$view.toml"
    doubts stereo "$folder/stereo-$view.toml"
done
frame wide-pixels --pixel-aspect 2
doubts wide-pixels blender.toml
frame cropped --crop
doubts cropped blender.toml "shift-px"
"$ssct" gbuffer reflect "$folder/plain.exr" --gbuffer-map blender.toml --method unified -o "$folder/reflected.png"
say "reflected.png lies in $folder"
