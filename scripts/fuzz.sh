#!/usr/bin/env bash
# Fuzzes the loaders with libFuzzer on a stable toolchain. The coverage that guides it comes from LLVM's own
# pass, which is enabled with the same flags as cargo-fuzz uses. `run` writes a target's log, with executions and
# coverage, to OUT/TARGET.log and new inputs to OUT/TARGET-corpus; `merge` adds those inputs to the archive
# fuzz/corpus/TARGET.tar.gz that increase its coverage.
#
# usage: fuzz.sh [build | run OUT RUNS TARGET… | merge OUT TARGET… | summary LOG…]
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }
cd "$(dirname "$0")/.."
host=$(rustc -vV | sed -n 's/^host: //p')
target_dir=${CARGO_TARGET_DIR:-fuzz/target}
bin=$target_dir/$host/release

flags="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
flags+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
flags+=" -Cllvm-args=-sanitizer-coverage-trace-compares"

# Prints the greatest length of a mutated input, in bytes. It is short for images, since a byte can unpack to thousands of bytes.
longest() { case $1 in texture) echo 512 ;; run) echo 20000 ;; *) echo 4096 ;; esac; }

# Prints the path of the dictionary of a target.
words() {
    case $1 in
        scene | camera_path) echo fuzz/dictionaries/toml.dict ;;
        *) echo "fuzz/dictionaries/$1.dict" ;;
    esac
}

# Builds all targets.
build() {
    RUSTFLAGS="$flags" cargo build --release --manifest-path fuzz/Cargo.toml --target "$host" --target-dir "$target_dir"
}

# Unpacks the kept inputs of a target into OUT/TARGET-kept.
unpack() {
    local out=$1 target=$2
    rm -rf "$out/$target-kept"
    mkdir -p "$out/$target-kept"
    [ ! -e "fuzz/corpus/$target.tar.gz" ] || tar -xzf "fuzz/corpus/$target.tar.gz" -C "$out/$target-kept"
}

# Packs OUT/TARGET-kept into fuzz/corpus/TARGET.tar.gz. Equal inputs give equal archives, to the byte.
pack() {
    local out=$1 target=$2
    tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode=644 --format=ustar \
        -C "$out/$target-kept" -cf - $(cd "$out/$target-kept" && ls) | gzip -9n >"fuzz/corpus/$target.tar.gz"
}

# Fuzzes each target for a number of executions. The arguments are those of the command `run` at the head of this file.
run() {
    local out=$1 runs=$2 target
    shift 2
    mkdir -p "$out"
    SSCT_FUZZ_SEEDS="$out/seeds" "$bin/obj"
    for target in "$@"; do
        mkdir -p "$out/$target-corpus"
        unpack "$out" "$target"
        "$bin/$target" -runs="$runs" -max_len="$(longest "$target")" -dict="$(words "$target")" \
            -rss_limit_mb=2048 -timeout=600 -reload=0 -print_final_stats=1 -artifact_prefix="$out/$target-" \
            "$out/$target-corpus" "$out/$target-kept" "$out/seeds/$target" >"$out/$target.log" 2>&1 ||
            { tail -n 40 "$out/$target.log" >&2; exit 1; }
        grep -E 'DONE|stat::' "$out/$target.log" | sed "s/^/$target: /"
    done
}

# Adds the new inputs of each target that increase its coverage to its archive. The arguments are those of `merge`.
merge() {
    local out=$1 target
    shift
    for target in "$@"; do
        unpack "$out" "$target"
        "$bin/$target" -set_cover_merge=1 -use_counters=0 "$out/$target-kept" "$out/$target-corpus" "$out/seeds/$target" \
            >"$out/$target-merge.log" 2>&1
        pack "$out" "$target"
        tail -n 1 "$out/$target-merge.log"
    done
}

# For each target, sums the executions over all logs and gives the greatest coverage of a single log: edges, and
# features (edges by count).
summary() {
    awk '
        FNR == 1 { target = FILENAME; sub(/.*\//, "", target); sub(/[.-].*/, "", target); runs[target]++; stated[FILENAME] = 0 }
        /^#[0-9]/ {
            n = substr($1, 2) + 0
            if (!stated[FILENAME] && n > last[FILENAME]) { sum[target] += n - last[FILENAME]; last[FILENAME] = n }
            for (i = 2; i < NF; i++) {
                if ($i == "cov:" && $(i + 1) > cov[target]) cov[target] = $(i + 1) + 0
                if ($i == "ft:" && $(i + 1) > ft[target]) ft[target] = $(i + 1) + 0
            }
        }
        /^stat::number_of_executed_units/ { sum[target] += $2 - last[FILENAME]; stated[FILENAME] = 1 }
        /ERROR: libFuzzer: deadly signal/ { panics[target]++ }
        END {
            printf "%-12s %5s %12s %7s %9s %7s\n", "target", "runs", "executions", "edges", "features", "panics"
            for (t in runs) {
                printf "%-12s %5d %12d %7d %9d %7d\n", t, runs[t], sum[t], cov[t], ft[t], panics[t] | "sort"
                all += sum[t]
            }
            close("sort")
            printf "%-12s %5s %12d\n", "all", "", all
        }' "$@"
}

case ${1:-} in
    build) build ;;
    run | merge | summary) "$@" ;;
    *) sed -n 's/^# usage: //p' "$0" >&2; exit 2 ;;
esac
