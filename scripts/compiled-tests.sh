#!/usr/bin/env bash
# Shows that with the feature compiled-tests a test that is chosen by name is compiled as the default
# is: instruction counts (valgrind's callgrind, exact) of the timed path with nothing chosen and with
# the default chosen by name, triangles one by one, in blocks of eight, and spheres. Fails when they
# differ by more than 1%. Then plants a fault - the same choice without the feature, where tests are
# called - which must be found out.
# usage: scripts/compiled-tests.sh [STRUCTURE[:SETTING=VALUE]...]
# PROFILE=dev builds sooner; CARGO_FLAGS are given to cargo.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "compiled-tests: valgrind is needed" >&2; exit 1; }
rows=("$@")
[ ${#rows[@]} -gt 0 ] || rows=(obvhs-bvh2:kernel=scalar obvhs-bvh2 obvhs-cwbvh:kernel=scalar obvhs-cwbvh
    uniform-grid uniform-grid:kernel=block kd-tree kd-tree:kernel=block wide-bvh irregular-grid)
profile=${PROFILE:-release}
read -ra flags <<<"${CARGO_FLAGS:-}"
[ "$profile" = release ] && flags+=(--release)
dir=${CARGO_TARGET_DIR:-target}/$profile
[ "$profile" = dev ] && dir=${CARGO_TARGET_DIR:-target}/debug
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo build -q "${flags[@]}" -p renderer --example timed_pass
cp "$dir/examples/timed_pass" "$work/called"
cargo build -q "${flags[@]}" -p renderer --example timed_pass --features compiled-tests
cp "$dir/examples/timed_pass" "$work/compiled"
count() { # BINARY ROW SCENE -> instructions within timed_pass
    valgrind --tool=callgrind --callgrind-out-file="$work/out" \
        --collect-atstart=no --toggle-collect='*timed_pass::timed_pass*' "$work/$1" "$2" "$3" >"$work/log" 2>&1
    awk '/^(summary|totals):/ {print $2; exit}' "$work/out"
}
judge() { # BINARY ROW SCENE CHOICE -> 0 when the choice takes what nothing chosen takes
    local a b
    a=$(count "$1" "$2:$4" "$3")
    b=$(count "$1" "$2" "$3")
    [ "$a" -gt 0 ] && [ "$b" -gt 0 ] || { echo "compiled-tests: nothing was counted for $2" >&2; exit 1; }
    awk -v what="$1 $2:$4" -v a="$a" -v b="$b" 'BEGIN {
        r = a / b; printf "%-68s %13.0f %13.0f %8.5f\n", what, a, b, r; exit (r > 1.01 || r < 0.99) }'
}
status=0
printf '%-68s %13s %13s %8s\n' "built, row" "by name" default ratio
for row in "${rows[@]}"; do
    judge compiled "$row" tetra:5 triangle-test=watertight || status=1
    judge compiled "$row" balls:3 sphere-test=rearranged || status=1
done
for choice in "tetra:5 triangle-test=watertight" "balls:3 sphere-test=rearranged"; do
    read -r scene setting <<<"$choice"
    if judge called "${rows[0]}" "$scene" "$setting"; then
        echo "compiled-tests: the planted fault, a test that is called, was not found" >&2
        status=1
    fi
done
[ $status = 0 ] && echo "compiled-tests: ok" || echo "compiled-tests: FAILED" >&2
exit $status
