#!/usr/bin/env bash
# A soak: 1,000 short runs (or as many as the second argument says), and one run of as many scenes. At the end
# memory, threads, open files and temporary files must be what they were at the beginning.
# Arguments: [PROGRAM (target/release/rtbench)] [RUNS].
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-target/release/rtbench}")
runs=${2:-1000}
part=$((runs / 10))
work=$(mktemp -d)
child=
trap '[ -z "$child" ] || kill "$child" 2> /dev/null || true; rm -rf "$work"' EXIT
mkdir "$work/tmp" "$work/home" "$work/scenes"
export TMPDIR=$work/tmp HOME=$work/home
settings=(-q --size 4 --rounds 1 --rays primary -s obvhs-cwbvh,uniform-grid)
files() { find "$work/tmp" "$work/home" | wc -l; }

# the largest of the numbers in a file, from line $2 to line $3
most() { sed -n "$2,$3p" "$1" | sort -n | tail -1; }
# fails where $3 is more than $4 percent beyond $2
same() {
    echo "$1: $2 at the beginning, $3 at the end"
    [ $(($3 * 100)) -le $(($2 * (100 + $4))) ] || { echo "$1 grew"; failed=1; }
}
failed=0

before=$(files)
for i in $(seq "$runs"); do
    python3 - "$program" run tetra:1 "${settings[@]}" -o "$work/out" --overwrite >> "$work/rss" <<'PYTHON'
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
PYTHON
    [ "$i" != "$part" ] || written=$(find "$work/out" | wc -l)
done
same "$runs processes, most KiB resident" "$(most "$work/rss" 1 "$part")" \
    "$(most "$work/rss" "$((runs - part + 1))" "$runs")" 5
same "files of results" "$written" "$(find "$work/out" | wc -l)" 0
same "temporary files" "$before" "$(files)" 0

# one process: what it holds while its scenes pass by
for i in $(seq "$runs"); do
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 %s\nf 1 2 3\n' "$i" > "$work/scenes/s$i.obj"
done
"$program" run "$work"/scenes/*.obj "${settings[@]}" -o "$work/long" > "$work/shown" &
child=$!
while kill -0 "$child" 2> /dev/null; do
    if [ -e "$work/long/run.jsonl" ]; then
        # two lines more than these are of the run itself
        done=$(grep -c '"finished"' "$work/long/run.jsonl" || true)
        held=$(awk '/^VmRSS|^Threads/ { printf "%s ", $2 }' "/proc/$child/status" 2> /dev/null || true)
        open=$(ls "/proc/$child/fd" 2> /dev/null | wc -l || true)
        [ -z "$held" ] || [ "$open" = 0 ] || echo "$done $held $open" >> "$work/held"
    fi
    sleep 0.1
done
wait "$child"
child=
finished=$(grep -c '"finished"' "$work/long/run.jsonl")
echo "one process: $finished scenes"
[ "$finished" = "$runs" ] || failed=1
# the record itself grows with its scenes: it may take as much as its text a few times over
record=$(($(stat -c %s "$work/long/results.json") / 1024))
early() { awk -v p="$part" -v c="$1" '$1 >= p / 2 && $1 <= 2 * p && $c > m { m = $c } END { print m + 0 }' "$work/held"; }
late() { awk -v p="$part" -v r="$runs" -v c="$1" '$1 >= r - p && $c > m { m = $c } END { print m + 0 }' "$work/held"; }
echo "KiB resident: $(early 2), then $(late 2); the record has $record KiB"
[ "$(late 2)" -le $(($(early 2) + 10 * record + 4096)) ] || { echo "memory grew"; failed=1; }
same "threads" "$(early 3)" "$(late 3)" 0
# a file of results may be open in one sample and not in another
same "open files" "$(($(early 4) + 1))" "$(late 4)" 0
same "temporary files" "$before" "$(files)" 0
exit "$failed"
