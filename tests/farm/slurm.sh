#!/bin/bash
# `fstop farm slurm` on a real Slurm: four nodes on this machine, each in a process namespace of its own so that it can
# be lost whole. Tasks are requeued, run out of time, are preempted, lose their node, are cut off from the cluster and
# canceled; every picture must be that of one undisturbed process, bit for bit. Run by hand, as root, in a container or
# a machine without another Slurm; it takes about ten minutes of two processors:
#
#   apt-get install slurmctld slurmd slurm-client munge
#   cargo build --release
#   bash tests/farm/slurm.sh [CASE...]        # by default all, see the end
#
# FSTOP names another program than target/release/fstop, SPP other samples a pixel than 768 (80 s of one processor).
set -euo pipefail
cd "$(dirname "$0")/../.."
fstop=$(realpath "${FSTOP:-target/release/fstop}")
scene=$PWD/scenes/course/dgauss.pbrt
spp=${SPP:-768}
nodes=(node1 node2 node3 node4)
work=$(mktemp -d /tmp/fstop-slurm.XXXXXX)
export SLURM_CONF=$work/slurm.conf

# ---- The cluster -----------------------------------------------------------------------------------------------------

write_configuration() {
    local host n
    host=$(hostname -s)
    cat >"$SLURM_CONF" <<END
ClusterName=fstop
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
CredType=cred/munge
# A requeued job starts again after this many seconds; by default two minutes.
AuthInfo=socket=$work/munge.socket,cred_expire=5
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool.%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.%n.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=bf_interval=2,sched_interval=2,batch_sched_delay=0
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
# A node that is down comes back when it registers.
ReturnToService=2
SlurmdTimeout=10
KillWait=10
MinJobAge=3600
PartitionName=low Nodes=ALL Default=YES PriorityTier=1
PartitionName=high Nodes=ALL PriorityTier=10 PreemptMode=OFF
END
    for n in "${!nodes[@]}"; do
        echo "NodeName=${nodes[n]} NodeHostname=$host NodeAddr=127.0.0.1 Port=$((26821 + n)) CPUs=1"
    done >>"$SLURM_CONF"
}

start_node() { # NODE
    mkdir -p "$work/spool.$1"
    # The shell stays when slurmd dies, and the node's other processes with it.
    unshare --pid --fork --mount-proc --kill-child \
        bash -c 'slurmd -D -N "$0"; sleep infinity' "$1" >/dev/null 2>&1 &
    echo $! >"$work/$1.pid"
}

# As if its power failed: all its processes are killed at once.
lose_node() { # NODE
    kill -9 "$(cat "$work/$1.pid")"
}

# As if its network failed: its tasks go on.
cut_off_node() { # NODE
    kill -9 "$(pgrep -x slurmd --ns "$(pgrep -P "$(cat "$work/$1.pid")")" --nslist pid)"
}

start_cluster() {
    mkdir "$work/state"
    (umask 077 && head -c 1024 /dev/urandom >"$work/munge.key")
    munged --force --socket="$work/munge.socket" --key-file="$work/munge.key" --seed-file="$work/munge.seed" \
        --pid-file="$work/munged.pid" --log-file="$work/munged.log"
    write_configuration
    slurmctld
    local node
    for node in "${nodes[@]}"; do start_node "$node"; done
    wait_for 30 nodes_are_idle
}

nodes_are_idle() { [[ $(sinfo -h -p low -t idle -o %D) == "${#nodes[@]}" ]]; }

stop_cluster() {
    local node
    for node in "${nodes[@]}"; do lose_node "$node" 2>/dev/null || true; done
    for daemon in slurmctld munged; do kill "$(cat "$work/$daemon.pid")" 2>/dev/null || true; done
    echo "logs and pictures: $work"
}

# ---- What the cases are made of --------------------------------------------------------------------------------------

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

