#!/usr/bin/env bash
# Builds rtbench for a target and an instruction set, tries it, and packs it with its licences and manual pages:
# OUT/rtbench-NAME.tar.gz (.zip for Windows) and a .sha256 beside it. NAME is what docs/running.md lists.
# usage: scripts/package.sh TARGET LEVEL NAME OUT, as in
#        scripts/package.sh x86_64-unknown-linux-gnu x86-64-v3 linux-x86-64-v3 dist
# LEVEL is what rustc's target-cpu takes, or `default`. BINARY=FILE packs that file and builds none.
set -euo pipefail
target=$1 level=$2 name=rtbench-$3
mkdir -p "$4"
out=$(cd "$4" && pwd)
cd "$(dirname "$0")/.."
program=rtbench
case $target in *windows*) program=rtbench.exe ;; esac
if [ -z "${BINARY:-}" ]; then
    # replaces the flags of .cargo/config.toml
    [ "$level" = default ] || export RUSTFLAGS="-C target-cpu=$level"
    cargo build --release --locked --target "$target" -p rtbench
    BINARY=${CARGO_TARGET_DIR:-target}/$target/release/$program
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/$name"
cp "$BINARY" "$work/$name/$program"
cp LICENSE-APACHE LICENSE-MIT CHANGELOG.md "$work/$name"
# what is published has run: exit code 4 if an answer is wrong
"$work/$name/$program" run tetra:3 --quick --quiet -s kd-tree,wide-bvh,obvhs-cwbvh > "$work/tried.txt"
grep -q '^wide-bvh .* ok' "$work/tried.txt" || { cat "$work/tried.txt" >&2; exit 1; }
"$work/$name/$program" man -o "$work/$name/man"
case $target in
*windows*) archive=$name.zip && (cd "$work" && 7z a -bso0 "$out/$archive" "$name") ;;
*) archive=$name.tar.gz && tar -C "$work" -czf "$out/$archive" "$name" ;;
esac
cd "$out"
if command -v sha256sum > /dev/null; then sha256sum "$archive"; else shasum -a 256 "$archive"; fi > "$archive.sha256"
cat "$archive.sha256"
