#!/bin/sh
# The league (docs/findings/league.md): installs what runs in the browser and what judges it into a folder, and runs both beside a
# program ssct. An hour on two cores. Folders with methods of anybody's may follow (docs/custom-methods.md).
#
# Usage: scripts/league.sh SSCT OUT [METHOD]...
set -eu

ssct=$1
out=$2
shift 2
here=$(cd "$(dirname "$0")" && pwd)

# Pinned, so that the page's figures can be measured again.
THREE=0.187.0
BABYLON=9.35.0
PLAYWRIGHT=1.65.1

missing() {
    echo "the league needs $1" >&2
    exit 1
}
command -v node >/dev/null || missing "node and npm (apt-get install nodejs npm)"
command -v npm >/dev/null || missing "npm (apt-get install npm)"
command -v python3 >/dev/null || missing "python3 with venv (apt-get install python3-venv)"
chromium=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
[ -n "$chromium" ] || missing "Chromium (apt-get install chromium, or CHROMIUM=path/to/it in the environment)"

mkdir -p "$out/packages"
[ -x "$out/packages/python/bin/python" ] || python3 -m venv "$out/packages/python" \
    || missing "Python's venv (apt-get install python3-venv)"
"$out/packages/python/bin/pip" install --quiet numpy==2.4.6 pillow==13.0.0 || missing "the Python packages numpy and pillow"
[ -f "$out/packages/package.json" ] || echo '{"private": true}' >"$out/packages/package.json"
(cd "$out/packages" && npm install --silent --save-exact "three@$THREE" "@babylonjs/core@$BABYLON" "playwright-core@$PLAYWRIGHT") \
    || missing "the npm packages three, @babylonjs/core and playwright-core"

# Each further folder is a method.
for folder in "$@"; do
    shift
    set -- "$@" --method "$folder"
done
PYTHONPATH="$here/league" "$out/packages/python/bin/python" "$here/league/run.py" "$out" --ssct "$ssct" \
    --packages "$out/packages" --chromium "$chromium" "$@"
