#!/usr/bin/env bash
# Measures a quick study, adds it to a library of results, and writes the page that lists all results.
#
#   scripts/library.sh SSCT LIBRARY
#
# The run's folder is named by date, time and commit. The library keeps the latest KEEP (100) runs: the newest one whole, and of
# the others only the records and samples, so that the library stays small enough for a static site.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

ssct=$(realpath "${1:?usage: scripts/library.sh SSCT LIBRARY}")
library=${2:?usage: scripts/library.sh SSCT LIBRARY}
keep=${KEEP:-100}
root=$(cd "$(dirname "$0")/.." && pwd)

mkdir -p "$library"
library=$(realpath "$library")
commit=$(git -C "$root" rev-parse --short=10 HEAD 2>/dev/null || echo unknown)
run=$(date -u +%Y-%m-%dT%H-%M-%S)-$commit

# The study is made in a temporary folder, so that an interruption leaves the library unchanged.
study=$(mktemp -d "${TMPDIR:-/tmp}/ssct-library.XXXXXX")
trap 'rm -rf "$study"' EXIT
"$ssct" study --quick -o "$study"
rm -rf "$study/truth" "$study/journal.jsonl"
cp -r "$study" "$library/$run"
chmod 755 "$library/$run"

# The folders of the runs, the latest first. Sorting their names sorts them by time.
mapfile -t runs < <(cd "$library" && ls -d 20??-??-??T??-??-??-*/ | sort -r)
for n in "${!runs[@]}"; do
    folder=$library/${runs[$n]%/}
    if [ "$n" -ge "$keep" ]; then
        rm -rf "$folder"
    elif [ "$n" -gt 0 ]; then
        find "$folder" -type f ! -name '*.json' ! -name time-samples.csv -delete
        find "$folder" -type d -empty -delete
    fi
done
"$ssct" index "$library"
