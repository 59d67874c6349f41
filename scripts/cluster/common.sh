# Functions of submit.sh and of the two jobs that it submits, task.sh and collect.sh. This file is sourced, not run.

# Says what failed, and ends with status 1.
fail() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }

# Prints the numbers of the tasks of a study that are not done. A task makes the file done/N once ssct has succeeded.
unfinished() { # folder, tasks
    local n
    for ((n = 1; n <= $2; n++)); do
        [ -e "$1/done/$n" ] || printf '%s\n' "$n"
    done
}

# Submits tasks as an array, and the job of collect.sh, which starts when all tasks of the array have ended. Each round asks for
# twice the memory of the round before: a task that had enough time has most likely failed for lack of memory.
submit_round() { # folder, round, tasks...
    local folder=$1 round=$2 array='' list variable
    shift 2
    # In a job, sbatch would take the variables that describe the job for options of the next one.
    for variable in "${!SLURM_@}"; do [ "$variable" = SLURM_CONF ] || unset "$variable"; done
    list=$(IFS=,; echo "$*")
    local options=("--chdir=$folder" --requeue --open-mode=append "${SBATCH[@]}")
    local dependency=()
    if [ $# -gt 0 ]; then
        array=$(sbatch --parsable "${options[@]}" --job-name=ssct "--array=$list" --ntasks=1 "--cpus-per-task=$CPUS" \
            "--time=$MINUTES" "--mem=$((MEMORY_MIB << round))" "--signal=TERM@$GRACE" "--output=$folder/logs/%a.log" \
            "$HERE/task.sh" "$folder") || fail 'sbatch refused the tasks'
        array=${array%%;*}
        echo "$array" >>"$folder/jobs"
        dependency=("--dependency=afterany:$array")
    fi
    local collect
    collect=$(sbatch --parsable "${options[@]}" --job-name=ssct-merge "${dependency[@]}" --ntasks=1 --time=60 \
        "--mem=$MEMORY_MIB" "--output=$folder/logs/merge.log" "$HERE/collect.sh" "$folder" "$round") ||
        fail "sbatch refused the merge; the tasks are job ${array:-none}"
    echo "${collect%%;*}" >>"$folder/jobs"
    echo "tasks ${list:-none}: job ${array:-none}, $MINUTES minutes and $((MEMORY_MIB << round)) MiB each;" \
        "merge: job ${collect%%;*}"
}
