#!/usr/bin/env bash
# Runs the tests of `make test`, and writes the time of each to the CSV file OUT (out/test-times.csv), the longest first. Tests
# run at the same time, so that each slows down the others. The script prints the twenty longest, and then the tests that took
# longer than their budget: BUDGET (30) seconds, or the number in tests/budgets.csv. A test over its budget is no failure.
#
#   scripts/test-times.sh [OUT [FILTER]...]     only tests whose names contain a filter
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

out=${1:-out/test-times.csv}
[ $# -eq 0 ] || shift
mkdir -p "$(dirname "$out")"
said=$(mktemp)
trap 'rm -f "$said"' EXIT
budget=${BUDGET:-30}
# Rust's test harness prints times by an unstable option, which a stable toolchain allows with RUSTC_BOOTSTRAP. Only the tests get
# this variable: if the compiler had it, it would build everything anew.
host=$(rustc -vV | sed -n 's/^host: //p' | tr 'a-z-' 'A-Z_')
export "CARGO_TARGET_${host}_RUNNER=env RUSTC_BOOTSTRAP=1"
status=0
"${CARGO:-cargo}" test --lib --bins --tests --no-fail-fast -- -Z unstable-options --report-time "$@" 2>&1 | tee "$said" || status=$?
{
    echo 'binary,test,seconds'
    sed -n -E -e 's/^ +Running .*deps\/([a-z_]+)-[0-9a-f]+\)$/binary \1/p' \
        -e 's/^test ([^ ]+)( - should panic)? \.\.\. .*<([0-9.]+)s>$/\1 \3/p' "$said" |
        awk '$1 == "binary" { binary = $2; next } { print binary "," $1 "," $2 }' | sort -t, -k3,3 -rn
} >"$out"
awk -F, 'NR > 1 { sum += $3 } NR > 1 && NR <= 21 { printf "%8.1f s  %s %s\n", $3, $1, $2 }
    END { printf "%8.1f s  of %d tests together\n", sum, NR - 1 }' "$out"
# A budget whose test did not run is named as well, unless a filter chose the tests. The last column of tests/budgets.csv, the
# reason, may contain commas.
awk -F, -v usual="$budget" -v all="$#" '
    FNR == 1 { file++; next }
    file == 1 { allowed[$1 "," $2] = $3; next }
    { name = $1 "," $2; may = name in allowed ? allowed[name] : usual; ran[name] = 1 }
    $3 > may { printf "over its budget of %d s: %s %s, %.1f s\n", may, $1, $2, $3 }
    END { for (name in allowed) if (all == 0 && !(name in ran)) print "has a budget and did not run: " name }
' tests/budgets.csv "$out"
exit "$status"
