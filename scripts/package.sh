#!/usr/bin/env bash
# Packages the crate `ssct` with its shaders compiled, so that whoever builds it needs no shader compiler, and the crate `ssct-ground`,
# which it depends on. The SPIR-V is written to shaders-spirv/, which is not part of the repository, and goes into the package beside
# the GLSL.
# The environment variable CARGO_NET_OFFLINE=true makes do with what Cargo has in its cache.
#
# usage: package.sh [OPTIONS OF cargo package]
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."
cargo=${CARGO:-cargo}

# Cargo says where the build script of `ssct` put its modules. That of `ssct-ground` has none.
messages=$("$cargo" check --quiet --package ssct --features compile-shaders --message-format json)
out=$(sed -n '/"reason":"build-script-executed"/ { /"package_id":"path+/ { /#ssct-ground@/! s/.*"out_dir":"\([^"]*\)".*/\1/p } }' <<<"$messages")
[ -s "$out/spirv/glsl.txt" ] || { echo "package: no modules were found below '$out'" >&2; exit 1; }
rm -rf shaders-spirv
cp -R "$out/spirv" shaders-spirv

# The modules are not under version control, which Cargo takes for a change. It need not build the package once more:
# tests/alone/packaged.rs does.
exec "$cargo" package --package ssct-ground --package ssct --allow-dirty --no-verify "$@"
