#!/usr/bin/env bash
# A task of a study on Slurm: runs one shard, and goes on with its journal where an earlier attempt was stopped or
# killed. submit.sh submits it; nobody else calls it.
set -euo pipefail

folder=$1
source "$folder/study"
source "$folder/settings"
source "$HERE/common.sh"
task=$SLURM_ARRAY_TASK_ID
shard=$folder/shards/$task
say() { printf '%s task %s on %s, attempt %s: %s\n' "$(date +%T)" "$task" "${SLURMD_NODENAME:-$(hostname)}" "$((${SLURM_RESTART_COUNT:-0} + 1))" "$*"; }

[ ! -e "$folder/done/$task" ] || { say 'is done already'; exit 0; }
mkdir -p "$shard"

# Copies what is newer in one folder than in another, each file whole or not at all. The journal says what need not be
# done again, so it is read before all else and written after it.
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
    # The folder's name may hold variables that only the node knows.
    work=$(eval "printf '%s' \"$SCRATCH\"")/ssct-$SLURM_JOB_ID
    bring "$shard" "$work"
    trap 'rm -rf "$work"' EXIT
fi

# Rendering on the CPU and tracing take as many threads as the task has.
export RAYON_NUM_THREADS=${SLURM_CPUS_PER_TASK:-$CPUS} LP_NUM_THREADS=${SLURM_CPUS_PER_TASK:-$CPUS}
say "${COMMAND[*]} --shard $task/$TASKS"
# As a step, so that the signals of Slurm reach ssct and not this script, which says afterwards what is to be done.
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
# Above 128 it was a signal: of the time limit, of who needs the node, of too little memory, or somebody's.
if [ "$status" -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt "$RESTARTS" ]; then
    say 'goes back into the queue'
    scontrol requeue "$SLURM_JOB_ID" && sleep 60 # until Slurm ends this attempt
fi
exit "$status"
