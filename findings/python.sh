# Sourced by findings about packages for Python: those that are named after this file are installed in a temporary folder, which becomes
# the working folder. `venv/bin` has their programs.

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet "$@"
