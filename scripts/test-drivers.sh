#!/usr/bin/env bash
# Runs the tests that hold for any driver on lavapipe and on SwiftShader, under a validation layer that is three years
# younger than Debian's (scripts/drivers.sh fetches both). tests/expected_failures.toml lists under "suite" the tests that
# fail on SwiftShader for a reason outside this program. Each of them must fail, and no other test may.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/drivers.sh
eval "$(scripts/drivers.sh --env)"
cargo=${CARGO:-cargo}
log=$(mktemp)
trap 'rm -f "$log"' EXIT

echo 'drivers: one against the other' >&2
"$cargo" test --test alone -- drivers:: --ignored

echo 'drivers: lavapipe under the younger layer' >&2
SSCT_DEVICE=llvmpipe "$cargo" test --test suite -- validation::

echo 'drivers: SwiftShader' >&2
suites=(area_light:: billboard:: camera_capture:: captures:: chains:: cone:: filters:: gloss_twin:: hi_z_ray_trace::
    mirror:: planar:: resolution:: unified:: validation::)
SSCT_DEVICE=SwiftShader "$cargo" test --test suite -- "${suites[@]}" 2>&1 | tee "$log" | grep -E '^test |^error|panicked' || true
grep -q '^test result:' "$log" || { echo 'drivers: the tests did not run to their end' >&2; exit 1; }
failed=$(sed -n 's/^test \([a-z_0-9:]*\) \.\.\. FAILED$/\1/p' "$log" | sort)
expected=$(awk -F'"' '/^mode/ { mode = $2 } /^driver/ { driver = $2 } /^id/ { if (mode == "suite" && driver == "SwiftShader") print $2 }' \
    tests/expected_failures.toml | sort)
if [ "$failed" != "$expected" ]; then
    echo 'drivers: on SwiftShader these tests failed unexpectedly (<), or passed although a failure is expected (>):' >&2
    diff <(echo "$failed") <(echo "$expected") >&2 || true
    exit 1
fi
echo "drivers: $(grep '^test result:' "$log" | tail -n 1); all failures were expected"
