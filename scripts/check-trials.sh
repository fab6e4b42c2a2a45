#!/usr/bin/env bash
# Does `rtbench check` find what it should, and nothing else? With a structure that is slowed down
# on purpose (crates/rtbench/examples/planted_slowdown.rs), three rows of a scene, repeated TRIALS times each:
#   one      a planted 1% of instructions, by the instruction stage, against a baseline
#   same     nothing planted, against a baseline: false alarms
#   against  nothing planted, in turns with the same program: false alarms
#   five     a planted 5% of time, in turns (--against)
#   ten      a planted 10% of time, in turns
# Of 20 trials these may fail: none of `one`, one of `same` and `against`, eight of `five`, two of `ten`. Says how long
# a check took at the most.
# usage: scripts/check-trials.sh [TRIALS] [SCENE]    (20, teapot: about half an hour for ONLY="against five ten")
# ONLY="one same against five ten" makes some of them; BUSY=1 runs a compile job beside all checks;
# PROFILE=dev builds without full optimisation; BINARY=FILE builds nothing and takes that example;
# KEEP=DIR keeps each check's CSV file there; CHECK="--rounds 9" are more options of `check --against`.
set -euo pipefail
cd "$(dirname "$0")/.."
trials=${1:-20}
scene=${2:-teapot}
only=" ${ONLY:-one same against five ten} "
wants() { # NAME -> whether it is among those to make
    case $only in *" $1 "*) ;; *) return 1 ;; esac
}
if wants one; then
    command -v valgrind > /dev/null || { echo "check-trials: valgrind is needed for 'one'" >&2; exit 77; }
fi
profile=${PROFILE:-release}
case $profile in release) flags=(--release); folder=release ;; *) flags=(--profile "$profile"); folder=debug ;; esac
work=$(mktemp -d)
busy=
ended() {
    [ -z "$busy" ] || { kill "$busy" && wait "$busy"; } 2> "$work/kill.log" || true
    rm -rf "$work"
}
trap ended EXIT
keep=${KEEP:-$work/kept}
mkdir -p "$keep"
new=$work/new
if [ -z "${BINARY:-}" ]; then
    cargo build -q "${flags[@]}" -p rtbench --features planted-slowdown --example planted_slowdown
    BINARY=${CARGO_TARGET_DIR:-target}/$folder/examples/planted_slowdown
fi
cp "$BINARY" "$new"
# the same program, with nothing planted whatever the environment says
old=$work/old
printf '#!/bin/sh\nPLANTED_LOOPS=0 exec "%s" "$@"\n' "$new" > "$old"
chmod +x "$old"
export RTBENCH_BASELINES=$work/baselines PLANTED_LOOPS=0
rows=slowed-grid,obvhs-cwbvh,obvhs-bvh2
read -ra more <<< "${CHECK:-}"

# how many turns of the loop are 1% of the instructions, and 5% and 10% of the time
turns=1000
instructions() { # TURNS -> instructions of all traversals
    PLANTED_LOOPS=$1 "$new" -q baseline save --overwrite calibration "$scene" --quick --rounds 3 \
        -s slowed-grid --instructions
    "$new" baseline show calibration | awk '/^Instructions/ {on = 1}
        on && /slowed-grid/ {print $NF; exit}'
}
seconds() { # TURNS -> the least trace times of all kinds of rays together: what no load adds to
    PLANTED_LOOPS=$1 "$new" -q run "$scene" --quick --rounds 60 -s slowed-grid \
        --overwrite -o "$work/time" > "$work/time.txt"
    awk '/"samples": \[/ {on = 1} /"summary": \[/ {on = 0}
        on && /"(primary|shadow|reflected|refracted|diffuse)":/ {
            sub(",", "", $2); if (!($1 in least) || $2 + 0 < least[$1]) least[$1] = $2 + 0 }
        END {for (kind in least) sum += least[kind]; print sum}' "$work/time/results.json"
}
turns_for() { # SHARE BEFORE WITH_TURNS -> turns
    awk -v share="$1" -v a="$2" -v b="$3" -v n="$turns" 'BEGIN {
        print int(share * a / ((b - a) / n) + 0.999) }'
}
declare -A planted=([same]=0 [against]=0)
if wants one; then planted[one]=$(turns_for 0.01 "$(instructions 0)" "$(instructions $turns)"); fi
if wants five || wants ten; then
    before=$(seconds 0) with=$(seconds $turns)
    planted[five]=$(turns_for 0.05 "$before" "$with")
    planted[ten]=$(turns_for 0.10 "$before" "$with")
