#!/usr/bin/env bash
# cbindgen, which writes headers for C from Rust: what it fetches for a header that needs the crate's own sources alone. By default
# it parses no dependency. Expected: it reads the sources, and needs no network.
# Seen, with cbindgen 0.29.4: given a crate, it has `cargo metadata` describe the dependencies of every platform, and Cargo downloads
# the sources of a crate that only Windows needs. Without a network it therefore fails, although `cargo build` succeeds there. Given
# the file src/lib.rs, it follows the file's modules, writes the same header, and fetches nothing.
#
# Cargo compiles cbindgen, which takes a minute.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cargo install --quiet --locked --root . cbindgen --version 0.29.4
mkdir -p home shape/src
# A home without crates, which takes them from where this machine's Cargo does.
settings=${CARGO_HOME:-$HOME/.cargo}/config.toml
[ ! -f "$settings" ] || cp "$settings" home/
export CARGO_HOME=$folder/home
cat >shape/Cargo.toml <<'TOML'
[package]
name = "shape"
version = "0.1.0"
edition = "2021"
[target.'cfg(windows)'.dependencies]
windows-link = "=0.2.1"
TOML
echo 'mod circle;' >shape/src/lib.rs
printf '#[repr(C)]\npub struct Circle { pub radius: f32 }\n#[no_mangle]\npub extern "C" fn area(circle: Circle) -> f32 { circle.radius }\n' >shape/src/circle.rs
cargo build --quiet --manifest-path shape/Cargo.toml
fetched() { find home -name '*.crate' | wc -l; }
after_build=$(fetched)
bin/cbindgen --quiet --lang c shape/src/lib.rs >from_file.h
after_file=$(fetched)
bin/cbindgen --quiet --lang c shape >from_crate.h
after_crate=$(fetched)
echo "$(bin/cbindgen --version): crates fetched after the build $after_build, after the file $after_file, after the crate $after_crate"
find home -name '*.crate' -printf '%f\n'
if [ "$after_build/$after_file/$after_crate" != 0/0/1 ] || ! grep -q 'float area(struct Circle circle)' from_file.h ||
    ! cmp -s from_file.h from_crate.h; then
    echo 'this changed: the crate had a dependency of another platform fetched, and the file had none' >&2
    exit 1
fi
