#!/usr/bin/env bash
# A task of a study on Slurm: runs one shard, and goes on with its journal where an earlier attempt was stopped or
# killed. submit.sh submits it; nobody else calls it.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

folder=$1
source "$folder/study"
source "$folder/settings"
source "$HERE/common.sh"
task=$SLURM_ARRAY_TASK_ID
shard=$folder/shards/$task
attempt="task $task on ${SLURMD_NODENAME:-$(hostname)}, attempt $((${SLURM_RESTART_COUNT:-0} + 1))"
say() { printf '%s %s: %s\n' "$(date +%T)" "$attempt" "$*"; }

[ ! -e "$folder/done/$task" ] || { say 'is done already'; exit 0; }
mkdir -p "$shard"

# Copies the files that are newer in one folder than in another, each whole or not at all. The journal names the cells that are
# done. It is read before the other files and written after them, so that it never names a cell whose files are missing.
bring() { # from, to
    local from=$1 to=$2 file
    mkdir -p "$to"
    [ ! -e "$from/journal.jsonl" ] || cp "$from/journal.jsonl" "$to/.journal.part"
    while IFS= read -r -d '' file; do
        [ "$from/$file" -nt "$to/$file" ] || continue
        mkdir -p "$(dirname "$to/$file")"
        cp -p "$from/$file" "$to/$file.part" && mv "$to/$file.part" "$to/$file"
    done < <(cd "$from" && find . -type f ! -name '.*' ! -name '*.part' ! -path ./journal.jsonl -print0)
    [ ! -e "$to/.journal.part" ] || mv "$to/.journal.part" "$to/journal.jsonl"
}

work=$shard
if [ -n "$SCRATCH" ]; then
    # The name of the folder may contain variables that have a value on the node alone.
    work=$(eval "printf '%s' \"$SCRATCH\"")/ssct-$SLURM_JOB_ID
    bring "$shard" "$work"
    trap 'rm -rf "$work"' EXIT
fi

# Rendering on the CPU, and tracing references, use as many threads as the task has CPUs.
export RAYON_NUM_THREADS=${SLURM_CPUS_PER_TASK:-$CPUS} LP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-$CPUS}
say "${COMMAND[*]} --shard $task/$TASKS"
# ssct runs as a step of the job: Slurm then sends signals to ssct alone, and this script decides what follows.
srun --ntasks=1 "--cpus-per-task=$CPUS" "$SSCT" "${COMMAND[@]}" --shard "$task/$TASKS" --resume -o "$work" &
step=$!
if [ -n "$SCRATCH" ]; then
    (while sleep "$SAVE_EVERY"; do bring "$work" "$shard"; done) &
    saver=$!
fi
status=0
wait "$step" || status=$?
if [ -n "$SCRATCH" ]; then
    kill "$saver" 2>/dev/null || true
    wait "$saver" 2>/dev/null || true
    bring "$work" "$shard"
fi

if [ "$status" -eq 0 ]; then
    touch "$folder/done/$task"
    say 'done'
    exit 0
fi
say "ssct ended with status $status"
# A status above 128 means that a signal ended ssct: at the time limit, before preemption, for lack of memory, or by a user.
if [ "$status" -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt "$RESTARTS" ]; then
    say 'goes back into the queue'
    scontrol requeue "$SLURM_JOB_ID" && sleep 60 # until Slurm ends this attempt
fi
exit "$status"
