#!/usr/bin/env bash
# Installs Debian's Slurm and MUNGE if they are missing, and keeps their services from starting, both at once and with
# the machine.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

# shellcheck source=scripts/packages.sh
source "$(dirname "${BASH_SOURCE[0]}")/../packages.sh"
command -v apt-get >/dev/null || {
    echo 'packages.sh: this script knows Debian and Ubuntu; install Slurm and MUNGE by hand' >&2
    exit 1
}
mapfile -t missing < <(missing_of slurmctld slurmd slurm-client munge)
[ ${#missing[@]} -gt 0 ] || exit 0
become_root "${missing[@]}"

# A package's installation starts its service unless this file forbids it. If an administrator has made the file already, it
# stays.
policy=/usr/sbin/policy-rc.d
if [ ! -e "$policy" ]; then
    trap '"${as_root[@]}" rm -f "$policy"' EXIT
    printf '#!/bin/sh\nexit 101\n' | "${as_root[@]}" tee "$policy" >/dev/null
    "${as_root[@]}" chmod 755 "$policy"
fi
install_packages "${missing[@]}"
# The services that were just installed would start with the machine.
services=()
for package in "${missing[@]}"; do
    [ "$package" = slurm-client ] || services+=("$package.service")
done
if [ ${#services[@]} -gt 0 ] && command -v systemctl >/dev/null; then
    "${as_root[@]}" systemctl --quiet disable "${services[@]}" >&2
fi
