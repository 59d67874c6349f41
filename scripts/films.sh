#!/usr/bin/env bash
# The films behind the table "Films" of docs/findings.md: a walk through three scenes at four roughness values, and what a
# history leaves behind when the camera turns suddenly and when something moves past it at rest.
#
#   scripts/films.sh DIR [SSCT]
#
# DIR gets a folder for each scene and way; SSCT is the program (default: ssct). Runs that were interrupted go on.
set -euo pipefail

out=${1:?usage: scripts/films.sh DIR [SSCT]}
ssct=${2:-ssct}
size=${SIZE:-320x180}
mkdir -p "$out"

variants=(
    --variant "ssct" --variant "ssct --fallback captures"
    --variant "unified" --variant "unified --history on"
    --variant "unified --captures auto" --variant "unified --captures auto --history on"
    --variant "stochastic" --variant "stochastic --history on"
    --variant "stochastic --fallback captures" --variant "stochastic --fallback captures --history on"
)

# film FOLDER FLAGS...
film() {
    local folder=$out/$1 resume=()
    shift
    [ -e "$folder/journal.jsonl" ] && resume=(--resume)
    "$ssct" error --frames 60 --size "$size" --rays 64 "$@" "${variants[@]}" -o "$folder" "${resume[@]}"
}

film rooms --video walk --scene rooms --view corridor --roughness 0.05,0.1,0.3,0.6
film museum --video walk --scene museum --view exit-sign --roughness 0.05,0.1,0.3,0.6
film street --video walk --scene street --view car --roughness 0.05,0.1,0.3,0.6
film turn --video turn --scene rooms --view corridor --roughness 0.1
