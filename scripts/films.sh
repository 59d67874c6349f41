#!/usr/bin/env bash
# The films behind "Films" in docs/findings.md: a walk through two scenes at four roughness values; what a history leaves
# behind when the camera turns suddenly and when something moves while it rests; and 64 frames after something stopped.
#
#   scripts/films.sh OUT
#
# The environment may set SIZE, FRAMES, RAYS and ROUGHNESS of all but the last. Interrupted, the same command goes on where it was.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/films.sh OUT}
roughness=${ROUGHNESS:-0.05,0.1,0.3,0.6}
mkdir -p "$out"

# The first three show the screen alone. Then `unified` has the scene's triangles behind the screen, and `stochastic` captures.
walk=(
    --variant "ssct" --variant "unified --beyond none" --variant "stochastic --history on"
    --variant "unified" --variant "unified --history on" --variant "stochastic --fallback captures --history on"
)
rest=(
    --variant "unified" --variant "unified --history on"
    --variant "stochastic --fallback captures" --variant "stochastic --fallback captures --history on"
)

small=(
    --variant "unified" --variant "unified --history on" --variant "stochastic --fallback captures --history on"
)

film() { # folder, flags...
    local folder=$out/$1
    shift
    "$ssct" video "$@" -o "$folder" --resume
}
full=(--frames "${FRAMES:-60}" --size "${SIZE:-320x180}" --rays "${RAYS:-64}")

film rooms --way walk --scene rooms --view corridor --roughness "$roughness" "${full[@]}" "${walk[@]}"
film museum --way walk --scene museum --view exit-sign --roughness "$roughness" "${full[@]}" "${walk[@]}"
film turn --way turn --scene rooms --view corridor --roughness 0.1 "${full[@]}" "${rest[@]}"
rolls=(--way rest --moving ball --step=-0.02,0,-0.02)
film moving "${rolls[@]}" --scene rooms --view corridor --roughness 0.1 "${full[@]}" "${rest[@]}"

# What moves stops in frame 32.
stop() { film "$@" --scene rooms --view corridor --roughness 0.1 --frames 97 --size 160x90 --rays 16 "${small[@]}"; }
stop stop --way stop
stop thing-stops "${rolls[@]}" --step-frames 32
stop held --way stop --held ball
stop jitter --way stop --jitter
