#!/usr/bin/env bash
# Runs the tests that must pass on any driver, on lavapipe and on SwiftShader, under a validation layer that is three years
# younger than Debian's. On the lavapipe of Mesa 25, which Debian 13 has, it runs the tests that a driver has made fail before.
# scripts/drivers.sh fetches drivers and layer. Before all tests, every program is compiled for GPUs that this machine does not
# have. tests/expected_failures.toml lists under "suite" the tests that fail on a driver for a reason outside this program. Each
# of them must fail, and no other test may.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."

scripts/drivers.sh
cargo=${CARGO:-cargo}
log=$(mktemp)
trap 'rm -f "$log"' EXIT

echo "drivers: what AMD's compiler makes of every program" >&2
"$cargo" test --test alone -- compiled:: --ignored

eval "$(scripts/drivers.sh --env)"
echo 'drivers: one against the other' >&2
"$cargo" test --test alone -- drivers:: --ignored

echo 'drivers: lavapipe under the younger layer' >&2
SSCT_DEVICE=llvmpipe "$cargo" test --test suite -- validation::

# Runs tests of the suite, and fails unless exactly the tests fail that the list expects to fail on the driver.
check() { # the driver's name in the list, tests...
    local driver=$1 failed expected
    shift
    echo "drivers: $driver" >&2
    "$cargo" test --test suite -- "$@" 2>&1 | tee "$log" | grep -E '^test |^error|panicked' || true
    grep -q '^test result:' "$log" || { echo 'drivers: the tests did not run to their end' >&2; exit 1; }
    failed=$(sed -n 's/^test \([a-z_0-9:]*\) \.\.\. FAILED$/\1/p' "$log" | sort)
    expected=$(awk -F'"' -v wanted="$driver" \
        '/^mode/ { mode = $2 } /^driver/ { driver = $2 } /^id/ { if (mode == "suite" && driver == wanted) print $2 }' \
        tests/expected_failures.toml | sort)
    if [ "$failed" != "$expected" ]; then
        echo "drivers: on $driver these tests failed unexpectedly (<), or passed although a failure is expected (>):" >&2
        diff <(echo "$failed") <(echo "$expected") >&2 || true
        exit 1
    fi
    echo "drivers: $(grep '^test result:' "$log" | tail -n 1); all failures were expected"
}

# In compute shaders SwiftShader filters wrongly over the edges of cube maps (docs/devices.md), and from one image to the next not
# by the same error. The test that is skipped compares two such images.
SSCT_DEVICE=SwiftShader check SwiftShader --skip camera_capture::it_follows_the_camera area_light:: billboard:: camera_capture:: \
    captures:: chains:: cone:: filters:: gloss_twin:: hi_z_ray_trace:: mirror:: planar:: resolution:: unified:: validation::

unset VK_ADD_DRIVER_FILES VK_LAYER_PATH
eval "$(scripts/drivers.sh --mesa)"
if [ -n "${VK_DRIVER_FILES:-}" ]; then
    # The quick study is skipped, since it takes two minutes and draws the images of other tests. test-debian.sh makes a quick
    # study on this Mesa.
    check 'Mesa 25' --skip cli::a_quick_study bounces:: camera_capture:: captures:: cli:: cube_maps:: filters:: gloss_twin:: golden:: gbuffer_maps:: \
        many:: mirror:: planar:: ray_queries:: renewal:: stochastic:: unified:: unified_stages:: validation::
else
    echo 'drivers: this system has no backports of Mesa 25; its own lavapipe is what make test runs on' >&2
fi