fi
echo "turns of the planted loop per traversal of slowed-grid on $scene:" \
    "${planted[one]:-} (1% of instructions) ${planted[five]:-} (5% of time) ${planted[ten]:-} (10%)"

if [ -n "${BUSY:-}" ]; then
    command -v c++ > /dev/null || { echo "check-trials: a compiler c++ is needed for BUSY" >&2; exit 77; }
    (job=
    trap '[ -z "$job" ] || kill "$job"; exit' TERM
    while :; do
        c++ -std=c++17 -O2 -fPIC -c -I crates/plugins/include -o "$work/busy.o" peers/minimal-cpp/minimal.cpp &
        job=$!
        wait "$job" && echo >> "$work/compiled"
        job=
    done) &
    busy=$!
fi

longest=0
check() { # NAME NUMBER ARGUMENTS... -> the CSV file at $csv
    csv=$keep/$1-$2/check.csv
    local code=0 begin=$SECONDS
    PLANTED_LOOPS=${planted[$1]} "$new" -q check "${@:3}" --overwrite -o "${csv%/*}" > "$work/out" || code=$?
    case $code in 0 | 3) ;; *) cat "$work/out" >&2; echo "check-trials: exit $code" >&2; exit 1 ;; esac
    [ $((SECONDS - begin)) -le "$longest" ] || longest=$((SECONDS - begin))
}
# stage, scene, row, what, ..., outcome, note
regressions() { # AWK_CONDITION -> lines of the CSV file that are regressions and meet it
    awk -F, "\$11 == \"regression\" && ($1)" "$csv" | wc -l
}
slowed='$3 == "slowed-grid" && $4 == "trace"'

if wants one || wants same; then
    "$new" -q baseline save main "$scene" --quick -s "$rows" --instructions
fi
declare -A found=([one]=0 [same]=0 [against]=0 [five]=0 [ten]=0)
elsewhere=0
start=$SECONDS
for i in $(seq "$trials"); do
    for name in one same against five ten; do
        wants "$name" || continue
        case $name in
        one) check "$name" "$i" --baseline main -s slowed-grid ;;
        same) check "$name" "$i" --baseline main ;;
        *) check "$name" "$i" --against "$old" "$scene" --quick -s "$rows" ${more[@]+"${more[@]}"} ;;
        esac
        case $name in
        same | against) [ "$(regressions 1)" -eq 0 ] || found[$name]=$((found[$name] + 1)) ;;
        one) [ "$(regressions "\$1 == \"instructions\" && $slowed")" -eq 0 ] || found[one]=$((found[one] + 1)) ;;
        *)
            [ "$(regressions "\$1 == \"times\" && $slowed")" -eq 0 ] || found[$name]=$((found[$name] + 1))
            elsewhere=$((elsewhere + $(regressions "!($slowed)")))
            ;;
        esac
    done
    echo "trial $i, $((SECONDS - start)) s: one ${found[one]}, five ${found[five]}, ten ${found[ten]};" \
        "false alarms: same ${found[same]}, against ${found[against]}, other rows $elsewhere;" \
        "load $(cut -d' ' -f1 /proc/loadavg)" >&2
done
status=0
said() { # NAME TEXT SUCCESS
    wants "$1" || return 0
    echo "$2: ${found[$1]} of $trials"
    [ "$3" -eq 1 ] || status=1
}
said one "planted 1% of instructions, found by the instruction stage" $((found[one] == trials))
said same "nothing planted, false alarms against a baseline" $((found[same] * 20 <= trials))
said against "nothing planted, false alarms in turns with the same program" $((found[against] * 20 <= trials))
said five "planted 5% of time, found in turns" $((found[five] * 20 >= trials * 12))
said ten "planted 10% of time, found in turns" $((found[ten] * 20 >= trials * 18))
echo "false alarms in rows in which nothing was planted: $elsewhere"
echo "$((SECONDS - start)) s in all, $longest s the longest check"
if [ -n "$busy" ]; then
    compiled=$(wc -l 2> "$work/compiled.log" < "$work/compiled" || echo 0)
    echo "$compiled compilations beside it"
    [ "$compiled" -gt 0 ] || status=1
fi
[ "$longest" -le 180 ] || status=1
exit $status
