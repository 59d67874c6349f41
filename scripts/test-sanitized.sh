#!/usr/bin/env bash
# Runs the tests of the C interface under AddressSanitizer, then under ThreadSanitizer. They pass null pointers, wrong sizes and
# destroyed objects, and use one object from two threads (c/src/tests/misuse.rs). The stable compiler has both
# runtimes, and RUSTC_BOOTSTRAP lets it accept the flags. ThreadSanitizer has to see the locks of the standard library, which is
# therefore built from its source (rustup component add rust-src). Both builds take a quarter of an hour on two cores.
#
#   scripts/test-sanitized.sh [address | thread]    with an argument, only that sanitizer
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."
cargo=${CARGO:-cargo}
host=$(rustc -vV | sed -n 's/^host: //p')
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# The driver is not compiled with a sanitizer. The driver leaks memory, so that leaks are not reported. Races are reported only in
# the code of this program and of its crates.
export ASAN_OPTIONS=detect_leaks=0
export TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=66"

# Runs the tests under a sanitizer, and fails if the sanitizer reports anything.
sanitized() { # sanitizer, options of Cargo...
    local name=$1
    shift
    echo "test-sanitized: $name" >&2
    RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Zsanitizer=$name -Cunsafe-allow-abi-mismatch=sanitizer" \
        "$cargo" test "$@" --package ssct-c --lib --features compile-shaders --target "$host" \
        --target-dir "${CARGO_TARGET_DIR:-target}/sanitized-$name" -- --test-threads 1 2>&1 | tee "$log"
    ! grep -q 'Sanitizer:' "$log" || { echo "test-sanitized: $name found something" >&2; exit 1; }
}

thread() {
    [ -d "$(rustc --print sysroot)/lib/rustlib/src/rust/library" ] || {
        echo 'test-sanitized: the source of the standard library is missing; rustup component add rust-src brings it' >&2
        exit 1
    }
    sanitized thread -Zbuild-std
}

case "${1:-both}" in
    both) sanitized address && thread ;;
    address) sanitized address ;;
    thread) thread ;;
    *) echo "test-sanitized: '$1' is neither address nor thread" >&2 && exit 2 ;;
esac
