#!/usr/bin/env bash
# How long a run takes to end after Ctrl-C: 20 times, at random moments of scenes whose builds take
# seconds. Prints the milliseconds of each and the most. Argument: the program (target/release).
set -euo pipefail
cd "$(dirname "$0")/.."
program=${1:-target/release/rtbench}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
most=0
for i in $(seq 20); do
    "$program" run tetra:1 balls:6 -q -s kay-kajiya,kd-tree,octree,obvhs-cwbvh -o "$folder/$i" \
        > /dev/null 2> "$folder/err" &
    child=$!
    sleep "$((1 + RANDOM % 6)).$((RANDOM % 10))"
    begin=$(date +%s%N)
    kill -INT "$child"
    code=0
    wait "$child" || code=$?
    ms=$((($(date +%s%N) - begin) / 1000000))
    [ "$ms" -le "$most" ] || most=$ms
    echo "$i: exit code $code after $ms ms; $(tr -d '\n' < "$folder/err")"
    grep -q interrupted "$folder/$i/run.jsonl" || { echo "not marked"; exit 1; }
done
echo "most: $most ms"
