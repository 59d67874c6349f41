#!/usr/bin/env bash
# Submits a study to Slurm: an array of tasks, each a shard of it, and a job that merges them to one result. The same
# command again goes on where tasks failed for good.
#
#   scripts/cluster/submit.sh --tasks N -o DIR [options] -- error --scene rooms --rays 256 ...
#
# What follows the two dashes is a command of ssct with its options, without --shard, --resume and -o. In DIR, which
# every node must see under the same path, are then shards/1 to shards/N, logs/ and, when all is done, the result in
# all/. docs/many-machines.md explains what happens when a task is killed or a node is lost.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=scripts/cluster/common.sh
source "$here/common.sh"

usage() {
    cat <<'EOF'
usage: submit.sh --tasks N -o DIR [options] -- COMMAND [options of the command]

  --tasks N        shards, each a task of the array
  -o, --output DIR the study's folder, on a file system that all nodes share
  --ssct FILE      the command ssct [default: the variable SSCT, else target/release or target/debug of this repository]
  --time MINUTES   time limit of a task [default: twice what ssct COMMAND --plan predicts, and ten minutes; a command
                   without a plan needs it]
  --memory MIB     memory of a task [default: what ssct COMMAND --plan predicts, else 4096]
  --costs DIR      a run of ssct error on these machines, whose costs are taken for the prediction
  --cpus N         threads of a task [default: 2]
  --scratch DIR    work in a folder that each node has for itself, and copy back; variables such as $TMPDIR are
                   replaced on the node, if DIR is quoted here
  --save-every S   with --scratch: seconds between two copies back [default: 60]
  --grace S        seconds before the time limit at which a task is asked to stop, to be queued again [default: 120]
  --restarts N     how often Slurm may queue a task again [default: 5]
  --retries N      how often tasks that failed are submitted again before merging [default: 1]
  --partial        merge what there is, if tasks failed for good, and name what is missing
  --sbatch WORD    an option for sbatch, such as --partition=gpu; may be given more than once
EOF
}

TASKS='' OUTPUT='' SSCT=${SSCT:-} MINUTES='' MEMORY_MIB='' COSTS='' CPUS=2 SCRATCH='' SAVE_EVERY=60 GRACE=120
RESTARTS=5 RETRIES=1 PARTIAL='' SBATCH=()
while [ $# -gt 0 ]; do
    case $1 in
        --) shift; break ;;
        -h | --help) usage; exit 0 ;;
        --partial) PARTIAL=1; shift; continue ;;
        --tasks | --time | --memory | --cpus | --save-every | --grace | --restarts | --retries)
            [[ ${2:-} =~ ^[0-9]+$ ]] || wrong "$1 takes a whole number, not '${2:-}'" ;;
        -o | --output | --ssct | --costs | --scratch | --sbatch) [ -n "${2:-}" ] || wrong "$1 lacks its value" ;;
        *) wrong "unknown option '$1'; --help lists all" ;;
    esac
    case $1 in
        --tasks) TASKS=$2 ;;
        -o | --output) OUTPUT=$2 ;;
        --ssct) SSCT=$2 ;;
        --time) MINUTES=$2 ;;
        --memory) MEMORY_MIB=$2 ;;
        --costs) COSTS=$2 ;;
        --cpus) CPUS=$2 ;;
        --scratch) SCRATCH=$2 ;;
        --save-every) SAVE_EVERY=$2 ;;
        --grace) GRACE=$2 ;;
        --restarts) RESTARTS=$2 ;;
        --retries) RETRIES=$2 ;;
        --sbatch) SBATCH+=("$2") ;;
    esac
    shift 2
done
COMMAND=("$@")
[ ${#COMMAND[@]} -gt 0 ] || wrong 'no command: what follows -- is one of ssct, such as error'
case ${COMMAND[0]} in
    error | stress | figures | time) ;;
    *) wrong "ssct ${COMMAND[0]} has no shards that are folders: error, stress, figures and time have" ;;
esac
for word in "${COMMAND[@]}"; do
    case $word in --shard* | --resume | -o | --output* | --plan*) wrong "$word is set by this script" ;; esac
done
[ "${TASKS:-0}" -ge 1 ] || wrong '--tasks must be at least 1'
[ "$CPUS" -ge 1 ] || wrong '--cpus must be at least 1'
[ -n "$OUTPUT" ] || wrong 'no folder: -o DIR'
command -v sbatch >/dev/null || fail 'no sbatch on the PATH: this machine submits to no Slurm'

root=$(cd "$here/../.." && pwd)
for candidate in "$root/target/release/ssct" "$root/target/debug/ssct"; do
    if [ -z "$SSCT" ] && [ -x "$candidate" ]; then SSCT=$candidate; fi
done
[ -n "$SSCT" ] && [ -x "$SSCT" ] || fail "no ssct to run: build it, or name it with --ssct"
SSCT=$(realpath "$SSCT")
mkdir -p "$OUTPUT/shards" "$OUTPUT/logs" "$OUTPUT/done"
OUTPUT=$(realpath "$OUTPUT")

# A folder belongs to one study in one number of shards. How tasks are run may change from one submission to the next.
study=$(declare -p TASKS COMMAND)
if [ -e "$OUTPUT/study" ] && [ "$(cat "$OUTPUT/study")" != "$study" ]; then
    fail "$OUTPUT holds another study, or another number of shards: take another folder"
fi
printf '%s\n' "$study" >"$OUTPUT/study"

missing=($(unfinished "$OUTPUT" "$TASKS"))
if [ ${#missing[@]} -eq 0 ] && [ -d "$OUTPUT/all" ]; then
    echo "all $TASKS tasks are done: $OUTPUT/all"
    exit 0
fi

if [ -s "$OUTPUT/jobs" ] && [ -n "$(squeue -h -j "$(paste -sd, "$OUTPUT/jobs")" 2>/dev/null || true)" ]; then
    fail "jobs of $OUTPUT are still in the queue: $(paste -sd' ' "$OUTPUT/jobs")"
fi

plan_resources
: >"$OUTPUT/jobs"
HERE=$here
declare -p HERE SSCT MINUTES MEMORY_MIB CPUS SCRATCH SAVE_EVERY GRACE RESTARTS RETRIES PARTIAL SBATCH >"$OUTPUT/settings.part"
mv "$OUTPUT/settings.part" "$OUTPUT/settings"

submit_round "$OUTPUT" 0 "${missing[@]}"
