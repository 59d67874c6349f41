# Sourced by findings about packages for Node: those that are named after this file are installed in a temporary folder, which becomes the
# working folder.

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent --no-fund --no-audit "$@" >/dev/null
