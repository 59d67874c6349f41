#!/bin/sh
# The league (docs/findings/league.md): installs what runs in the browser and what judges it into a folder, and runs both beside a
# program ssct. A quarter of an hour on two cores. Folders of further methods may follow (docs/custom-methods.md).
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

# Each further folder is a method.
for folder in "$@"; do
    shift
    set -- "$@" --method "$folder"
done
PYTHONDONTWRITEBYTECODE=1 "$python" "$here/league/run.py" "$out" --ssct "$ssct" \
    --packages "$out/packages" --chromium "$chromium" "$@"
