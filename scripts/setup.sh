#!/usr/bin/env bash
# Installs the packages that a Debian or Ubuntu machine needs to build and run ssct:
# the Vulkan loader, a software device, the validation layers and the libraries of the
# shader compiler. It installs only what is missing, so it is safe to run again.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
# shellcheck source=scripts/packages.sh
source "$root/scripts/packages.sh"
packages=(
    g++                     # compiles the C++ of the crate nv-flip
    libvulkan1              # the loader that ash opens at run time
    mesa-vulkan-drivers     # lavapipe: Vulkan on the CPU
    vulkan-validationlayers # ssct --validation, and the tests
    libshaderc-dev          # shaderc, with which build.rs compiles GLSL
    glslang-dev             # the code of glslang, which Debian's archive of shaderc lacks
    spirv-tools             # the code of SPIRV-Tools, which that archive lacks, too
    spirv-headers
    libvulkan-dev           # Vulkan's headers, for the example in C
    cmake pkg-config        # with each of these two, a test builds the example in C
    xvfb xdotool            # the window's test: a display without a screen, and mouse and keys
    # What ssct view loads at run time:
    libx11-6 libx11-xcb1 libxcb1 libxcursor1 libxi6 libxkbcommon0 libxkbcommon-x11-0 xkb-data libwayland-client0
)

say() { printf 'setup: %s\n' "$*" >&2; }

other_system() {
    cat >&2 <<'EOF'
setup: this script knows Debian and Ubuntu. On this system, install by hand:
  - a Vulkan 1.3 loader and driver (a GPU's, or Mesa's lavapipe) and the Khronos validation layers;
  - the Vulkan SDK (its shaderc is found through the variable VULKAN_SDK), or git, cmake and python3,
    with which the shaderc crate builds its own copy on the first `cargo build` (some 10 minutes);
  - a C++ compiler.
For example (these lines follow the systems' lists of packages, and were not tried):
  Fedora   sudo dnf install vulkan-loader-devel mesa-vulkan-drivers vulkan-validation-layers libshaderc-devel gcc-c++ pkgconf git cmake python3
  Arch     sudo pacman -S vulkan-icd-loader vulkan-headers vulkan-swrast vulkan-validation-layers shaderc gcc pkgconf git cmake python
  macOS    brew install molten-vk vulkan-loader vulkan-headers vulkan-validationlayers shaderc cmake pkgconf
then
  cargo build --release
EOF
    exit 1
}

command -v dpkg-query >/dev/null && command -v apt-get >/dev/null || other_system
command -v cargo >/dev/null || { say 'no cargo on the PATH: install Rust first (https://rustup.rs)'; exit 1; }

mapfile -t missing < <(missing_of "${packages[@]}")
if [ ${#missing[@]} -gt 0 ]; then
    become_root "${missing[@]}"
    install_packages "${missing[@]}"
fi

# Debian's libshaderc_combined.a lacks the code of glslang and SPIRV-Tools, so that programs do not link with it. This script
# merges all of these libraries into one archive. .cargo/config.toml tells the crate where the archive lies, so that a bare
# `cargo build` works without a variable set by hand.
archive_dir="$root/.shaderc"
archive_name=libshaderc_combined.a
system_lib="/usr/lib/$(gcc -print-multiarch 2>/dev/null || dpkg-architecture -qDEB_HOST_MULTIARCH)"
if [ ! -s "$archive_dir/$archive_name" ]; then
    say 'merging the shader compiler into one archive'
    mkdir -p "$archive_dir"
    # The archive has a relative name: a script of ar cannot quote names, and an absolute path may contain spaces.
    cd "$archive_dir"
    script="CREATE $archive_name.new"$'\n'
    for library in shaderc_static shaderc_util glslang MachineIndependent GenericCodeGen \
        OGLCompiler OSDependent HLSL SPIRV SPIRV-Tools-opt SPIRV-Tools \
        glslang-default-resource-limits shaderc_combined; do
        [ -e "$system_lib/lib$library.a" ] && script+="ADDLIB $system_lib/lib$library.a"$'\n'
    done
    script+=$'SAVE\nEND\n'
    ar -M <<<"$script"
    mv "$archive_dir/$archive_name.new" "$archive_dir/$archive_name"
fi

mkdir -p "$root/.cargo"
config="$root/.cargo/config.toml"
wanted=$(cat <<'EOF'
# Written by scripts/setup.sh; not part of the repository.
[env]
SHADERC_LIB_DIR = { value = ".shaderc", relative = true }
EOF
)
if [ ! -e "$config" ]; then
    printf '%s\n' "$wanted" >"$config"
elif ! grep -q SHADERC_LIB_DIR "$config"; then
    say "$config exists and does not set SHADERC_LIB_DIR; add these lines:"
    printf '%s\n' "$wanted" >&2
    exit 1
fi
say 'ready'
