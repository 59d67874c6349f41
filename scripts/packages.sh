# Installs packages on Debian and Ubuntu. It is sourced by the scripts that need packages, not run.

# Prints those of the named packages that are not installed.
missing_of() {
    local package status
    for package in "$@"; do
        status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
        [ "$status" = 'install ok installed' ] || printf '%s\n' "$package"
    done
}

# Sets as_root to the words that stand before a command that root must run, such as sudo. If the script cannot become root,
# it prints what to type as root, and ends.
become_root() { # packages that are to be installed
    as_root=()
    [ "$(id -u)" -ne 0 ] || return 0
    if command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
        as_root=(sudo)
        return 0
    fi
    {
        echo "${0##*/}: these packages are missing, and installing them needs root. Type as root:"
        echo "  apt-get update && apt-get install -y --no-install-recommends $*"
        echo "then run ${0##*/} again."
    } >&2
    exit 1
}

# Installs packages. Call become_root before, which sets as_root.
install_packages() {
    echo "${0##*/}: installing $*" >&2
    "${as_root[@]}" apt-get update -q >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@" >&2
}
