#!/usr/bin/env bash
# Does `rtbench check` find what it should, and nothing else? With a structure that is slowed down
# on purpose (crates/rtbench/examples/planted_slowdown.rs), repeated TRIALS times each:
#   * a planted 3% of instructions, by the instruction stage;
#   * nothing planted, against a baseline and against a copy of the same binary: false alarms;
#   * a planted 10% of time, by turns of processes (--against).
# Fails when a 3% is missed, a false alarm is raised, or more than two 10% of 20 are missed.
# usage: scripts/check-trials.sh [TRIALS] [SCENE...]
# PROFILE=dev builds without full optimisation; BINARY=FILE builds nothing and takes that example;
# KEEP=DIR keeps each check's CSV file there; ONLY="three same against ten" makes some of them.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "check-trials: valgrind is needed" >&2; exit 1; }
trials=${1:-20}
shift || true
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(teapot balls)
first=${scenes[0]}
profile=${PROFILE:-release}
case $profile in release) flags=(--release); folder=release ;; *) flags=(--profile "$profile"); folder=debug ;; esac
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
keep=${KEEP:-$work/kept}
mkdir -p "$keep"
only=" ${ONLY:-three same against ten} "
new=$work/new
if [ -z "${BINARY:-}" ]; then
    cargo build -q "${flags[@]}" -p rtbench --features planted-slowdown --example planted_slowdown
    BINARY=${CARGO_TARGET_DIR:-target}/$folder/examples/planted_slowdown
fi
cp "$BINARY" "$new"
# the same program, with nothing planted whatever the environment says
old=$work/old
printf '#!/bin/sh\nPLANTED_LOOPS=0 exec "%s" "$@"\n' "$new" >"$old"
chmod +x "$old"
export RTBENCH_BASELINES=$work/baselines PLANTED_LOOPS=0
rows=(-s slowed-grid,obvhs-cwbvh,obvhs-bvh2)
pair=(-s slowed-grid,obvhs-cwbvh)

# how many turns of the loop are 3% of the instructions, and 10% of the time, on the first scene
turns=1000
instructions() { # TURNS -> instructions of all traversals
    PLANTED_LOOPS=$1 "$new" -q baseline save --force calibration "$first" --quick --rounds 3 \
        -s slowed-grid --instructions
    "$new" baseline show calibration | awk '/^Instructions/ {on = 1}
        on && /slowed-grid/ {print $NF; exit}'
}
seconds() { # TURNS -> the least trace times of all kinds of rays together: what no load adds to
    PLANTED_LOOPS=$1 "$new" -q run "$first" --quick --rounds 60 -s slowed-grid \
        --overwrite --export-json "$work/time.json" >/dev/null
    awk '/"samples": \[/ {on = 1} /"summary": \[/ {on = 0}
        on && /"(primary|shadow|reflected|refracted|diffuse)":/ {
            sub(",", "", $2); if (!($1 in least) || $2 + 0 < least[$1]) least[$1] = $2 + 0 }
        END {for (kind in least) sum += least[kind]; print sum}' "$work/time.json"
}
turns_for() { # SHARE BEFORE WITH_TURNS -> turns
    awk -v share="$1" -v a="$2" -v b="$3" -v n="$turns" 'BEGIN {
        print int(share * a / ((b - a) / n) + 0.999) }'
}
three=$(turns_for 0.03 "$(instructions 0)" "$(instructions $turns)")
ten=$(turns_for 0.10 "$(seconds 0)" "$(seconds $turns)")
echo "planted in slowed-grid on $first: $three turns per traversal for 3% of instructions, $ten for 10% of time"

check() { # NAME TURNS ARGUMENTS... -> code; the CSV file at $csv
    csv=$keep/$1.csv
    local code=0
    PLANTED_LOOPS=$2 "$new" -q check "${@:3}" --overwrite --export-csv "$csv" >"$work/out" || code=$?
    case $code in 0 | 3) ;; *) cat "$work/out" >&2; echo "check-trials: exit $code" >&2; exit 1 ;; esac
    return 0
}
# stage, scene, row, what, ..., outcome, note
regressions() { # AWK_CONDITION -> lines of the CSV file that are regressions and meet it
    awk -F, "\$11 == \"regression\" && ($1)" "$csv" | wc -l
}
wants() { # NAME -> whether it is among those to make
    case $only in *" $1 "*) ;; *) return 1 ;; esac
}
planted='$3 == "slowed-grid" && $4 == "trace"'

"$new" -q baseline save main "${scenes[@]}" --quick "${rows[@]}" --instructions
found3=0 found10=0 alarms=0 alarms_against=0 elsewhere=0
start=$SECONDS
for i in $(seq "$trials"); do
    if wants three; then
        check "three-$i" "$three" --baseline main "$first"
        [ "$(regressions "\$1 == \"instructions\" && $planted")" -gt 0 ] && found3=$((found3 + 1))
        elsewhere=$((elsewhere + $(regressions "!($planted)")))
    fi
    if wants same; then
        check "same-$i" 0 --baseline main
        [ "$(regressions 1)" -eq 0 ] || alarms=$((alarms + 1))
    fi
    if wants against; then
        check "against-$i" 0 --against "$old" "$first" --quick "${pair[@]}"
        [ "$(regressions 1)" -eq 0 ] || alarms_against=$((alarms_against + 1))
    fi
    if wants ten; then
        check "ten-$i" "$ten" --against "$old" "$first" --quick "${pair[@]}"
        [ "$(regressions "\$1 == \"times\" && $planted")" -gt 0 ] && found10=$((found10 + 1))
        elsewhere=$((elsewhere + $(regressions "!($planted)")))
    fi
    echo "trial $i: 3% found $found3, 10% found $found10; false alarms $alarms (baseline)," \
        "$alarms_against (binary), $elsewhere (other rows); load $(cut -d' ' -f1 /proc/loadavg)" >&2
done
status=0
said() { # NAME TEXT SUCCESS
    wants "$1" || return 0
    echo "$2"
    [ "$3" -eq 1 ] || status=1
}
said three "planted 3% of instructions, found by the instruction stage: $found3 of $trials" $((found3 == trials))
said same "nothing planted, false alarms against a baseline: $alarms of $trials" $((alarms == 0))
said against "nothing planted, false alarms against the same binary: $alarms_against of $trials" $((alarms_against == 0))
said ten "planted 10% of time, found by turns of processes: $found10 of $trials" $((found10 * 20 >= trials * 18))
echo "false alarms in rows and stages in which nothing was planted: $elsewhere"
[ "$elsewhere" -eq 0 ] || status=1
echo "$((SECONDS - start)) s in all"
exit $status
