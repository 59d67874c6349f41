#!/usr/bin/env bash
# Measures what cells of the error study cost on this machine, each cell in a process of its own: two views of every
# built-in scene, at two sizes; in the rooms with every variant of the sweep, elsewhere with one variant of each method.
# The result is OUT/costs.json, which `ssct error --plan --costs OUT` reads. `--shard` divides studies by the costs that
# are part of the program: the copy under benches/runs/ that lab/src/study/cost_model.rs names.
#
#   scripts/costs.sh OUT
#
# After an interruption, the same command goes on with the cells that are missing.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/costs.sh OUT}
mkdir -p "$out"
for cell in \
    rooms/cylinder/128x72/0.1 rooms/window-floor/256x144/0 \
    atrium/atrium/256x144/0.3 atrium/lion/128x72/0 \
    street/street/128x72/0.05 street/puddles/256x144/0.1 \
    museum/museum/256x144/0.1 museum/paintings/128x72/0.3 \
    cathedral/nave/128x72/0 cathedral/rose/256x144/0.1 \
    corridor/corridor/256x144/0.05 corridor/wall/128x72/0.1; do
    scene=${cell%%/*} rest=${cell#*/}
    view=${rest%%/*} rest=${rest#*/}
    size=${rest%%/*} roughness=${rest#*/}
    folder="$out/$scene-$view-$size"
    [ -f "$folder/done" ] && continue
    rm -rf "$folder"
    variants=()
    [ "$scene" = rooms ] || variants=(--no-sweep)
    "$ssct" error --scene "$scene" --view "$view" --size "$size" --roughness "$roughness" --samples 1 --rays 16 \
        "${variants[@]}" -o "$folder" >"$out/log.txt"
    touch "$folder/done"
done
python3 - "$out" <<'END'
import json, pathlib, sys

out = pathlib.Path(sys.argv[1])
cells = [cell for file in sorted(out.glob("*/costs.json")) for cell in json.loads(file.read_text())]
lines = ",\n ".join(json.dumps(cell, separators=(",", ":")) for cell in cells)
(out / "costs.json").write_text(f"[{lines}]\n")
END
