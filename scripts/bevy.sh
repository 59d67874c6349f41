#!/usr/bin/env bash
# Draws the hall of examples/bevy with each kind of reflections, in turn: figures.json and a picture of each.
# Usage: scripts/bevy.sh OUT [SIZE [FRAMES]]
set -euo pipefail
[ $# -ge 1 ] || { sed -n 3p "$0" >&2; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
size=${2:-640x360}
frames=${3:-15}
cd "$(dirname "$0")/../examples/bevy"
"${CARGO:-cargo}" build --quiet
example=${CARGO_TARGET_DIR:-target}/debug/embed-bevy
separator='['
for with in ssct traced screen bevy bevy-steps; do
    line=$("$example" "$out/$with.png" --with "$with" --size "$size" --frames "$frames" --truth "$out/truth.png" | grep '^{')
    printf '%s%s' "$separator" "$line"
    separator=$',\n'
done >"$out/figures.json"
printf ']\n' >>"$out/figures.json"
