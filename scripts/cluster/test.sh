#!/usr/bin/env bash
# Runs a study on a real Slurm of four nodes, all of them on this machine. Kills a task in the middle, kills another with the
# script around it, loses a node, and compares the merged result with the same study run without Slurm. Then runs a second study,
# whose tasks work in a folder of each node. One task is asked to stop and one is cancelled; the finished shard is merged alone,
# and the missing one is submitted again. Installs Debian's packages if
# they are missing. Configuration, key, logs and state lie in a temporary folder; the daemons listen on the loopback
# address alone, and none of them outlives the script.
#
#   scripts/cluster/test.sh SSCT     the command to test
#
# The environment may set KEEP=1, which keeps the folder, and TASKS (8).
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=scripts/cluster/testing.sh
source "$here/testing.sh"
ssct=$(realpath "${1:?usage: scripts/cluster/test.sh SSCT}")
tasks=${TASKS:-8}
nodes=4

"$here/packages.sh"
export PATH=$PATH:/usr/sbin:/sbin

folder=$(mktemp -d "${TMPDIR:-/tmp}/ssct-cluster.XXXXXX")
chmod 755 "$folder"
export SLURM_CONF=$folder/slurm.conf
# Daemons and submitted jobs get this variable in their environment, so that `ours` finds their processes.
marked=(env "SSCT_CLUSTER_TEST=$folder")
mkdir "$folder"/{log,state}

# with_line prints the ids of the processes that have NAME=VALUE in their environment, with_file of those that have a file open.
# Errors are ignored, since a process may end during the search.
with_line() { { grep -lzxF "$1" /proc/[0-9]*/environ 2>/dev/null || true; } | cut -d/ -f3 | sort -u; }
with_file() { { find /proc/[0-9]*/fd -lname "$1" 2>/dev/null || true; } | cut -d/ -f3 | sort -u; }
# Prints the ids of the processes that this script started. The daemon of a step overwrites its environment with its title, but it
# has its log open.
ours() { { with_line "SSCT_CLUSTER_TEST=$folder" && with_file "$folder/log/*"; } | sort -u; }

