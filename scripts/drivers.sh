#!/usr/bin/env bash
# Fetches SwiftShader, a younger Khronos validation layer and a younger Mesa into .drivers/, for `make test-drivers`.
# SwiftShader is a Vulkan driver on the CPU that was written independently of Mesa. Debian's package chromium-common contains
# SwiftShader and the layer. Mesa 25 comes from Debian 12's backports; its lavapipe runs on a plain Debian 12. The script
# unpacks packages and installs nothing. It fetches only what is missing, so it is safe to run again.
#   scripts/drivers.sh         fetch
#   scripts/drivers.sh --env   print the variables with which a program sees both drivers and the younger layer
#   scripts/drivers.sh --mesa  print the variable with which a program sees the younger Mesa alone; nothing where there is none
#   scripts/drivers.sh --radv  print the variables with which a program sees Mesa's driver for AMD's GPUs alone, of the younger
#                              Mesa or of the system's; with RADV_FORCE_FAMILY it compiles for a GPU that is not there
#   scripts/drivers.sh --help  print this
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
package=chromium-common
folder="$root/.drivers"
driver=libvk_swiftshader.so
layer=libVkLayer_khronos_validation.so

mesa="$folder/mesa"

say() { printf 'drivers: %s\n' "$*" >&2; }

case "${1:-}" in
    '' | --env | --mesa | --radv) ;;
    *)
        say "$1: there is --env, --mesa, --radv and --help, and without any of them packages are fetched"
        exit 2
        ;;
esac

if [ "${1:-}" = --env ]; then
    # The driver is added to those that the loader finds. The folder of layers is replaced, since the younger layer has the
    # same name as the one of the system.
    printf 'export VK_ADD_DRIVER_FILES=%q VK_LAYER_PATH=%q\n' "$folder/swiftshader.json" "$folder/layers"
    exit 0
fi

if [ "${1:-}" = --mesa ]; then
    [ ! -s "$mesa/version" ] || printf 'export VK_DRIVER_FILES=%q\n' "$mesa/lavapipe.json"
    exit 0
fi

if [ "${1:-}" = --radv ]; then
    system=/usr/share/vulkan/icd.d/radeon_icd.$(uname -m).json
    if [ -s "$mesa/radv.json" ]; then
        printf 'export VK_DRIVER_FILES=%q LD_LIBRARY_PATH=%q\n' "$mesa/radv.json" "$mesa"
    elif [ -s "$system" ]; then
        printf 'export VK_DRIVER_FILES=%q\n' "$system"
    else
        say "there is no driver for AMD's GPUs: $system is absent"
        exit 1
    fi
    exit 0
fi

# The younger Mesa is fetched on Debian 12 alone, whose backports have it. A younger system has a younger Mesa of its own.
codename=$(. /etc/os-release 2>/dev/null && echo "${VERSION_CODENAME:-}")
wants_mesa=
[ "$codename" != bookworm ] || [ -s "$mesa/radv.json" ] || wants_mesa=1
[ -s "$folder/version" ] && [ -z "$wants_mesa" ] && exit 0
command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null || {
    say "this script knows Debian and Ubuntu; elsewhere put $driver and $layer of a Chromium build into $folder"
    exit 1
}

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo -n)

