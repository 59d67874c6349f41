# Sourced by findings that ask a driver of Mesa by Vulkan itself. The word after this file is the driver's in the name of its ICD file, such as
# `lvp` or `radeon`. `python` has `vulkan` 1.3.275.1 from PyPI in a temporary folder, $scratch, and sees that driver alone. Debian's
# libvulkan1, mesa-vulkan-drivers, glslang-tools and spirv-tools are installed where they are missing (as root).

icd=/usr/share/vulkan/icd.d/$1_icd.$(uname -m).json
packages=()
[ -s "$icd" ] || packages+=(libvulkan1 mesa-vulkan-drivers)
command -v glslangValidator >/dev/null || packages+=(glslang-tools)
command -v spirv-dis >/dev/null || packages+=(spirv-tools)
[ ${#packages[@]} -eq 0 ] || { apt-get update -q && apt-get install -y -q --no-install-recommends "${packages[@]}"; } >/dev/null
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet vulkan==1.3.275.1 cffi==2.1.1
echo "mesa-vulkan-drivers $(dpkg-query -W -f '${Version}' mesa-vulkan-drivers)"
export VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd XDG_RUNTIME_DIR=$scratch

python() {
    "$scratch/venv/bin/python" "$@"
}