# Ends all processes of the test, and removes its folder unless KEEP is set.
stop_all() {
    local status=$? ids n
    trap - EXIT INT TERM
    [ "$status" -eq 0 ] || tail -n 20 "$folder"/log/slurmctld.log "$folder"/study/logs/*.log >&2 2>/dev/null || true
    for n in TERM TERM KILL KILL KILL; do
        ids=$(ours)
        [ -n "$ids" ] || break
        # shellcheck disable=SC2086
        kill -s "$n" $ids 2>/dev/null || true
        sleep 1
    done
    [ -z "$(ours)" ] || { say "these processes are left: $(ours | tr '\n' ' ')"; status=1; }
    if [ -n "${KEEP:-}" ]; then say "kept: $folder"; else rm -rf "$folder"; fi
    exit "$status"
}
trap stop_all EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# Succeeds if no process listens on a port of the loopback address.
is_free() { ! (exec 3<>"/dev/tcp/127.0.0.1/$1") 2>/dev/null; }
# The controller and the nodes listen on adjacent ports. The first ports are random, and the search goes on behind a used port.
first=$((20000 + RANDOM % 20000))
for ((n = 0; n <= nodes; n++)); do
    is_free $((first + n)) || { first=$((first + n + 1)); n=-1; }
done

user=$(id -un)
# Every node is this machine under another port. Two times are short to make the test short. A node counts as lost after 5 seconds
# without an answer. A job that is queued again may start once its credential has expired, after 5 seconds instead of 2 minutes.
cat >"$SLURM_CONF" <<EOF
ClusterName=ssct-test
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$first
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket,cred_expire=5
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=5
KillWait=5
SlurmdParameters=config_overrides
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool.%n
SlurmdPidFile=$folder/slurmd.%n.pid
SlurmctldPidFile=$folder/slurmctld.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/slurmd.%n.log
NodeName=DEFAULT CPUs=1 RealMemory=16000
NodeName=node[1-$nodes] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[$((first + 1))-$((first + nodes))]
PartitionName=main Nodes=ALL Default=YES State=UP MaxTime=INFINITE
EOF

# MUNGE's key is made for this test alone, since whoever has the key may submit jobs.
(umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
"${marked[@]}" munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
    --pid-file="$folder/munged.pid" --log-file="$folder/log/munged.log" --seed-file="$folder/munge.seed"
"${marked[@]}" slurmctld -c
start_node() { mkdir -p "$folder/spool.$1" && "${marked[@]}" slurmd -N "$1"; }
for ((n = 1; n <= nodes; n++)); do start_node "node$n"; done
idle() { [ "$(sinfo -h -t idle -o %D 2>/dev/null)" = "$nodes" ]; }
wait_until "$nodes nodes are idle" idle
say "Slurm $(sinfo --version | cut -d' ' -f2) has $nodes nodes on this machine"
ports=$(seq -s'|' "$first" $((first + nodes)))
if ss -Htln 2>/dev/null | awk '{print $4}' | grep -E ":($ports)\$" | grep -v '^127\.0\.0\.1:'; then
    fail 'a daemon listens on more than the loopback address'
fi

study=(error --scene corridor --method ssct,hzct,unified --size 192x108,176x99 --roughness 0,0.1,0.3,0.6
    --samples 1 --rays 64 --no-sweep)
result=$folder/study
submit() { "${marked[@]}" "$here/submit.sh" -o "$result" --ssct "$ssct" --cpus 1 "$@" -- "${study[@]}"; }
submit --tasks "$tasks" --memory 1500 --time 30
array=$(squeue -h -n ssct -o %F | head -n 1)
# Prints the number of cells that a task has done. The journal has a line for each cell, and more lines for its samples.
entries() { grep -c '^{"key":"error ' "$result/shards/$1/journal.jsonl" 2>/dev/null || true; }

# Sets found and found_on to a task in its middle and its node. The task runs, was not disturbed yet, and has done at least one
# cell but not all.
disturbed=' '
find_running() {
    local n node queued
    while read -r n node; do
        [[ $disturbed == *" $n "* ]] && continue
        if [ "$(entries "$n")" -ge 1 ] 2>/dev/null && [ ! -e "$result/done/$n" ]; then
            found=$n found_on=$node
            return 0
        fi
    done < <(squeue -h -r -t R -n ssct -o '%K %N')
    queued=$(squeue -h -n ssct) || return 1
    [ -n "$queued" ] || fail 'all tasks ended before one could be disturbed'
    return 1
}
# Waits for a task that is in its middle, and keeps a copy of its journal. The caller then disturbs this task, whose number is
# in `found`.
disturb() { # what the caller will do to the task
    wait_until "a task is in its middle, to $1" find_running
    disturbed+="$found "
    cp "$result/shards/$found/journal.jsonl" "$folder/journal-of-$found"
    say "task $found on $found_on, with $(entries "$found") cells done: $1"
}
# Succeeds if a task was started again. Slurm forgets a task five minutes after its end, but the task's log still names its second
# attempt.
was_queued_again() {
    scontrol -o show job "${array}_$1" 2>/dev/null | grep -q 'Restarts=[1-9]' ||
        grep -qs ', attempt [2-9]: ' "$result/logs/$1.log"
}

# The three disturbances follow each other at once, while the first tasks run. A wait in between could last until all tasks are
# done.
disturb 'kill it with its script'
dead=$found
scancel --signal=KILL --batch "${array}_$dead"

disturb 'kill ssct'
killed=$found
scancel --signal=KILL "${array}_$killed.0"

disturb 'lose its node'
lost=$found lost_node=$found_on
# As in a power failure, the daemons of the node and of its steps die before they can report, and so do the commands
# that they run. The daemons have the log of the node open; the commands have its name in their environment.
daemons=$(with_file "$folder/log/slurmd.$lost_node.log")
commands=$(comm -12 <(with_line "SLURMD_NODENAME=$lost_node") <(ours))
# shellcheck disable=SC2086
kill -KILL $daemons $commands 2>/dev/null || true
wait_until "task $killed is queued again" was_queued_again "$killed"
is_down() { sinfo -h -n "$lost_node" -o %T | grep -qE 'down'; }
wait_until "$lost_node is down" is_down
wait_until "task $lost is queued again" was_queued_again "$lost"
say "task $lost is queued again, without $lost_node"

start_node "$lost_node"
is_back() { sinfo -h -n "$lost_node" -o %T | grep -qxE 'idle|allocated|mixed'; }
wait_until "$lost_node is back" is_back
say "$lost_node is back"

# The job that merges leaves the queue after it has merged, failed, or submitted tasks again.
is_empty() { local queued; queued=$(squeue -h) && [ -z "$queued" ]; }
# Waits until all jobs have ended, and fails unless the shards were merged.
merged() {
    wait_until 'no job is left' is_empty
    [ -e "$result/all/error.json" ] || fail 'the tasks were not merged'
}
merged
grep -q "^not done: tasks .*\b$dead\b" "$result/logs/merge.log" ||
    fail "task $dead was not submitted again after all others"
say 'merged'

# Fails unless each task went on with the journal that it had when it was disturbed.
went_on() { # tasks...
    local n
    for n in "$@"; do
        goes_on "$result/shards/$n/journal.jsonl" "$folder/journal-of-$n" ||
            fail "the journal of task $n does not go on where it was"
    done
}
went_on "$killed" "$lost" "$dead"
"$ssct" "${study[@]}" -o "$folder/alone" >"$folder/log/alone.log"
python3 "$here/same.py" "$folder/alone" "$result/all"

# In the second study, each task works in a folder of its node.
study=(error --scene corridor --method ssct,unified --size 192x108 --roughness 0,0.3 --samples 1 --rays 32 --no-sweep)
result=$folder/scratched disturbed=' '
# shellcheck disable=SC2016
scratch=(--scratch "$folder/"'scratch-of-$SLURMD_NODENAME' --save-every 1 --memory 1500 --time 30)
submit --tasks 2 "${scratch[@]}" --retries 0 --partial
array=$(squeue -h -n ssct -o %F | head -n 1)
if submit --tasks 2 2>"$folder/log/refused"; then fail 'the study was submitted twice'; fi
grep -q 'still in the queue' "$folder/log/refused" || fail 'no sentence says why'
scancel "${array}_2"
disturb 'ask it to stop'
[ "$found" = 1 ] || fail 'task 2 runs, though it was cancelled'
scancel --signal=TERM "${array}_1.0"
wait_until 'task 1 is queued again' was_queued_again 1
merged
went_on 1
[ -e "$result/done/1" ] && [ ! -e "$result/done/2" ] || fail 'not task 1 alone is done'
grep -q '^not done: tasks 2$' "$result/logs/merge.log" || fail 'the merge does not name task 2'
[ -z "$(find "$folder"/scratch-of-* -mindepth 1)" ] || fail 'the folders of the nodes are not empty'
submit --tasks 2 "${scratch[@]}" | grep '^tasks 2: ' || fail 'not task 2 alone was submitted again'
merged
[ -e "$result/done/2" ] || fail 'task 2 is not done'
submit --tasks 2 | grep '^all 2 tasks are done' || fail 'something is left to do'
if submit --tasks 3 2>"$folder/log/refused"; then fail 'another number of shards was taken'; fi
grep -q 'holds another study, or another number of shards' "$folder/log/refused" || fail 'no sentence says why'
"$ssct" "${study[@]}" -o "$folder/alone-too" >"$folder/log/alone-too.log"
python3 "$here/same.py" "$folder/alone-too" "$result/all"
say "passed in $SECONDS s"
