#!/usr/bin/env bash
# Runs a study in shards by Snakemake on this machine, stops it in the middle, goes on, and holds the merged result against
# the same study run at once.
#
#   scripts/cluster/test_snakemake.sh SSCT SNAKEMAKE
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
ssct=$(realpath "${1:?usage: scripts/cluster/test_snakemake.sh SSCT SNAKEMAKE}")
# A virtual environment's program is known by its path, which a link out of it would not be.
snakemake=$(cd "$(dirname "${2:?which snakemake}")" && pwd)/$(basename "$2")
tasks=4
say() { printf '%s test-snakemake: %s\n' "$(date +%T)" "$*" >&2; }
fail() { say "FAILED: $*"; tail -n 25 "$folder"/*.log "$folder"/study/logs/*.log >&2 2>/dev/null || true; exit 1; }

folder=$(mktemp -d "${TMPDIR:-/tmp}/ssct-snakemake.XXXXXX")
running=''
clean_up() {
    [ -z "$running" ] || kill -KILL -- "-$running" 2>/dev/null || true
    rm -rf "$folder"
}
trap clean_up EXIT

study=(error --scene corridor --method ssct,unified --size 96x54 --roughness 0,0.3 --samples 1 --rays 32 --no-sweep)
# In a group of processes of its own, so that all of it can be stopped.
shards=(env "XDG_CACHE_HOME=$folder/cache" setsid "$snakemake" --snakefile "$here/Snakefile" --directory "$folder" --cores 2
    --nolock --config "out=$folder/study" "tasks=$tasks" "command=${study[*]}" "ssct=$ssct")

"${shards[@]}" >"$folder/first.log" 2>&1 &
running=$!
for ((n = 0; n < 240; n++)); do
    entries=$(cat "$folder"/study/shards/*/journal.jsonl 2>/dev/null | grep -c '"key"' || true)
    [ "$entries" -eq 0 ] || break
    sleep 0.5
done
[ "$entries" -gt 0 ] || fail 'nothing was measured in two minutes'
[ ! -d "$folder/study/all" ] || fail 'all was done before it could be stopped'
kill -KILL -- "-$running"
wait "$running" 2>/dev/null || true
running=''
for n in $(seq "$tasks"); do
    [ ! -e "$folder/study/shards/$n/journal.jsonl" ] || cp "$folder/study/shards/$n/journal.jsonl" "$folder/journal-of-$n"
done
say "stopped after $entries entries of the journals"

# What was running when it was killed counts as incomplete; the shards themselves know better.
"${shards[@]}" --rerun-incomplete >"$folder/second.log" 2>&1 || fail 'the second attempt'
for n in $(seq "$tasks"); do
    [ -e "$folder/journal-of-$n" ] || continue
    # A line that the kill cut off is not kept.
    whole=$(grep -c '}$' "$folder/journal-of-$n" || true)
    head -n "$whole" "$folder/study/shards/$n/journal.jsonl" | cmp -s - <(head -n "$whole" "$folder/journal-of-$n") ||
        fail "the journal of shard $n does not go on where it was"
done
"$ssct" "${study[@]}" -o "$folder/alone" >"$folder/alone.log"
python3 "$here/same.py" "$folder/alone" "$folder/study/all"
say "passed in $SECONDS s"
