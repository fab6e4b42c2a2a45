#!/usr/bin/env bash
# Draws the slices and heat maps of README.md and docs/ anew, into docs/pictures/ (or the folder given). Fails when
# one is larger than 300 KiB. No time of this machine is in them: of heat maps only tests are kept. The drawings of
# concepts (storages, cwbvh, padding, light-buffer, no-hit-is-lost, history) are made by hand; terminal.svg has the
# text of one quick run, report.png the head of its report.
# usage: [RTBENCH=target/release/rtbench] scripts/pictures.sh [DIR]
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-docs/pictures}
if [ -z "${RTBENCH:-}" ]; then
    cargo build -q --release -p rtbench
    RTBENCH=${CARGO_TARGET_DIR:-target}/release/rtbench
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"
show() { # NAME SCENE OPTIONS...
    "$RTBENCH" show "$2" "${@:3}" -o "$work/$1" > /dev/null
    mv "$work/$1" "$out/$1"
}
# a slice of four structures through the same scene, small enough that every cell is seen
show four-structures.svg teapot:5 -s uniform-grid,octree,kd-tree,wide-bvh --size 300
# each family of structures
show grids.svg teapot:5 -s uniform-grid,proximity-clouds:density=2,irregular-grid --size 260
show grids-within-grids.svg teapot:5 -s recursive-grid,hug,two-level-grid,adaptive-grid --size 260
show trees.svg teapot:5 -s octree,octree:subdivision=adaptive,kd-tree --size 260
show volumes.svg teapot:5 -s bounding-volumes:volume=slabs:group=16,kay-kajiya,obvhs-bvh2 --size 260
show levels.svg teapot:5 -s wide-bvh --depth 2 --project --size 420
# one ray's way
show ray.svg teapot:5 -s uniform-grid,kd-tree,obvhs-bvh2 --ray 230,235 --size 300
# the teapot in the stadium, which is a hare here
show hare.svg stadium:24 -s uniform-grid,recursive-grid,wide-bvh --slice z=0 --window -0.25,-0.05,-0.25:0.25,0.45,0.25 --size 300
"$RTBENCH" cost stadium:24 -s uniform-grid,wide-bvh --size 128 --heat-maps "$work/maps" > /dev/null
mv "$work/maps/tests.svg" "$out/stadium-tests.svg"
for picture in "$out"/*; do
    bytes=$(wc -c < "$picture")
    echo "$picture $bytes"
    [ "$bytes" -le $((300 * 1024)) ] || { echo "pictures: $picture is larger than 300 KiB" >&2; exit 1; }
done
