#!/usr/bin/env bash
# Builds the plugins in peers/ (folders with a Makefile) whose sources and libraries are there, and says what the others lack.
# usage: scripts/peers.sh [NAME...]: all where none is named. Fails where one that has all it needs does not
# compile. CXX, CC, CXXFLAGS and CFLAGS are passed on.
set -uo pipefail
cd "$(dirname "$0")/../peers" || exit 1
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(*/Makefile)
failed=0
for name in "${names[@]}"; do
    name=${name%/Makefile}
    name=${name%/}
    if [ ! -f "$name/Makefile" ]; then
        echo "$name: there is no peers/$name/Makefile"
        failed=1
        continue
    fi
    case $name in
    embree)
        if ! echo '#include <embree3/rtcore.h>' | "${CXX:-c++}" -E -x c++ - >/dev/null 2>&1; then
            echo "$name: not built: Embree 3 is missing (Debian: apt-get install libembree-dev)"
            continue
        fi
        ;;
    esac
    if make -s -C "$name"; then
        echo "$name: peers/$name/$(cd "$name" && ls ./*.so | sed 's|^\./||' | head -n 1)"
    else
        echo "$name: does not compile"
        failed=1
    fi
done
exit $failed
