#!/bin/sh
# Runs the league (docs/findings/league.md): compares ssct with engines in a browser. Installs the engines and the Python packages
# into OUT/packages. It takes a quarter of an hour on two cores. METHOD is the folder of a further method
# (docs/custom-methods.md).
#
# Usage: scripts/league.sh SSCT OUT [METHOD]...
set -eu
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

ssct=$1
out=$2
shift 2
here=$(cd "$(dirname "$0")" && pwd)
. "$here/league/packages.sh"
install_packages "$out/packages"

# Puts --method before each further folder.
for folder in "$@"; do
    shift
    set -- "$@" --method "$folder"
done
PYTHONDONTWRITEBYTECODE=1 "$python" "$here/league/run.py" "$out" --ssct "$ssct" \
    --packages "$out/packages" --chromium "$chromium" "$@"
