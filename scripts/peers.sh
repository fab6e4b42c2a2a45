#!/usr/bin/env bash
# Builds the plugins in peers/ (folders with a Makefile) whose sources and libraries are there, and says what the others lack.
# usage: scripts/peers.sh [NAME...]: all where none is named. Fails where one that has all it needs does not
# compile. TINYBVH, BVH_V2 and NANORT are folders with the sources of these; EMBREE4_LIBRARY and EMBREE3_LIBRARY
# are needed when those two run, if the system does not find them. CXX, CC, CXXFLAGS and CFLAGS are passed on.
# cargo fetches the crates that `rust` and `wgpu` need. On a machine with a GPU: peers/wgpu/README.md has the command
# of a run.
set -uo pipefail
# empty would compile without optimisation
[ -n "${CXXFLAGS:-}" ] || unset CXXFLAGS
[ -n "${CFLAGS:-}" ] || unset CFLAGS
for variable in TINYBVH BVH_V2 NANORT; do
    [ -z "${!variable:-}" ] || export "$variable=$(realpath "${!variable}")"
done
cd "$(dirname "$0")/../peers" || exit 1
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(*/Makefile)
failed=0

# needs VARIABLE FILE: the file is in the folder that the variable names
needs() {
    [ -n "${!1:-}" ] && [ -f "${!1}/$2" ] && return
    echo "$name: not built: set $1 to a folder with $2 (peers/$name/README.md)"
    return 1
}

# needs_crates: cargo is there, and has what Cargo.lock names or can fetch it
needs_crates() {
    if ! command -v cargo > /dev/null; then
        echo "$name: not built: cargo is missing"
        return 1
    fi
    (cd "$name" && cargo fetch --locked --quiet --target "$(rustc -vV | sed -n 's/^host: //p')") && return
    echo "$name: not built: cargo cannot get the crates of peers/$name/Cargo.lock (offline?)"
    return 1
}

for name in "${names[@]}"; do
    name=${name%/Makefile}
    name=${name%/}
    [ "$name" = common ] && continue
    if [ ! -f "$name/Makefile" ]; then
        echo "$name: there is no peers/$name/Makefile"
        failed=1
        continue
    fi
    case $name in
    tinybvh) needs TINYBVH tiny_bvh.h || continue ;;
    bvh-v2) needs BVH_V2 src/bvh/v2/bvh.h || continue ;;
    nanort) needs NANORT nanort.h || continue ;;
    rust | wgpu) needs_crates || continue ;;
    esac
    if make -s -C "$name"; then
        for library in "$name"/*.so; do echo "$name: peers/$library"; done
    else
        echo "$name: does not compile"
        failed=1
    fi
done
exit $failed
