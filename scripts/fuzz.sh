#!/usr/bin/env bash
# Fuzzes the readers of foreign files, and of settings: 10^7 executions a target unless a number is given, at most
# 1 GiB of memory. Arguments: [EXECUTIONS [TARGET...]]. Needs a nightly toolchain and cargo-fuzz.
# Seeds are in fuzz/seeds/TARGET; what is found is left in fuzz/artifacts/TARGET: put it beside the
# seeds once it is fixed, and the tests replay it.
set -euo pipefail
cd "$(dirname "$0")/.."
executions=${1:-10000000}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(obj mtl gltf moving_gltf moving_aff nff ply stl triangle_soup pbrt tray_racing packed polygon scene_file effects results records beside settings)
export CARGO_BUILD_JOBS=${CARGO_BUILD_JOBS:-2}
# The code is safe Rust: no address sanitizer, which would hide the memory that is really used.
for target in "${targets[@]}"; do
    mkdir -p "fuzz/corpus/$target" "fuzz/artifacts/$target"
    # these compare so much that tracing it takes most of the time
    case $target in
    settings | beside | polygon) traces=(--no-trace-compares) ;;
    *) traces=() ;;
    esac
    # the readers of scenes need nothing of the program
    case $target in
    settings | beside | results | records | effects) features=() ;;
    *) features=(--no-default-features) ;;
    esac
    cargo +nightly fuzz build --sanitizer none "${features[@]}" "${traces[@]}" "$target" >&2
    host=$(rustc -vV | sed -n 's/^host: //p')
    "fuzz/target/$host/release/$target" "fuzz/corpus/$target" "fuzz/seeds/$target" \
        -runs="$executions" -max_len=16384 -timeout=10 -rss_limit_mb=1024 -print_final_stats=1 \
        -artifact_prefix="fuzz/artifacts/$target/" -verbosity=0 2>&1 | tail -12 | sed "s/^/$target: /"
done
