#!/usr/bin/env bash
# Measures table 5.8 of the thesis in Sponza, the scene of the printed table, and in the atrium. The verdicts on time quote these
# records (docs/findings/documents.md). Run it on an idle machine; it takes half an hour on two cores.
#
#   scripts/table-5.8.sh OUT SPONZA     SPONZA is the scene file of Crytek Sponza; OUT gets a folder for each scene
#
# The environment may set SAMPLES (25) and SSCT, the program. An interrupted run goes on where it was.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/table-5.8.sh OUT SPONZA}
sponza=${2:?usage: scripts/table-5.8.sh OUT SPONZA}

# Measures the table into OUT/FOLDER: the table and its records, and the time of the effect for each sample.
table() { # folder, options of the scene...
    local folder=$out/$1 whole
    shift
    whole=$folder/whole
    "$ssct" time --table 5.8 --samples "${SAMPLES:-25}" "$@" -o "$whole" --resume
    cp "$whole/time.txt" "$whole/time.json" "$folder/"
    python3 - "$whole/time-samples.csv" >"$folder/time-samples.csv" <<'PYTHON'
"""Prints for each sample the time of the effect: the sum over its passes."""
import csv
import sys

fields = ["scene", "view", "method", "preset", "width", "height", "roughness", "sample"]
sums = {}
with open(sys.argv[1], newline="") as file:
    for row in csv.DictReader(file):
        key = tuple(row[field] for field in fields)
        sums[key] = sums.get(key, 0.0) + (float(row["ms"]) if row["counted"] == "true" else 0.0)
print(",".join([*fields, "effect_ms"]))
for key, effect in sums.items():
    print(",".join([*key, f"{effect:.4f}"]))
PYTHON
}

table table-5.8-atrium
"$root/scripts/left_handed.sh" "$sponza" "$out/scenes/sponza.scene.toml"
table table-5.8-sponza --scene "$out/scenes/sponza.scene.toml"
