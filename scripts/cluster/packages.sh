#!/usr/bin/env bash
# Installs Debian's Slurm and MUNGE if they are missing, without starting their services, now or when the machine
# starts.
set -euo pipefail

missing=() services=()
for package in slurmctld slurmd slurm-client munge; do
    status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
    [ "$status" != 'install ok installed' ] || continue
    missing+=("$package")
    [ "$package" = slurm-client ] || services+=("$package.service")
done
[ ${#missing[@]} -gt 0 ] || exit 0
command -v apt-get >/dev/null || { echo 'packages: this knows Debian and Ubuntu; install Slurm and MUNGE by hand' >&2; exit 1; }
as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "packages: as root: apt-get install ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
fi

# The packages start their services as they are installed, unless this file, which administrators may have too, forbids
# it.
policy=/usr/sbin/policy-rc.d
if [ ! -e "$policy" ]; then
    trap '"${as_root[@]}" rm -f "$policy"' EXIT
    printf '#!/bin/sh\nexit 101\n' | "${as_root[@]}" tee "$policy" >/dev/null
    "${as_root[@]}" chmod 755 "$policy"
fi
echo "packages: installing ${missing[*]}" >&2
"${as_root[@]}" apt-get update -q >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" >&2
# Installed, they would be started with the machine.
if [ ${#services[@]} -gt 0 ] && command -v systemctl >/dev/null; then
    "${as_root[@]}" systemctl --quiet disable "${services[@]}" >&2
fi
