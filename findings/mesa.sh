# Sourced by findings about Vulkan drivers of Mesa, as `mesa.sh DRIVER PACKAGE...`: DRIVER is the driver's word in the name of its ICD
# file, such as `lvp` or `radeon`, and the packages are pinned ones of PyPI. `python` has these in a temporary folder, $scratch, and sees
# that driver alone. Debian's libvulkan1 and mesa-vulkan-drivers are installed where they are missing (as root).

icd=/usr/share/vulkan/icd.d/$1_icd.$(uname -m).json
shift
[ -s "$icd" ] || { apt-get update -q && apt-get install -y -q --no-install-recommends libvulkan1 mesa-vulkan-drivers; } >/dev/null
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet "$@"
echo "mesa-vulkan-drivers $(dpkg-query -W -f '${Version}' mesa-vulkan-drivers)"
export VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd XDG_RUNTIME_DIR=$scratch

python() {
    "$scratch/venv/bin/python" "$@"
}
