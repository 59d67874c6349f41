#!/usr/bin/env bash
# Submits a study to Slurm: an array of tasks, one for each shard, and a job that merges the shards to one result. The
# same command again submits the tasks that failed for good.
#
#   scripts/cluster/submit.sh --tasks N -o DIR [options] -- error --scene rooms --rays 256 ...
#
# The two dashes are followed by a command of ssct with its options, without --shard, --resume and -o. Every node must
# see DIR under the same path. DIR then holds shards/1 to shards/N, logs/ and, once all tasks are done, the result in
# all/. docs/many-machines.md explains what happens when a task is killed or a node is lost.
set -euo pipefail

HERE=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=scripts/cluster/common.sh
source "$HERE/common.sh"

# Says what is wrong with the arguments, and ends with status 2.
wrong() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 2; }

usage() {
    cat <<'EOF'
usage: submit.sh --tasks N -o DIR [options] -- COMMAND [options of the command]

  --tasks N        shards, each a task of the array
  -o, --output DIR the study's folder, on a file system that all nodes share
  --ssct FILE      the command ssct [default: the variable SSCT, else target/release or target/debug of this repository]
  --time MINUTES   time limit of a task, after which it goes back into the queue and goes on [default: 60]
  --memory MIB     memory of a task [default: 4096]
  --cpus N         threads of a task [default: 2]
  --scratch DIR    work in a folder that each node has for itself, and copy back; variables such as $TMPDIR are
                   replaced on the node, if DIR is quoted here
  --save-every S   with --scratch: seconds between two copies back [default: 60]
  --grace S        seconds before the time limit at which a task is asked to stop, to be queued again [default: 120]
  --restarts N     how often Slurm may queue a task again [default: 5]
  --retries N      how often tasks that failed are submitted again before merging [default: 1]
  --partial        if tasks failed for good, merge the other shards, and name the cells that are missing
  --sbatch WORD    an option for sbatch, such as --partition=gpu; may be given more than once
EOF
}

TASKS='' OUTPUT='' SSCT=${SSCT:-} MINUTES=60 MEMORY_MIB=4096 CPUS=2 SCRATCH='' SAVE_EVERY=60 GRACE=120
RESTARTS=5 RETRIES=1 PARTIAL='' SBATCH=()
while [ $# -gt 0 ]; do
    case $1 in
        --) shift; break ;;
        -h | --help) usage; exit 0 ;;
        --partial) PARTIAL=1; shift; continue ;;
        --tasks | --time | --memory | --cpus | --save-every | --grace | --restarts | --retries)
            [[ ${2:-} =~ ^[0-9]+$ ]] || wrong "$1 takes a whole number, not '${2:-}'" ;;
        -o | --output | --ssct | --scratch | --sbatch) [ -n "${2:-}" ] || wrong "$1 lacks its value" ;;
        *) wrong "unknown option '$1'; --help lists all" ;;
    esac
    case $1 in
        --tasks) TASKS=$2 ;;
        -o | --output) OUTPUT=$2 ;;
        --ssct) SSCT=$2 ;;
        --time) MINUTES=$2 ;;
        --memory) MEMORY_MIB=$2 ;;
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
[ ${#COMMAND[@]} -gt 0 ] || wrong 'no command: after -- comes one of ssct, such as error'
case ${COMMAND[0]} in
    error | stress | figures | time) ;;
    *) wrong "ssct ${COMMAND[0]} has no shards that are folders: error, stress, figures and time have" ;;
esac
for word in "${COMMAND[@]}"; do
    case $word in --shard* | --resume | -o | --output*) wrong "$word is set by this script" ;; esac
done
[ "${TASKS:-0}" -ge 1 ] || wrong '--tasks must be at least 1'
[ "$CPUS" -ge 1 ] || wrong '--cpus must be at least 1'
[ -n "$OUTPUT" ] || wrong 'no folder: -o DIR'
command -v sbatch >/dev/null || fail 'no sbatch on the PATH: this machine submits to no Slurm'

root=$(cd "$HERE/../.." && pwd)
for candidate in "$root/target/release/ssct" "$root/target/debug/ssct"; do
    if [ -z "$SSCT" ] && [ -x "$candidate" ]; then SSCT=$candidate; fi
done
[ -n "$SSCT" ] && [ -x "$SSCT" ] || fail "no ssct to run: build it, or name it with --ssct"
SSCT=$(realpath "$SSCT")
mkdir -p "$OUTPUT/shards" "$OUTPUT/logs" "$OUTPUT/done"
OUTPUT=$(realpath "$OUTPUT")

# A folder belongs to one study in one number of shards. The settings of its tasks may change with each submission.
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

: >"$OUTPUT/jobs"
declare -p HERE SSCT MINUTES MEMORY_MIB CPUS SCRATCH SAVE_EVERY GRACE RESTARTS RETRIES PARTIAL SBATCH \
    >"$OUTPUT/settings.part"
mv "$OUTPUT/settings.part" "$OUTPUT/settings"

submit_round "$OUTPUT" 0 "${missing[@]}"
