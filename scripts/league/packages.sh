# Installs pinned versions of the engines and of the packages that run and compare them, so that figures can be measured again.
# This file is sourced, not run. `install_packages FOLDER` sets `python` and `chromium`, or names what is missing, and ends.

THREE=0.187.0
BABYLON=9.35.0
PLAYWRIGHT=1.65.1

missing() {
    echo "missing: $1" >&2
    exit 1
}

install_packages() {
    command -v node >/dev/null || missing "node and npm (apt-get install nodejs npm)"
    command -v npm >/dev/null || missing "npm (apt-get install npm)"
    command -v python3 >/dev/null || missing "python3 with venv (apt-get install python3-venv)"
    chromium=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
    [ -n "$chromium" ] || missing "Chromium (apt-get install chromium, or CHROMIUM=path/to/it in the environment)"
    mkdir -p "$1"
    python=$1/python/bin/python
    [ -x "$python" ] || python3 -m venv "$1/python" || missing "Python's venv (apt-get install python3-venv)"
    "$python" -m pip install --quiet numpy==2.4.6 pillow==13.0.0 || missing "the Python packages numpy and pillow"
    [ -f "$1/package.json" ] || echo '{"private": true}' >"$1/package.json"
    (cd "$1" && npm install --silent --save-exact "three@$THREE" "@babylonjs/core@$BABYLON" "playwright-core@$PLAYWRIGHT") \
        || missing "the npm packages three, @babylonjs/core and playwright-core"
}
