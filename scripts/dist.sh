#!/usr/bin/env bash
# Makes target/dist/ssct-VERSION-x86_64-linux.tar.gz, an archive of the program for machines that have only the C library and a
# Vulkan driver with its loader. It contains ssct, the window ssct-view, the licences (also of all crates, which are checked), a
# README of one screen, and gpu-study.sh. The README names the version of the C library that the programs need.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."
cargo=${CARGO:-cargo}
target=${CARGO_TARGET_DIR:-target}
[ "$(uname -sm)" = 'Linux x86_64' ] || { echo 'dist: the archive is of Linux on x86-64, and this is neither' >&2; exit 1; }

"$cargo" build --release --bin ssct --bin ssct-view
version=$("$cargo" metadata --no-deps --format-version 1 | sed -n 's/.*"name":"ssct","version":"\([^"]*\)".*/\1/p')
name="ssct-$version-x86_64-linux"
folder="$target/dist/$name"
rm -rf "$folder"
mkdir -p "$folder"

programs=("$target/release/ssct" "$target/release/ssct-view")
for program in "${programs[@]}"; do
    strip -o "$folder/$(basename "$program")" "$program"
done
cp LICENSE-APACHE LICENSE-MIT "$folder/"
CARGO="$cargo" python3 scripts/licences.py "$folder/LICENCES-OF-CRATES" >&2
install -m 755 scripts/gpu-study.sh "$folder/gpu-study.sh"

# Prints the newest version among the symbols that the programs take from a library, such as 2.34 for GLIBC.
youngest() { objdump -T "${programs[@]}" | grep -o "\b$1_[0-9.]*" | sort -uV | tail -n 1 | cut -d_ -f2; }
glibc=$(youngest GLIBC)
libraries=$(objdump -p "${programs[@]}" | awk '/NEEDED/ { print $2 }' | sort -u | paste -sd ' ')

cat >"$folder/README" <<TEXT
ssct $version for Linux on x86-64, built from commit $(git rev-parse --short=10 HEAD)

Glossy reflections in screen space on Vulkan: published methods, timed per pass, held against exact references.

What it needs: a Vulkan driver with the loader libvulkan.so.1, and the C library glibc $glibc or younger
(Debian 12, Ubuntu 22.04 or younger). The programs load $libraries.

  ./ssct devices                          what Vulkan offers here
  ./gpu-study.sh                          measure the device in some minutes; then open gpu-study/index.html
  ./ssct study -o out                     pictures, times and errors of the built-in scenes; then open out/index.html
  ./ssct render --scene rooms -o a.png    one picture
  ./ssct view                             a window; it needs X11 or Wayland, whose libraries it looks for
  ./ssct --help                           all commands

Licence: MIT or Apache-2.0, at your option (LICENSE-MIT, LICENSE-APACHE).
The licences of the crates that it is built of are in LICENCES-OF-CRATES.
TEXT
tar -C "$target/dist" -czf "$target/dist/$name.tar.gz" "$name"
echo "$target/dist/$name.tar.gz ($(du -h "$target/dist/$name.tar.gz" | cut -f1))"
