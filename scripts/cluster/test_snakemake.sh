#!/usr/bin/env bash
# Runs the shards of a study by Snakemake on this machine, kills Snakemake in the middle, and runs it again. Compares the merged
# result with the same study run without shards.
#
#   scripts/cluster/test_snakemake.sh SSCT SNAKEMAKE
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=scripts/cluster/testing.sh
source "$here/testing.sh"
ssct=$(realpath "${1:?usage: scripts/cluster/test_snakemake.sh SSCT SNAKEMAKE}")
# Symbolic links stay: a program of a virtual environment finds the environment by the path under which it is called.
snakemake=$(cd "$(dirname "${2:?which snakemake}")" && pwd)/$(basename "$2")
tasks=4

folder=$(mktemp -d "${TMPDIR:-/tmp}/ssct-snakemake.XXXXXX")
running=''
clean_up() {
    local status=$?
    [ "$status" -eq 0 ] || tail -n 25 "$folder"/*.log "$folder"/study/logs/*.log >&2 2>/dev/null || true
    [ -z "$running" ] || kill -KILL -- "-$running" 2>/dev/null || true
    rm -rf "$folder"
}
trap clean_up EXIT

study=(error --scene corridor --method ssct,unified --size 96x54 --roughness 0,0.3 --samples 1 --rays 32 --no-sweep)
# Snakemake runs in a process group of its own, so that it can be killed with all its children.
shards=(env "XDG_CACHE_HOME=$folder/cache" setsid "$snakemake" --snakefile "$here/Snakefile" --directory "$folder"
    --cores 2 --nolock --config "out=$folder/study" "tasks=$tasks" "command=${study[*]}" "ssct=$ssct")

"${shards[@]}" >"$folder/first.log" 2>&1 &
running=$!
entries() { cat "$folder"/study/shards/*/journal.jsonl 2>/dev/null | grep -c '"key"' || true; }
has_measured() {
    [ "$(entries)" -eq 0 ] || return 0
    kill -0 "$running" 2>/dev/null || fail 'Snakemake ended before anything was measured'
    return 1
}
wait_until 'a shard has measured something' has_measured
[ ! -d "$folder/study/all" ] || fail 'all was done before it could be stopped'
kill -KILL -- "-$running"
wait "$running" 2>/dev/null || true
running=''
for n in $(seq "$tasks"); do
    journal=$folder/study/shards/$n/journal.jsonl
    [ ! -e "$journal" ] || cp "$journal" "$folder/journal-of-$n"
done
say "killed after $(entries) entries of the journals"

# Snakemake regards the shards that were running as incomplete. The option tells it to run them again; they go on with their
# journals.
"${shards[@]}" --rerun-incomplete >"$folder/second.log" 2>&1 || fail 'the second attempt'
for n in $(seq "$tasks"); do
    [ -e "$folder/journal-of-$n" ] || continue
    goes_on "$folder/study/shards/$n/journal.jsonl" "$folder/journal-of-$n" ||
        fail "the journal of shard $n does not go on where it was"
done
"$ssct" "${study[@]}" -o "$folder/alone" >"$folder/alone.log"
python3 "$here/same.py" "$folder/alone" "$folder/study/all"
say "passed in $SECONDS s"
