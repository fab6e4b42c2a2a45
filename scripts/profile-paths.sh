#!/usr/bin/env bash
# What the time of the three fastest rows is spent on: measures scenes as the set `speed` does, in small
# images, simulates the caches under the fastest rows, times loads that wait for one another, and
# writes all of it in Markdown. docs/profile.md says how to read it.
# usage: scripts/profile-paths.sh OUT.md [SCENE...]
# environment: RTBENCH (a built rtbench), ROUNDS (5), SIZE (512), RAYS (16k)
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "profile-paths: valgrind is needed" >&2; exit 1; }
[ $# -ge 1 ] || { echo "usage: scripts/profile-paths.sh OUT.md [SCENE...]" >&2; exit 2; }
out=$1
shift
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(kitchen gears8-tess)
if [ -z "${RTBENCH:-}" ]; then
    cargo build --release -q
    RTBENCH=${CARGO_TARGET_DIR:-target}/release/rtbench
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run=(run "${scenes[@]}" --as speed --size "${SIZE:-512}" --rounds "${ROUNDS:-5}")
profile=(profile --rays "${RAYS:-16k}")
"$RTBENCH" -q "${run[@]}" -o "$work/run" >/dev/null
"$RTBENCH" -q "${profile[@]}" "$work/run" --export-markdown "$work/profile.md" >/dev/null
{
    echo "# What a ray takes: a recorded profile"
    echo
    echo "    rtbench ${run[*]} -o DIR"
    echo "    rtbench ${profile[*]} DIR"
    echo
    grep -E '^- (machine|compiler|rtbench|warning)' "$work/run/results.md"
    echo
    cat "$work/profile.md"
    echo "## Loads that wait for one another"
    echo
    "$RTBENCH" -q doctor --memory | sed -n '/^loads that wait/,$s/^/    /p'
} >"$out"