# Waits until a command succeeds.
wait_for() { # SECONDS COMMAND...
    local end=$((SECONDS + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        ((SECONDS < end)) || fail "waited in vain for: $*"
        sleep 0.2
    done
}

# Writes the scripts of a case into a folder of its own, with a name that shells would take apart.
write_scripts() { # CASE SHARDS
    mkdir -p "$work/$1"
    cd "$work/$1"
    "$fstop" farm slurm "$scene" --shards "$2" -o "it's a picture.exr" --requeue -- \
        --spp "$spp" --checkpoint-every 1s >submit
    sed 's/^/    /' submit
}

# Submits both, as the command says, with further options of sbatch for the array. Sets `job` and `merge`.
submit() { # OPTIONS...
    job=$(sbatch --parsable "$@" "it's a picture.render.sbatch")
    merge=$(sbatch --parsable --dependency="afterok:$job" --kill-on-invalid-dep=yes "it's a picture.merge.sbatch")
}

# `Restarts`, `JobState` or `BatchHost` of a task or job.
field() { # NAME JOB
    scontrol -o show job "$2" | sed "s/.* $1=\([^ ]*\).*/\1/" | head -1
}

is() { [[ $(field "$1" "$2") == "$3" ]]; }

# A task has kept work: more of it than a checkpoint starts with.
has_kept() { # SHARD SHARDS
    [[ $(stat -c %s "it's a picture.shard-$1-of-$2.fsc") -gt 100000 ]]
}

at_work() { # SHARD SHARDS
    wait_for 120 is JobState "${job}_$1" RUNNING
    wait_for 60 has_kept "$1" "$2"
    file=$(stat -c %i "it's a picture.shard-$1-of-$2.fsc")
}

# The file of a shard is the one that was there when `at_work` looked: a render that begins anew makes another.
continued() { # SHARD SHARDS
    [[ $(stat -c %i "it's a picture.shard-$1-of-$2.fsc") == "$file" ]] || fail "shard $1 was begun anew"
}

restarted() { # SHARD SHARDS
    continued "$1" "$2"
    (($(field Restarts "${job}_$1") > 0)) || fail "task $1 has not been restarted"
}

# Waits for the merge and compares its picture with the undisturbed one.
same_picture() { # CASE
    wait_for 900 has_ended "$merge"
    is JobState "$merge" COMPLETED || fail "$1: the merge is $(field JobState "$merge")"
    local hash
    hash=$(sha256sum <"it's a picture.exr")
    echo "$1: ${hash%% *}"
    cmp "it's a picture.exr" "$work/undisturbed.exr" || fail "$1: another picture"
}

has_ended() { [[ $(field JobState "$1") =~ COMPLETED|FAILED|CANCELLED|TIMEOUT ]]; }

# ---- The cases -------------------------------------------------------------------------------------------------------

undisturbed() {
    "$fstop" render "$scene" -o "$work/undisturbed.exr" --spp "$spp" --no-checkpoint --quiet
    local hash
    hash=$(sha256sum <"$work/undisturbed.exr")
    echo "one process: ${hash%% *}"
}

array() {
    write_scripts array 8
    submit
    same_picture array
}

requeue() {
    write_scripts requeue 8
    submit
    at_work 1 8
    scontrol requeue "${job}_1"
    same_picture requeue
    restarted 1 8
}

# A shard that takes longer than its time limit, which is a minute here; Slurm looks every half minute.
time_limit() {
    write_scripts time_limit 1
    submit --time=1 --signal=B:USR1@20
    at_work 1 1
    same_picture time_limit
    restarted 1 1
    grep -q "back into the queue" "fstop-it_s_a_picture-${job}_1.log" || fail "the script has not requeued"
}

preemption() {
    write_scripts preemption 8
    submit
    at_work 1 8
    sbatch --partition=high --nodes=4 --exclusive --output=/dev/null --wrap="sleep 5" >/dev/null
    same_picture preemption
    restarted 1 8
}

node_lost() {
    write_scripts node_lost 8
    submit
    at_work 1 8
    local node
    node=$(field BatchHost "${job}_1")
    lose_node "$node"
    scontrol update NodeName="$node" State=down Reason=lost
    sleep 3
    start_node "$node"
    same_picture node_lost
    restarted 1 8
}

# Only slurmd dies: the task goes on, unknown to Slurm, which starts it once more. Both write the same shard.
node_cut_off() {
    # Long enough to be at work twice at once.
    write_scripts node_cut_off 2
    submit
    at_work 1 2
    local node
    node=$(field BatchHost "${job}_1")
    cut_off_node "$node"
    scontrol update NodeName="$node" State=down Reason="cut off"
    same_picture node_cut_off
    restarted 1 2
    grep -q "another render is writing" "fstop-it_s_a_picture-${job}_1.log" || fail "task 1 has not met itself"
    lose_node "$node"
    start_node "$node"
    wait_for 30 nodes_are_idle
}

cancel() {
    write_scripts cancel 8
    submit
    at_work 1 8
    scancel "$job"
    wait_for 60 is JobState "${job}_1" CANCELLED
    sleep 10
    [[ -z $(squeue -h -j "$job" 2>/dev/null) ]] || fail "a canceled job has come back"
    submit
    same_picture cancel
    continued 1 8
}

trap stop_cluster EXIT
start_cluster
undisturbed
for case in "${@:-}"; do
    case $case in
        "") for all in array requeue time_limit preemption node_lost node_cut_off cancel; do "$all"; done ;;
        *) "$case" ;;
    esac
done
echo "all the same"
