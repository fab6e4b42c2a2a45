#!/usr/bin/env bash
# Shows that disabled counters cost nothing: instruction counts (valgrind's callgrind, exact) of the
# timed path with the counter calls present and with the calls deleted from the source. Fails when
# they differ by more than 0.5%.
# usage: scripts/counter-overhead.sh [STRUCTURE...]
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "counter-overhead: valgrind is needed" >&2; exit 1; }
structures=("$@")
[ ${#structures[@]} -gt 0 ] || structures=(uniform-grid obvhs-bvh2 obvhs-cwbvh)
dir=${CARGO_TARGET_DIR:-target}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo build -q --release -p renderer --example timed_pass
cp "$dir/release/examples/timed_pass" "$work/present"
cargo build -q --release -p renderer --example timed_pass --features delete-counter-calls
cp "$dir/release/examples/timed_pass" "$work/deleted"
count() { # BINARY STRUCTURE -> instructions within timed_pass
    valgrind --tool=callgrind --callgrind-out-file="$work/out" \
        --collect-atstart=no --toggle-collect='*timed_pass::timed_pass*' "$1" "$2" >"$work/log" 2>&1
    awk '/^(summary|totals):/ {print $2; exit}' "$work/out"
}
status=0
printf '%-16s %15s %15s %9s\n' structure present deleted ratio
for s in "${structures[@]}"; do
    a=$(count "$work/present" "$s")
    b=$(count "$work/deleted" "$s")
    [ "$a" -gt 0 ] && [ "$b" -gt 0 ] || { echo "counter-overhead: nothing was counted for $s" >&2; exit 1; }
    awk -v s="$s" -v a="$a" -v b="$b" 'BEGIN {
        r = a / b; printf "%-16s %15d %15d %9.5f\n", s, a, b, r; exit (r > 1.005 || r < 0.995) }' || status=1
done
exit $status
