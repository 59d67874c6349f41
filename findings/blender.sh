# Sourced by findings about Blender: the module bpy of Blender 5.2.3 (400 MB) in a temporary folder, which becomes the working folder.
# Packages of PyPI that are named after this file are installed beside it. `blender` runs Python code from the standard input with its own
# arguments, keeps what it prints in the file `log`, and shows Blender's version. It needs Python 3.13, for which bpy is built; PYTHON names it.

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3.13}" -m venv venv
venv/bin/pip install --quiet bpy==5.2.3 "$@"

blender() {
    { echo 'import bpy; print("Blender", bpy.app.version_string)' && cat; } | venv/bin/python - "$@" >log 2>&1 || { cat log >&2 && return 1; }
    grep '^Blender' log
}
