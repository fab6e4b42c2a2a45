#!/usr/bin/env bash
# Tries the Slurm recipe of docs/ci.md, as it stands there, on a Slurm of one node that is set up in a folder
# of its own and taken down again: all parts and their merge; a part that is killed, whose merge must not run;
# the same part sent again, which goes on where it was. Only scenes, structures and the constraint are smaller.
# Seen to work on Debian 12 (Slurm 22.05, control groups of version 1). Needs root (slurmd starts steps), slurm-wlm
# and munge; says what is missing and ends with 77 then.
# usage: [RTBENCH=target/release/rtbench] scripts/slurm-try.sh
set -euo pipefail
cd "$(dirname "$0")/.."
for program in munged slurmctld slurmd sbatch squeue scancel scontrol; do
    PATH=$PATH:/usr/sbin command -v "$program" > /dev/null || missing="${missing:-} $program"
done
[ "$(id -u)" = 0 ] || missing="${missing:-} root"
if [ -n "${missing:-}" ]; then
    echo "slurm-try: not tried, missing:$missing (Debian: apt-get install slurm-wlm munge)" >&2
    exit 77
fi
if [ -z "${RTBENCH:-}" ]; then
    cargo build -q --release -p rtbench
    RTBENCH=${CARGO_TARGET_DIR:-target}/release/rtbench
fi
docs=$PWD/docs/ci.md
work=$(mktemp -d)
chmod 755 "$work"
mkdir "$work/bin" "$work/jobs" "$work/state" "$work/spool"
cp "$RTBENCH" "$work/bin/rtbench"
export PATH="$work/bin:$PATH:/usr/sbin" SLURM_CONF=$work/slurm.conf RTBENCH_CONFIG=
daemons=()
ended() {
    status=$?
    for pid in "${daemons[@]}"; do kill "$pid" 2> "$work/kill.log" || true; done
    wait
    [ "$status" = 0 ] || tail -n 5 "$work"/*.log "$work"/jobs/slurm-*.out >&2 || true
    rm -rf "$work"
    exit "$status"
}
trap ended EXIT

# a cluster of this machine alone
head -c 1024 /dev/urandom > "$work/munge.key"
chmod 400 "$work/munge.key"
host=$(hostname -s)
cat > "$SLURM_CONF" << CONF
ClusterName=tried
SlurmctldHost=$host
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
SlurmctldPort=16817
SlurmdPort=16818
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
KillWait=5
SchedulerParameters=sched_interval=1,batch_sched_delay=0,bf_interval=1
$(slurmd -C | head -n 1 | sed "s/RealMemory=.*//")  Features=epyc State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
echo "CgroupPlugin=cgroup/v1" > "$work/cgroup.conf"
munged --foreground --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munge.pid" \
    --seed-file="$work/munge.seed" --log-file="$work/munged.log" --force 2> "$work/munge.log" &
daemons+=($!)
slurmctld -D > "$work/slurmctld.log" 2>&1 &
daemons+=($!)
slurmd -D > "$work/slurmd.log" 2>&1 &
daemons+=($!)
for _ in $(seq 60); do
    sinfo -h -o %t 2> "$work/sinfo.log" | grep -q idle && break
    sleep 0.5
done
sinfo -h -o "slurm-try: %v, a node that is %t"

# the recipe: the blocks of docs/ci.md that begin with #!, in their order, and the two lines that send them
cd "$work/jobs"
awk -v folder="$work/jobs" '
    /^```sh$/ { fenced = 1; first = 1; next }
    /^```$/ { fenced = 0; file = "" }
    fenced && first { first = 0; if (/^#!/) file = folder "/" (++n == 1 ? "array.sh" : "merge.sh") }
    file != "" { print > file }
' "$docs"
sed -n 's/^array=/array=/p; s/^sbatch --dependency/merge=$(sbatch --parsable --dependency/p' "$docs" |
    sed '/^merge=/s/$/)/' > send.sh
for file in array.sh merge.sh send.sh; do
    [ -s "$file" ] || { echo "slurm-try: docs/ci.md has no $file" >&2; exit 1; }
done
# small enough for a minute, and the reason why there are eight parts is gone
sed -i "s|run real --time-budget 30m|run tetra:3 balls:2 --size 64 --time-budget 4s -s kd-tree,octree,uniform-grid,wide-bvh|
    s|1-8|1-3|; s|/8 -o|/3 -o|" array.sh
sed -i 's| part-4.* -o| -o|' merge.sh
grep -q tetra:3 array.sh && grep -q 'part-3 -o all' merge.sh

# how jobs ended, by the number of the job or of its part
state() { scontrol -o show job "$1" | tr ' ' '\n' | sed -n 's/^JobState=//p'; }
finish() { while [ -n "$(squeue -h -j "$1" 2> "$work/squeue.log")" ]; do sleep 0.5; done; }
is() { # JOB STATE
    local found
    found=$(state "$1" | sort -u | tr '\n' ' ')
    [ "$found" = "$2 " ] || { echo "slurm-try: job $1 is $found, not $2" >&2; exit 1; }
}
joined() {
    rtbench run tetra:3 balls:2 --size 64 --time-budget 4s -s kd-tree,octree,uniform-grid,wide-bvh --quiet -o whole > "$work/whole.txt"
    # the same rows, in the same order, with the same counters
    for folder in all whole; do cut -d , -f 1-3 "$folder/results.csv" > "$folder.rows"; done
    cmp all.rows whole.rows
    echo "slurm-try: $1: the merge has the $(($(wc -l < all.rows) - 1)) rows of an undivided run"
    rm -rf part-* all whole
}

# 1. as it stands there
. ./send.sh
finish "$merge"
is "$array" COMPLETED
is "$merge" COMPLETED
joined "three parts"

# 2. part 2 is ended midway: its merge is cancelled. Sent again it goes on, and the merge has all
. ./send.sh
until [ "$(cat part-2/results.csv 2> "$work/cat.log" | wc -l)" -gt 1 ]; do sleep 0.1; done # its first scene of two
scancel "${array}_2"
finish "$merge"
is "$merge" CANCELLED
[ ! -e all ] || { echo "slurm-try: a merge of parts that are not all there" >&2; exit 1; }
if rtbench merge part-1 part-2 part-3 -o all > "$work/refused.txt" 2>&1; then
    echo "slurm-try: a merge of parts that are not all there" >&2
    exit 1
fi
tail -n 1 "$work/refused.txt"
again=$(sbatch --parsable --array=2 array.sh)
finish "$again"
is "$again" COMPLETED
finish "$(sbatch --parsable merge.sh)"
joined "part 2 ended midway and sent again"
