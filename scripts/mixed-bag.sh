#!/usr/bin/env bash
# Loads a mixed bag of real files: Debian's assimp-testmodels and openfoam-examples, the WebXR
# controllers on npm, kitchen and sponza. Fetches the packages into a folder (default
# target/mixed-bag), which only this needs. Prints one line per file: loads, or why it is refused.
# Arguments: [FOLDER [PROGRAM]]. Needs apt-get, dpkg-deb and npm.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-target/mixed-bag}
program=$(realpath "${2:-target/release/rtbench}")
mkdir -p "$folder"
cd "$folder"
for package in assimp-testmodels openfoam-examples; do
    [ -d "$package" ] && continue
    apt-get download "$package" >&2
    dpkg-deb -x "$package"_*.deb "$package"
done
if [ ! -d webxr ]; then
    npm pack --silent @webxr-input-profiles/assets@1.0.20 >&2
    mkdir webxr
    tar xzf webxr-input-profiles-assets-*.tgz -C webxr
fi
"$program" scenes fetch kitchen sponza >&2
check() {
    local answer code=0
    answer=$(timeout 60 "$program" -q scenes validate "$1" 2>&1) || code=$?
    case $code in
        0) echo "loads    $1$(grep -c '^  ' <<< "$answer" | sed 's/^0$//; s/^\(..*\)/ (\1 warnings)/')" ;;
        1) echo "refused  $1: $(tr '\n' ' ' <<< "$answer" | cut -c1-300)" ;;
        *) echo "BROKEN   $1: exit code $code: $answer" ;;
    esac
}
check kitchen
check sponza
find . -type f \( -iname '*.obj' -o -iname '*.obj.gz' -o -iname '*.gltf' -o -iname '*.glb' \
    -o -iname '*.nff' -o -iname '*.nff.gz' \) | sort | while IFS= read -r file; do check "$file"; done
