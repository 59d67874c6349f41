# Sourced by findings about lavapipe, Mesa's Vulkan driver for CPUs: `python` with wgpu 0.32.0 and numpy 2.4.6 in a temporary folder,
# $scratch, which sees that driver alone. Debian's libvulkan1 and mesa-vulkan-drivers are installed where they are missing (as root).

icd=/usr/share/vulkan/icd.d/lvp_icd.$(uname -m).json
[ -s "$icd" ] || { apt-get update -q && apt-get install -y -q --no-install-recommends libvulkan1 mesa-vulkan-drivers; } >/dev/null
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet wgpu==0.32.0 numpy==2.4.6
echo "mesa-vulkan-drivers $(dpkg-query -W -f '${Version}' mesa-vulkan-drivers)"
export VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd XDG_RUNTIME_DIR=$scratch

python() {
    "$scratch/venv/bin/python" "$@"
}
