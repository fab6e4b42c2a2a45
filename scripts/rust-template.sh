#!/usr/bin/env bash
# Copies peers/rust-template elsewhere, as somebody with a structure of their own would, and sees that it
# builds, that its tests pass, that its row stands beside ours with right answers, and that mistakes planted
# in it are found.
# usage: scripts/rust-template.sh [cargo's options, --release say]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
cp -r "$root/peers/rust-template/." "$copy"
cd "$copy"
sed -i "s|\.\./\.\./crates|$root/crates|; /^# Tests trace/,\$d" Cargo.toml
# the versions, profiles and folder of the workspace: what is built there serves here, too
cp "$root/Cargo.lock" .
sed -n '/^\[profile\./,$p' "$root/Cargo.toml" >> Cargo.toml
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}
program=(cargo run --quiet "$@" --)
measured=(run tetra --quick --rounds 1 --quiet -s "median-bvh:leaf=8,wide-bvh")

# ends with exit code $1, not with another
ends_with() {
    local expected=$1 code=0
    shift
    "$@" >said.txt 2>&1 || code=$?
    if [ "$code" != "$expected" ]; then
        echo "rust-template: exit code $code, expected $expected: $*"
        cat said.txt
        exit 1
    fi
}

cargo test --quiet "$@"
ends_with 0 "${program[@]}" "${measured[@]}"
grep -q '^median-bvh leaf=8 .* ok *$' said.txt || { cat said.txt; exit 1; }
ends_with 0 "${program[@]}" verify --rays 500 -s median-bvh
# a hit is lost: the far child is not visited
sed -i 's/left += 2;/left += 1;/' src/median_bvh.rs
ends_with 4 "${program[@]}" "${measured[@]}"
# a name that is taken, and a default that is out of range
cp "$root/peers/rust-template/src/median_bvh.rs" src
sed -i 's/new("median-bvh"/new("kd-tree"/' src/median_bvh.rs
ends_with 1 "${program[@]}" list structures
grep -q "two structures have the name 'kd-tree'" said.txt
cp "$root/peers/rust-template/src/median_bvh.rs" src
sed -i 's/"leaf", "4"/"leaf", "0"/' src/median_bvh.rs
ends_with 1 "${program[@]}" list structures
grep -q "median-bvh.leaf = '0': expected a whole number from 1 to 64" said.txt
echo "rust-template: builds, is right, and its planted mistakes are found"
