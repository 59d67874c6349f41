#!/usr/bin/env bash
# Packages the crate `ssct`, and the crate `ssct-ground`, on which it depends. The package of `ssct` has its shaders as SPIR-V
# too, so that its users need no shader compiler. The SPIR-V is written to shaders-spirv/, which is not part of the repository.
# With the environment variable CARGO_NET_OFFLINE=true, Cargo takes all crates from its cache. BUILD names the options of a build of
# `ssct` that was made before, such as "build --workspace --lib", so that its shaders are not compiled again.
#
# usage: package.sh [OPTIONS OF cargo package]
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."
cargo=${CARGO:-cargo}

# Cargo's messages say in which folder the build script of `ssct` wrote the SPIR-V. The build scripts of other packages write none.
read -ra build <<<"${BUILD:-check --package ssct --features compile-shaders}"
messages=$("$cargo" "${build[@]}" --quiet --message-format json)
out=$(sed -n '/"reason":"build-script-executed"/ { /"package_id":"path+/ { /#ssct-/! s/.*"out_dir":"\([^"]*\)".*/\1/p } }' <<<"$messages")
[ -s "$out/spirv/glsl.txt" ] || { echo "package: no modules were found below '$out'" >&2; exit 1; }
rm -rf shaders-spirv
cp -R "$out/spirv" shaders-spirv

# Cargo takes the SPIR-V, which is not under version control, for uncommitted changes: --allow-dirty. tests/alone/packaged.rs
# builds the package, so that Cargo need not: --no-verify.
exec "$cargo" package --package ssct-ground --package ssct --allow-dirty --no-verify "$@"
