#!/usr/bin/env bash
# Draws the hall of examples/bevy, unlit and lit, with each kind of reflections: figures.json and a picture of each.
# Usage: scripts/bevy.sh OUT [SIZE [FRAMES]]
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
[ $# -ge 1 ] || { sed -n 3p "$0" >&2; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
size=${2:-640x360}
frames=${3:-15}
cd "$(dirname "$0")/../examples/bevy"
"${CARGO:-cargo}" build --quiet
example=${CARGO_TARGET_DIR:-target}/debug/embed-bevy
separator='['
# Draws the picture OUT/NAME.png with arguments of the example, and prints its figures as an item of the list in JSON.
draw() { # name, arguments...
    local name=$1 line
    shift
    line=$("$example" "$out/$name.png" --size "$size" --frames "$frames" "$@" | grep "^{")
    printf '%s{"picture": "%s", %s' "$separator" "$name" "${line#\{}"
    separator=$',\n'
}
{
    for with in ssct traced screen bevy bevy-steps; do
        draw "$with" --with "$with" --truth "$out/truth.png"
    done
    # With the lamp, the truth of the mirror is another picture: the hall as seen from below, through the floor.
    draw lit-truth --lit --with nothing --mirrored
    for with in ssct guess screen bevy bevy-steps; do
        draw "lit-$with" --lit --with "$with" --mirror "$out/lit-truth.png"
    done
} >"$out/figures.json"
printf ']\n' >>"$out/figures.json"
