#!/usr/bin/env bash
# Builds the C libraries of ssct, and installs them with their header and the files for pkg-config and CMake:
# PREFIX/include, PREFIX/lib, PREFIX/lib/pkgconfig and PREFIX/lib/cmake/ssct. The script works on Linux alone.
#
# usage: install-c.sh PREFIX [OPTIONS OF cargo build]
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
[ $# -ge 1 ] || { echo 'usage: install-c.sh PREFIX [OPTIONS OF cargo build]' >&2; exit 2; }
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
shift
cd "$(dirname "$0")/.."
cargo=${CARGO:-cargo}

# The messages of Cargo, in JSON, contain the paths of the libraries.
messages=$("$cargo" build --package ssct-c --features compile-shaders --message-format json "$@")
# Prints the path of a library that was built.
library() { # its extension, so or a
    sed -n '/"name":"ssct_c"/ s/.*"\([^"]*libssct_c\.'"$1"'\)".*/\1/p' <<<"$messages" | tail -n 1
}
shared=$(library so) static=$(library a)
[ -s "$shared" ] && [ -s "$static" ] || { echo 'install-c: Cargo does not say where the libraries are' >&2; exit 1; }
version=$(sed -n '/^\[workspace\.package\]/,/^\[/ s/^version = "\(.*\)"/\1/p' Cargo.toml)

mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/ssct"
install -m 644 c/include/ssct.h "$prefix/include/ssct.h"
install -m 755 "$shared" "$prefix/lib/libssct_c.so"
install -m 644 "$static" "$prefix/lib/libssct_c.a"
# Writes a file from its template in c/, which has marks such as @PREFIX@.
fill() { # template, file
    sed "s|@PREFIX@|$prefix|; s|@VERSION@|$version|; s|@PRIVATE@|-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc|" "$1" >"$2"
}
fill c/ssct.pc.in "$prefix/lib/pkgconfig/ssct.pc"
fill c/ssct-config.cmake.in "$prefix/lib/cmake/ssct/ssct-config.cmake"
cat >&2 <<EOF
install-c: ssct $version is in $prefix
  cc FILE.c \$(PKG_CONFIG_PATH=$prefix/lib/pkgconfig pkg-config --cflags --libs ssct vulkan) -lm -Wl,-rpath,$prefix/lib
EOF
