#!/usr/bin/env bash
# Measures unified with four captures, captures alone and ssct, on the same frames: errors against the world, and times, of
# the views behind "What captures gain" in docs/findings.md. With METHODS=ssct,traced,unified and BEYOND="--beyond triangles"
# it measures what triangles gain instead.
#
#   scripts/beyond.sh OUT [SCENES]     SCENES contains ssct-rooms/ and sponza/; without it, only built-in scenes are used
#
# The environment may set BEYOND (by default "--captures 4"), SIZE, ERROR_SIZE, ROUGHNESS, SAMPLES, RAYS and METHODS; WHAT=time or WHAT=error selects one of
# the two measurements. Interrupted, the same command goes on with the errors where it was.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/beyond.sh OUT [SCENES]}
scenes=${2:-}
mkdir -p "$out"
times=$out/times
read -r -a beyond <<<"${BEYOND:---captures 4}"
common=(--method "${METHODS:-ssct,unified,captures}" "${beyond[@]}" --roughness "${ROUGHNESS:-0,0.05,0.1,0.3,0.6}")

views() { # scene, name, views...
    local scene=$1 name=$2 view
    shift 2
    if [ "${WHAT:-error}" = error ]; then # both are made unless WHAT selects one
        "$ssct" error --scene "$scene" "${common[@]}" --size "${ERROR_SIZE:-480x270}" --no-sweep \
            --samples 1 --rays "${RAYS:-16}" -o "$out/$name" --resume
    fi
    if [ "${WHAT:-time}" = time ]; then
        mkdir -p "$times"
        for view in "$@"; do
            "$ssct" time --scene "$scene" --view "$view" "${common[@]}" --size "${SIZE:-960x540}" \
                --samples "${SAMPLES:-7}" --json >"$times/$name-$view.json"
        done
    fi
}

views rooms rooms cylinder window-floor corridor two-cylinders window ceiling
views museum museum museum exit-sign paintings second-hall
views street street street car puddles signs bonnet
views corridor corridor corridor floor wall back
views cathedral cathedral nave pillars clerestory rose
views atrium atrium atrium lion hall
if [ -n "$scenes" ]; then
    views "$scenes/ssct-rooms/rooms.scene.toml" ssct-rooms cylinder window-floor corridor two-cylinders window ceiling
    views "$scenes/sponza/sponza.scene.toml" sponza atrium lion hall
else
    echo 'beyond: no folder of shared scenes is given; only built-in scenes are used' >&2
fi

# The times in one table, a view and roughness and method a row.
[ ! -d "$times" ] || python3 - "$times" "$out/times.csv" <<'PYTHON'
import csv, json, sys
from pathlib import Path

folder, table = map(Path, sys.argv[1:])
with open(table, "w", newline="") as file:
    rows = csv.writer(file)
    rows.writerow(["commit", "scene", "view", "width", "height", "roughness", "method", "median_ms", "min_ms", "p95_ms", "samples"])
    for path in sorted(folder.glob("*.json")):
        for r in json.loads(path.read_text()):
            total = [r["total"][k] for k in ("median_ms", "min_ms", "p95_ms", "samples")]
            scene = path.stem.removesuffix("-" + r["view"])
            head = [r[k] for k in ("view", "width", "height", "roughness", "method")]
            rows.writerow([r["commit"], scene, *head, *total])
PYTHON
