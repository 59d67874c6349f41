#!/usr/bin/env bash
# Runs the README's two commands, `make study` and `make test`, on the last commit of this repository. They run in a bare Debian
# that debootstrap makes, with the drivers and layers of that Debian. It needs root, the network and 8 GB of disk, and takes
# about half an hour on two cores. Rust, and the crates that Cargo has downloaded, come from this machine.
#   scripts/test-debian.sh 13            both commands in Debian 13
#   scripts/test-debian.sh 12 make test  one command in Debian 12
#   scripts/test-debian.sh 13-backports  both commands, with Mesa and Vulkan's loader and layers from the backports
#   scripts/test-debian.sh 12 --archive FILE
#                                        the archive of `make dist`, in a Debian 12 that has nothing but a Vulkan driver: the list
#                                        of devices and a quick study of the first one
# MIRROR names another mirror of Debian than debootstrap's default, TMPDIR another folder than /var/tmp. However the script ends,
# nothing stays mounted and no process stays: all runs in namespaces that end with the script.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."

say() { printf 'test-debian: %s\n' "$*" >&2; }
wrong() { say "$1"; exit 2; }

# Mounts /dev, /proc, /sys and this machine's Rust into the system's folder, and runs a command there. The script calls itself
# with --inside for this, so that the mounts are in namespaces of their own.
inside() { # the system's folder, command...
    local system=$1 status=0
    shift
    mount --rbind /dev "$system/dev"
    mount -t proc proc "$system/proc"
    mount -t sysfs sysfs "$system/sys"
    if [ -n "$TEST_DEBIAN_RUST" ]; then
        mount --bind -o ro "$TEST_DEBIAN_RUST" "$system/opt/rust"
        mount --bind "$TEST_DEBIAN_CARGO/registry" "$system/opt/cargo/registry"
    fi
    local variables=(PATH=/opt/rust/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root CARGO_HOME=/opt/cargo LC_ALL=C.UTF-8) name
    for name in http_proxy https_proxy no_proxy CARGO_BUILD_JOBS; do
        [ -z "${!name:-}" ] || variables+=("$name=${!name}")
    done
    local begin=$SECONDS
    chroot "$system" env -i "${variables[@]}" sh -c 'cd /root/ssct && exec "$@"' sh "$@" || status=$?
    say "$* ended with status $status after $((SECONDS - begin)) s"
    return "$status"
}

if [ "${1:-}" = --inside ]; then
    shift
    inside "$@"
    exit
fi

case "${1:-}" in
    12 | 12-backports) suite=bookworm ;;
    13 | 13-backports) suite=trixie ;;
    *) wrong 'the version of Debian is missing: 12, 13, 12-backports or 13-backports' ;;
esac
backports=
[ "${1%-backports}" = "$1" ] || backports=$suite-backports
shift
archive=
if [ "${1:-}" = --archive ]; then
    archive=${2:-}
    [ -f "$archive" ] || wrong "--archive: there is no file '$archive'; make dist makes one"
    shift 2
fi
[ "$(id -u)" -eq 0 ] || wrong 'making a system in a folder needs root: run this with sudo'
# shellcheck source=scripts/packages.sh
source scripts/packages.sh
mapfile -t missing < <(missing_of debootstrap)
as_root=()
[ ${#missing[@]} -eq 0 ] || install_packages "${missing[@]}"
# The packages that the README expects beside Rust, and the certificates with which Cargo downloads. The archive needs others.
packages=ca-certificates,gcc,make
[ -z "$archive" ] || packages=libvulkan1,mesa-vulkan-drivers
TEST_DEBIAN_RUST=
[ -n "$archive" ] || TEST_DEBIAN_RUST=$(rustc --print sysroot)
TEST_DEBIAN_CARGO=${CARGO_HOME:-$HOME/.cargo}
export TEST_DEBIAN_RUST TEST_DEBIAN_CARGO

system=$(mktemp -d "${TMPDIR:-/var/tmp}/ssct-debian.XXXXXX")
child=
# Kills the child, and removes the system's folder. The mounts exist in the child's namespace alone, so that rm deletes nothing of
# this machine.
clean() {
    if [ -n "$child" ]; then
        kill -KILL "$child" 2>/dev/null || true
        wait "$child" 2>/dev/null || true
    fi
    rm -rf "$system"
}
trap clean EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

# Runs a command in new namespaces, which end with the command. The command is killed when this script ends. It runs in the
# background, so that the script handles a signal at once.
alone() {
    setpriv --pdeathsig KILL unshare --mount --pid --fork --kill-child "$@" &
    child=$!
    local status=0
    wait "$child" || status=$?
    child=
    return "$status"
}

say "making $suite in $system"
alone debootstrap --variant=minbase --include="$packages" "$suite" "$system" ${MIRROR:+"$MIRROR"} >"$system.log" 2>&1 || {
    tail -n 5 "$system.log" >&2
    rm -f "$system.log"
    say "debootstrap cannot make $suite"
    exit 1
}
rm -f "$system.log"
if [ -n "$backports" ]; then
    mirror=$(awk '$1 == "deb" { print $2; exit }' "$system/etc/apt/sources.list")
    echo "deb $mirror $backports main" >"$system/etc/apt/sources.list.d/backports.list"
    printf 'Package: mesa-* *-mesa-* *-mesa0 libgbm* libvulkan* vulkan-* libdrm*\nPin: release n=%s\nPin-Priority: 600\n' "$backports" \
        >"$system/etc/apt/preferences.d/backports"
    # debootstrap may have installed the suite's own version of some of these packages: the upgrade replaces it.
    alone chroot "$system" sh -c 'apt-get -q update && DEBIAN_FRONTEND=noninteractive apt-get -qy upgrade' >"$system.log" 2>&1 || {
        tail -n 5 "$system.log" >&2
        rm -f "$system.log"
        say "apt-get cannot take what $backports has"
        exit 1
    }
    rm -f "$system.log"
fi
if [ -n "$archive" ]; then
    mkdir "$system/root/ssct"
    tar -xzf "$archive" -C "$system/root/ssct" --strip-components=1
else
    mkdir -p "$system/opt/rust" "$system/opt/cargo/registry" "$TEST_DEBIAN_CARGO/registry"
    [ ! -e "$TEST_DEBIAN_CARGO/config.toml" ] || cp "$TEST_DEBIAN_CARGO/config.toml" "$system/opt/cargo/"
    git -c safe.directory='*' bundle create -q "$system/root/ssct.bundle" HEAD
    git -c advice.detachedHead=false -c init.defaultBranch=main clone -q "$system/root/ssct.bundle" "$system/root/ssct"
    rm "$system/root/ssct.bundle"
fi

if [ $# -gt 0 ]; then
    alone scripts/test-debian.sh --inside "$system" "$@"
elif [ -n "$archive" ]; then
    alone scripts/test-debian.sh --inside "$system" ./ssct --version
    alone scripts/test-debian.sh --inside "$system" ./gpu-study.sh ./ssct gpu-study --quick
else
    alone scripts/test-debian.sh --inside "$system" make study
    alone scripts/test-debian.sh --inside "$system" make test
fi
for package in libc6 mesa-vulkan-drivers vulkan-validationlayers; do
    version=$(chroot "$system" dpkg-query -W -f '${Version}' "$package" 2>/dev/null) || version='not installed'
    say "$package: $version"
done
say "passed on $suite${backports:+ with $backports}"
