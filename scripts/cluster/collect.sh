#!/usr/bin/env bash
# The job after the tasks of a study on Slurm. It submits failed tasks again, as often as allowed, and then merges the shards. It
# runs also if tasks failed, so that it can name them, and no job waits for them forever. submit.sh submits this script; nobody
# else calls it.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

folder=$1 round=$2
source "$folder/study"
source "$folder/settings"
source "$HERE/common.sh"

missing=($(unfinished "$folder" "$TASKS"))
if [ ${#missing[@]} -gt 0 ]; then
    echo "not done: tasks ${missing[*]}"
    if [ "$round" -lt "$RETRIES" ]; then
        submit_round "$folder" $((round + 1)) "${missing[@]}"
        exit 0
    fi
    [ -n "$PARTIAL" ] || fail "tasks ${missing[*]} failed for good: see logs/, and submit again to go on with them"
fi
shards=()
for ((n = 1; n <= TASKS; n++)); do
    [ ! -d "$folder/shards/$n" ] || shards+=("shards/$n")
done
# An earlier result stays in all/ until the new one is complete.
cd "$folder"
rm -rf all.part
"$SSCT" merge "${shards[@]}" -o all.part ${PARTIAL:+--partial}
rm -rf all
mv all.part all
echo "merged: $folder/all"
