#!/usr/bin/env bash
# Makes the films behind "Films" in docs/findings.md: a walk through two scenes at four roughness values; traces that a history
# leaves when the camera suddenly turns, or when something moves before a camera at rest; and 64 frames after something stopped.
#
#   scripts/films.sh OUT
#
# The environment may set ROUGHNESS for the films in the folders rooms and museum. SIZE, FRAMES and RAYS hold for all films but
# those in which something stops. Interrupted, the same command goes on where it was.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/films.sh OUT}
roughness=${ROUGHNESS:-0.05,0.1,0.3,0.6}
mkdir -p "$out"

# The first three variants reflect the screen alone. In the other three, `unified` also reflects the scene's triangles beyond the
# screen, and `stochastic` the captures.
walk=(
    --variant "ssct" --variant "unified --beyond none" --variant "stochastic --history on"
    --variant "unified" --variant "unified --history on" --variant "stochastic --fallback captures --history on"
)
rest=(
    --variant "unified" --variant "unified --history on"
    --variant "stochastic --fallback captures" --variant "stochastic --fallback captures --history on"
)

stops=(
    --variant "unified" --variant "unified --history on" --variant "stochastic --fallback captures --history on"
)

# Makes a film in OUT/FOLDER.
film() { # folder, options of ssct video...
    local folder=$out/$1
    shift
    "$ssct" video "$@" -o "$folder" --resume
}

in_rooms=(--scene rooms --view corridor)
in_museum=(--scene museum --view exit-sign)
at=(--frames "${FRAMES:-60}" --size "${SIZE:-320x180}" --rays "${RAYS:-64}")
film rooms --way walk "${in_rooms[@]}" --roughness "$roughness" "${at[@]}" "${walk[@]}"
film museum --way walk "${in_museum[@]}" --roughness "$roughness" "${at[@]}" "${walk[@]}"
film turn --way turn "${in_rooms[@]}" --roughness 0.1 "${at[@]}" "${rest[@]}"
rolls=(--way rest --moving ball --step=-0.02,0,-0.02)
film moving "${rolls[@]}" "${in_rooms[@]}" --roughness 0.1 "${at[@]}" "${rest[@]}"

# By default, `unified` traces own rays only on a GPU. The option --own-rays traces them on every device.
own=(--variant "stochastic --fallback captures --history on")
for rays in 4 8; do
    own+=(--variant "unified --own-rays $rays" --variant "unified --own-rays $rays --history on")
done
film own-rays/rooms --way walk "${in_rooms[@]}" --roughness 0.3,0.6 "${at[@]}" "${own[@]}"
film own-rays/museum --way walk "${in_museum[@]}" --roughness 0.3,0.6 "${at[@]}" "${own[@]}"

# In these films of 97 frames, everything stands still from frame 32 on, after a third of the film.
at=(--frames 97 --size 160x90 --rays 16)
film stop --way stop "${in_rooms[@]}" --roughness 0.1 "${at[@]}" "${stops[@]}"
film thing-stops "${rolls[@]}" --step-frames 32 "${in_rooms[@]}" --roughness 0.1 "${at[@]}" "${stops[@]}"
film held --way stop --held ball "${in_rooms[@]}" --roughness 0.1 "${at[@]}" "${stops[@]}"
near=(--scene rooms --eye 1.84,0.03,-2.37 --look-at 2.0,-0.1,3.0)
film near-held --way stop --held ball "${near[@]}" --roughness 0.1 "${at[@]}" "${stops[@]}"
film jitter --way stop --jitter "${in_rooms[@]}" --roughness 0.1 "${at[@]}" "${stops[@]}"
