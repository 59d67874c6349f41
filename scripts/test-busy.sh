#!/usr/bin/env bash
# Runs a test command beside eight busy loops, as on a machine that many people share. Every test must pass there too.
#   scripts/test-busy.sh [COMMAND …]   `cargo test` without a command
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."

loops=()
trap 'kill "${loops[@]}" 2>/dev/null || true' EXIT
for _ in 1 2 3 4 5 6 7 8; do
    (while :; do :; done) &
    loops+=($!)
done
[ $# -gt 0 ] || set -- "${CARGO:-cargo}" test
began=$(date +%s)
status=0
"$@" || status=$?
echo "test-busy: $(($(date +%s) - began)) s, exit status $status" >&2
exit $status
