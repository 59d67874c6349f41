#!/usr/bin/env bash
# Measures unified on the screen alone, ssct and hzct on the same frames: times and errors of the views behind the README's ratios.
#
#   scripts/bars.sh OUT [SCENES]     SCENES contains ssct-rooms/ and sponza/; without it, only built-in scenes are used
#
# The environment may set SIZES, ERROR_SIZES, ROUGHNESS, SAMPLES, RAYS and ORACLE; WHAT=time or WHAT=error
# selects one of the two measurements.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/release/ssct}
out=${1:?usage: scripts/bars.sh OUT [SCENES]}
scenes=${2:-}
mkdir -p "$out"

# Measures views of a scene, and writes OUT/time-NAME-VIEW.json and OUT/error-NAME-VIEW.json.
views() { # scene, name, views...
    local scene=$1 name=$2 view
    shift 2
    local common=(--scene "$scene" --method ssct,hzct,unified --roughness "${ROUGHNESS:-0,0.05,0.1,0.3,0.6}" --json
        --oracle "${ORACLE:-1}" --beyond none)
    for view in "$@"; do
        if [ "${WHAT:-time}" = time ]; then # both are made unless WHAT selects one
            "$ssct" time "${common[@]}" --view "$view" --size "${SIZES:-960x540,641x479}" \
                --samples "${SAMPLES:-5}" >"$out/time-$name-$view.json"
        fi
        if [ "${WHAT:-error}" = error ]; then
            "$ssct" error "${common[@]}" --view "$view" --size "${ERROR_SIZES:-641x479}" --no-sweep \
                --samples 1 --rays "${RAYS:-64}" >"$out/error-$name-$view.json"
        fi
    done
}

views rooms rooms cylinder window-floor corridor two-cylinders window ceiling
views atrium atrium hall atrium
if [ -n "$scenes" ]; then
    views "$scenes/ssct-rooms/rooms.scene.toml" ssct-rooms cylinder window-floor corridor two-cylinders window ceiling
    "$root/scripts/left_handed.sh" "$scenes/sponza/sponza.scene.toml" "$out/scenes/sponza.scene.toml"
    views "$out/scenes/sponza.scene.toml" sponza atrium lion hall
else
    echo 'bars: no folder of shared scenes is given; only built-in scenes are used' >&2
fi
"$root/scripts/bars.py" "$out"
