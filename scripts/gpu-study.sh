#!/usr/bin/env bash
# Measures the Vulkan device of this machine, which needs only a driver and the program:
#   scripts/gpu-study.sh [PROGRAM] [FOLDER] [OPTIONS of ssct gpu-study]
# PROGRAM is ssct, which may have been built elsewhere (default: ssct beside this script, as in the archive of `make dist`, else
# target/release/ssct). The result is the page FOLDER/index.html. In the repository, the device's images are also compared with
# the kept ones of lavapipe and SwiftShader.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

here=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$here")
program=$root/target/release/ssct
[ ! -x "$here/ssct" ] || program=$here/ssct
program=${1:-$program}
folder=${2:-gpu-study}
shift $(($# < 2 ? $# : 2))
[ -x "$program" ] || { echo "gpu-study: there is no program $program; cargo build --release makes it" >&2; exit 1; }

beside=()
for kept in "$root"/benches/runs/*/gpu-study/*/; do
    [ -d "$kept/same" ] && beside+=(--beside "${kept%/}")
done
"$program" devices
began=$(date +%s)
"$program" gpu-study -o "$folder" "${beside[@]}" "$@"
echo "gpu-study: $(($(date +%s) - began)) s"
