#!/usr/bin/env bash
# Shows that effects which a scene does not call for cost nothing: instruction counts (valgrind's
# callgrind, exact) of an image with all effects in the program and with the sampled ones deleted
# from the source, and the bits of both images. Fails when the counts differ by more than 2% or the
# images at all. Then plants a fault - plain images through the sampled stages at one sample - which
# must be found out.
# usage: scripts/effect-gating.sh [SCENE...]
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "effect-gating: valgrind is needed" >&2; exit 1; }
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(effect-plain effect-hard-shadows effect-mirror effect-refraction effect-smooth-normals)
profile=${PROFILE:-release}
case $profile in release) flags=(--release) ;; *) flags=() ;; esac
dir=${CARGO_TARGET_DIR:-target}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build() { # NAME FEATURES...
    cargo build -q "${flags[@]}" -p renderer --example one_image "${@:2}"
    cp "$dir/$profile/examples/one_image" "$work/$1"
}
build deleted --features delete-effects
build planted --features plant-effect-cost
build present
# thread scheduling takes instructions, too: one thread
export RAYON_NUM_THREADS=1
count() { # BINARY SCENE -> instructions, hash of the image
    valgrind --tool=callgrind --callgrind-out-file="$work/out" "$work/$1" "$2" >"$work/image" 2>"$work/log"
    echo "$(awk '/^(summary|totals):/ {print $2; exit}' "$work/out") $(cut -d' ' -f1 "$work/image")"
}
verdict() { # NAME COUNT COUNT_DELETED same|OTHER -> 0 when both are as good as equal
    awk -v s="$1" -v a="$2" -v b="$3" -v same="$4" 'BEGIN {
        r = a / b; printf "%-32s %13d %13d %8.5f  %s image\n", s, a, b, r, same
        exit (r > 1.02 || r < 0.98 || same != "same") }'
}
judge() { # SCENE BINARY -> 0 when it is as the one with the effects deleted
    local a b
    read -r a ha < <(count "$2" "$1")
    read -r b hb < <(count deleted "$1")
    [ "$a" -gt 0 ] && [ "$b" -gt 0 ] || { echo "effect-gating: nothing was counted for $1" >&2; exit 1; }
    verdict "$1 $2" "$a" "$b" "$([ "$ha" = "$hb" ] && echo same || echo OTHER)"
}
status=0
printf '%-32s %13s %13s %8s\n' 'scene program' instructions deleted ratio
for s in "${scenes[@]}"; do judge "$s" present || status=1; done
echo "planted faults:"
if judge "${scenes[0]}" planted || verdict "3% more" 1030 1000 same || verdict "other bits" 1000 1000 OTHER; then
    echo "effect-gating: a planted fault was not found" >&2
    status=1
fi
exit $status
