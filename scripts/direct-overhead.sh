#!/usr/bin/env bash
# Shows that `adapter=direct` is obvhs as its authors use it: rays per second of the rows over those of
# a program that uses obvhs without us (crates/renderer/examples/plain_obvhs.rs), on the same rays, in
# interleaved rounds of seeded random order; medians, quartiles and fastest passes. Fails when the median
# over all scenes of a kind of ray and a row lies below 0.97.
# usage: scripts/direct-overhead.sh [SCENE...]
# SIZE=256 ROUNDS=15 SEED=1: pixels a side, rounds, order. ROWS: other rows beside them, not judged.
set -euo pipefail
cd "$(dirname "$0")/.."
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(kitchen hare stadium gears8-tess tree-tess balls-tess)
read -ra others <<<"${ROWS:-}"
cargo build -q --release -p renderer --example plain_obvhs
plain=${CARGO_TARGET_DIR:-target}/release/examples/plain_obvhs
lines=$(mktemp)
trap 'rm -f "$lines"' EXIT
for scene in "${scenes[@]}"; do
    "$plain" "$scene" --size "${SIZE:-256}" --rounds "${ROUNDS:-15}" --seed "${SEED:-1}" \
        obvhs-cwbvh:adapter=direct obvhs-bvh2:adapter=direct "${others[@]}" | tee -a "$lines"
done
# SCENE KIND ROW RATE Mrays/s RATIO [LOW, HIGH] fastest RATIO
sort -k2b,2 -k3b,3 -k6,6g "$lines" | awk '
    function show(  middle) {
        if (!n) return
        middle = n % 2 ? of[(n + 1) / 2] : (of[n / 2] + of[n / 2 + 1]) / 2
        printf "%-12s %-8s %-36s %.3f [%.3f, %.3f] over %d scene(s)\n", "all", kind, row, middle, of[1], of[n], n
        if (row ~ /adapter=direct$/ && middle < 0.97) bad = 1
    }
    $2 != kind || $3 != row { show(); n = 0; kind = $2; row = $3 }
    { of[++n] = $6 }
    END { show(); exit bad }'
