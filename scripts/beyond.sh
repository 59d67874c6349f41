#!/usr/bin/env bash
# Measures methods against the world on 26 views of the built-in scenes, and on nine of two other scenes: errors, and times of
# the same frames. By default these are unified with four captures, captures alone and ssct, as in "What captures gain"
# (docs/findings/world.md).
#
#   scripts/beyond.sh OUT [SCENES]     SCENES contains ssct-rooms/ and sponza/; without it, only built-in scenes are used
#
# The environment may set METHODS and BEYOND, the options that all methods have (by default "--captures 4"); or instead of
# both VARIANTS, methods with options of their own, as in VARIANTS="ssct;ssct --fallback pccm;traced". It may set SIZE,
# ERROR_SIZE, ROUGHNESS, SAMPLES and RAYS; ONLY=rooms,museum selects scenes; WHAT=time or WHAT=error selects one of the two
# measurements. Interrupted, the same command goes on with the errors where it was.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/beyond.sh OUT [SCENES]}
scenes=${2:-}
mkdir -p "$out"
times=$out/times
read -r -a beyond <<<"${BEYOND:---captures 4}"
common=(--roughness "${ROUGHNESS:-0,0.05,0.1,0.3,0.6}")
if [ -n "${VARIANTS:-}" ]; then
    IFS=';' read -r -a variants <<<"$VARIANTS"
    for variant in "${variants[@]}"; do
        common+=(--variant "$variant")
    done
    sweep=()
else
    common+=(--method "${METHODS:-ssct,unified,captures}" "${beyond[@]}")
    sweep=(--no-sweep)
fi

# Measures a scene, unless ONLY leaves out its name: the errors of the scene into OUT/NAME, and the times of the views.
views() { # scene, name, views...
    local scene=$1 name=$2 view
    shift 2
    [[ ,${ONLY:-$name}, = *,$name,* ]] || return 0
    if [ "${WHAT:-error}" = error ]; then # both are made unless WHAT selects one
        "$ssct" error --scene "$scene" "${common[@]}" --size "${ERROR_SIZE:-480x270}" "${sweep[@]}" \
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
    for name in ssct-rooms sponza; do
        [ -e "$scenes/$name" ] || echo "beyond: $scenes has no folder $name" >&2
    done
    [ ! -e "$scenes/ssct-rooms" ] || views "$scenes/ssct-rooms/rooms.scene.toml" \
        ssct-rooms cylinder window-floor corridor two-cylinders window ceiling
    if [ -e "$scenes/sponza" ]; then
        "$root/scripts/left_handed.sh" "$scenes/sponza/sponza.scene.toml" "$out/scenes/sponza.scene.toml"
        views "$out/scenes/sponza.scene.toml" sponza atrium lion hall
    fi
else
    echo 'beyond: no folder of shared scenes is given; only built-in scenes are used' >&2
fi

# Writes one table of the times and one of the errors against the world. A row is a view, a roughness and a variant.
python3 - "$out" <<'PYTHON'
import csv, json, sys
from pathlib import Path

out = Path(sys.argv[1])
kept = ("beyond", "fallback", "captures", "own_rays")


def write(table, figures, rows):
    with open(out / table, "w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["commit", "scene", "view", "width", "height", "roughness", "method", *kept, *figures])
        for scene, r, values in rows:
            head = [r[k] for k in ("view", "width", "height", "roughness", "method")]
            lines.writerow([r["commit"], scene, *head, *(r["setup"].get(k, "") for k in kept), *values])


figures = ("median_ms", "min_ms", "p95_ms", "samples")
times = [(path, r) for path in sorted((out / "times").glob("*.json")) for r in json.loads(path.read_text())]
if times:
    rows = ((path.stem.removesuffix("-" + r["view"]), r, [r["total"][k] for k in figures]) for path, r in times)
    write("times.csv", figures, rows)

figures = ("rmse", "standard_error", "place_agreement")
errors = [(path, r) for path in sorted(out.glob("*/error.json")) for r in json.loads(path.read_text())]
if errors:
    against = ((path, r) for path, r in errors if r["against"] == "world")
    write("errors.csv", figures, ((path.parent.name, r, [r[k] for k in figures]) for path, r in against))
PYTHON
