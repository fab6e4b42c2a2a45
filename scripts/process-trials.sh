#!/usr/bin/env bash
# Do intervals of `rtbench run --processes N` hold what the next run finds? Runs the same table RUNS times, one
# run after the other, and counts, over all ordered pairs of runs: how many medians of one run lie in the
# interval of the other, and how many pairs of intervals have no common point. Fails below 80% and
# above 1%.
# usage: scripts/process-trials.sh [RUNS] [PROCESSES] [ROUNDS]
# BINARY=FILE builds nothing and takes that program; KEEP=DIR keeps each run's results there;
# SCENES="tetra ..." and ROWS=a,b,... measure another table.
set -euo pipefail
cd "$(dirname "$0")/.."
runs=${1:-8} processes=${2:-3} rounds=${3:-9}
read -ra scenes <<<"${SCENES:-tetra teapot balls tree}"
rows=${ROWS:-kd-tree,uniform-grid,irregular-grid,wide-bvh,obvhs-bvh2,obvhs-cwbvh}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
keep=${KEEP:-$work}
mkdir -p "$keep"
if [ -z "${BINARY:-}" ]; then
    cargo build -q --release
    BINARY=${CARGO_TARGET_DIR:-target}/release/rtbench
fi
for i in $(seq "$runs"); do
    start=$SECONDS
    "$BINARY" -q run "${scenes[@]}" -s "$rows" --reference obvhs-cwbvh --processes "$processes" \
        --rounds "$rounds" --overwrite -o "$keep/$i" >/dev/null
    echo "run $i: $((SECONDS - start)) s, load $(cut -d' ' -f1 /proc/loadavg)" >&2
done
python3 scripts/intervals-of-runs.py "$keep"/*/results.json
