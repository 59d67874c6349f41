#!/usr/bin/env bash
# Runs the tests of a changed shader without compiling Rust: the tests that were built last compile shaders-glsl/ when they run.
#   scripts/shader-test.sh shaders-glsl/history/history.glsl            the tests whose files share a word with the shader's name
#   scripts/shader-test.sh shaders-glsl/history/history.glsl moving::   the tests whose names contain one of these texts
# A change of a shader's bindings, blocks or constants needs `make build`, and the message says so. The command, which some
# tests run, reads the same folder.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."

say() { printf 'shader-test: %s\n' "$*" >&2; }
wrong() { say "$1"; exit 2; }

file=${1:-}
[ -n "$file" ] || wrong 'no shader is named; make shader-test FILE=shaders-glsl/history/history.glsl names one'
[ -f "$file" ] || wrong "there is no file '$file'"
shift
programs="${CARGO_TARGET_DIR:-target}/debug/deps"
tests=
for program in "$programs"/suite-*; do
    [[ -x $program && $program != *.* ]] || continue
    [[ -n $tests && $tests -nt $program ]] || tests=$program
done
[ -n "$tests" ] || wrong 'the tests are not built: cargo test --no-run builds them'
younger=$(find src lab tests -name '*.rs' -newer "$tests" -print -quit)
[ -z "$younger" ] || say "$younger is younger than the tests, which were built without it"

# Prints the words in the shader's path that may name its tests. Short words, file extensions and "common" fit too many tests.
words() { tr '/_.' '\n' <<<"${file#*shaders-glsl/}" | grep -vxE 'common|frag|vert|comp|glsl|[a-z]{1,3}' | sort -u; }
wanted=("$@")
if [ ${#wanted[@]} -eq 0 ]; then
    for word in $(words); do
        for module in tests/suite/*.rs; do
            module=$(basename "$module" .rs)
            case "_${module}_" in *"_${word}_"*) wanted+=("$module::") ;; esac
        done
    done
    [ ${#wanted[@]} -gt 0 ] || wrong "no file of tests shares a word with '$file'; TESTS=history:: names the tests to run"
    mapfile -t wanted < <(printf '%s\n' "${wanted[@]}" | sort -u)
fi
say "${wanted[*]}"
root=$PWD
cd lab
exec env SSCT_SHADERS="$root/shaders-glsl" "$(cd "$root" && realpath "$tests")" "${wanted[@]}"