# Fetches Mesa of the backports. apt reads the lists of packages into the scratch folder, so that the system's lists stay
# unchanged.
fetch_mesa() {
    local mirror options archive
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' | head -n 1)
    [ -n "$mirror" ] || { say 'apt has no source of bookworm, so that Mesa of its backports cannot be fetched'; return 1; }
    mkdir -p "$scratch/lists/partial" "$scratch/cache/archives/partial"
    printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s bookworm-backports main\n' "$mirror" \
        >"$scratch/backports.list"
    options=(-q -o "Dir::Etc::SourceList=$scratch/backports.list" -o Dir::Etc::SourceParts=/dev/null
        -o "Dir::State::Lists=$scratch/lists" -o "Dir::Cache=$scratch/cache" -o APT::Sandbox::User=)
    if ! (cd "$scratch" && apt-get "${options[@]}" update && apt-get "${options[@]}" download \
        {mesa-vulkan-drivers,libdrm2,libdrm-amdgpu1}/bookworm-backports) >"$scratch/log" 2>&1; then
        say "Mesa of Debian's backports cannot be fetched: $(tail -n 1 "$scratch/log")"
        return 1
    fi
    archive=$(find "$scratch" -maxdepth 1 -name 'mesa-vulkan-drivers*.deb')
    mkdir -p "$mesa"
    dpkg-deb --fsys-tarfile "$archive" | tar -x -O --wildcards './usr/lib/*/libvulkan_lvp.so' >"$mesa/libvulkan_lvp.so"
    cat >"$mesa/lavapipe.json" <<JSON
{"file_format_version": "1.0.0", "ICD": {"library_path": "./libvulkan_lvp.so", "api_version": "1.4.0"}}
JSON
    # The driver for AMD's GPUs needs younger versions of two libraries than Debian 12 has: they are unpacked beside it.
    dpkg-deb --fsys-tarfile "$archive" | tar -x -O --wildcards './usr/lib/*/libvulkan_radeon.so' >"$mesa/libvulkan_radeon.so"
    local library
    for library in libdrm2 libdrm-amdgpu1; do
        dpkg-deb --fsys-tarfile "$(find "$scratch" -maxdepth 1 -name "${library}_*.deb")" |
            tar -x -C "$mesa" --strip-components=4 --wildcards './usr/lib/*/libdrm*.so*'
    done
    dpkg-deb --field "$archive" Version >"$mesa/version"
    cat >"$mesa/radv.json" <<JSON
{"file_format_version": "1.0.0", "ICD": {"library_path": "$mesa/libvulkan_radeon.so", "api_version": "1.4.0"}}
JSON
    say "lavapipe and RADV of Mesa $(cat "$mesa/version") are in $mesa"
}
[ -z "$wants_mesa" ] || fetch_mesa
[ ! -s "$folder/version" ] || exit 0

# Downloads the package to the scratch folder.
fetch() { (cd "$scratch" && apt-get download -q "$package" >"$scratch/log" 2>&1); }
if ! fetch; then
    # The lists of packages may be missing or old.
    say 'reading the lists of packages anew'
    "${as_root[@]}" apt-get update -q >&2 || true
    fetch || { say "the package $package cannot be fetched: $(tail -n 1 "$scratch/log")"; exit 1; }
fi
archive=$(find "$scratch" -name "$package*.deb")
dpkg-deb --fsys-tarfile "$archive" |
    tar -x -C "$scratch" "./usr/lib/chromium/$driver" "./usr/lib/chromium/$layer"
mkdir -p "$folder/layers"
mv "$scratch/usr/lib/chromium/$driver" "$folder/"
mv "$scratch/usr/lib/chromium/$layer" "$folder/layers/"
cat >"$folder/swiftshader.json" <<JSON
{"file_format_version": "1.0.0", "ICD": {"library_path": "./$driver", "api_version": "1.3.0"}}
JSON
# The package has no manifest for the layer, since Chromium loads it without one.
cat >"$folder/layers/VkLayer_khronos_validation.json" <<JSON
{
    "file_format_version": "1.2.0",
    "layer": {
        "name": "VK_LAYER_KHRONOS_validation",
        "type": "GLOBAL",
        "library_path": "./$layer",
        "api_version": "1.4.0",
        "implementation_version": "1",
        "description": "Khronos Validation Layer",
        "instance_extensions": [
            {"name": "VK_EXT_debug_report", "spec_version": "10"},
            {"name": "VK_EXT_debug_utils", "spec_version": "2"},
            {"name": "VK_EXT_layer_settings", "spec_version": "2"},
            {"name": "VK_EXT_validation_features", "spec_version": "6"}
        ]
    }
}
JSON
dpkg-deb --field "$archive" Version >"$folder/version"
say "SwiftShader and the validation layer of $package $(cat "$folder/version") are in $folder"
