# What the scripts of this folder share. It is sourced, not run.

# Says what is wrong with the arguments, and ends with status 2.
wrong() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 2; }

# Says what failed, and ends with status 1.
fail() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }

# The tasks of a study that are not done, by number. A task makes its mark when ssct ended well.
unfinished() { # folder, tasks
    local n
    for ((n = 1; n <= $2; n++)); do
        [ -e "$1/done/$n" ] || printf '%s\n' "$n"
    done
}

# Sets MINUTES and MEMORY_MIB where they are empty: from the cost model, if the command has one.
plan_resources() {
    local plan='' minutes mib
    if [ -z "$MINUTES" ] || [ -z "$MEMORY_MIB" ]; then
        # A command without a cost model has no such option.
        plan=$("$SSCT" "${COMMAND[@]}" --plan "$TASKS" --json ${COSTS:+--costs "$COSTS"} 2>/dev/null) || plan=''
    fi
    if [ -n "$plan" ]; then
        read -r minutes mib <<<"$(python3 "$here/plan.py" "$CPUS" <<<"$plan")"
        MINUTES=${MINUTES:-$minutes} MEMORY_MIB=${MEMORY_MIB:-$mib}
    fi
    [ -n "$MINUTES" ] || fail "nothing predicts the time of ssct ${COMMAND[0]}: give --time MINUTES"
    MEMORY_MIB=${MEMORY_MIB:-4096}
}

# Submits tasks as an array, and after it the job that looks at how they ended. A round after the first asks for twice
# the memory of the one before, since too little of it is why a task with enough time fails.
submit_round() { # folder, round, tasks...
    local folder=$1 round=$2 array='' list variable
    shift 2
    # In a job, these describe the job, and would be taken for wishes of the next.
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
