#!/usr/bin/env bash
# The steps of action.yml; its inputs are environment variables. scripts/action-try.sh tries them.
# usage: scripts/action.sh install|measure|comment
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
home=${RUNNER_TEMP:?}/rtbench

# what the processor has, as archives are named
detected() {
    case $(uname -sm) in
    "Linux x86_64") has_v3 < /proc/cpuinfo && echo linux-x86-64-v3 || echo linux-x86-64 ;;
    "Linux aarch64") echo linux-aarch64 ;;
    "Darwin arm64") echo macos-aarch64 ;;
    # the last Macs without AVX2 cannot run what is hosted
    "Darwin x86_64") echo macos-x86-64-v3 ;;
    *) echo "::error::there is no binary for $(uname -sm): use 'version: source'" >&2 && return 1 ;;
    esac
}

has_v3() {
    local flags feature
    flags=$(grep -m 1 '^flags')
    for feature in avx avx2 bmi1 bmi2 f16c fma abm movbe; do
        [[ " $flags " == *" $feature "* ]] || return 1
    done
}

install() {
    mkdir -p "$home/bin"
    if [ "${VERSION:-source}" = source ]; then
        # the flags for the processor are those of .cargo/config.toml
        (cd "$root" && cargo install --quiet --locked --path crates/rtbench --root "$home")
    else
        local target=${TARGET:-auto} name url
        [ "$target" != auto ] || target=$(detected)
        name=rtbench-$target
        url=${GITHUB_SERVER_URL:?}/${REPOSITORY:?}/releases/download/$VERSION/$name.tar.gz
        curl --fail --silent --show-error --location --retry 3 -o "$home/$name.tar.gz" "$url"
        curl --fail --silent --show-error --location --retry 3 -o "$home/$name.tar.gz.sha256" "$url.sha256"
        (cd "$home" && check_sum "$name.tar.gz.sha256")
        tar -C "$home" -xzf "$home/$name.tar.gz"
        mv "$home/$name/rtbench" "$home/bin/"
    fi
    "$home/bin/rtbench" --version
    echo "$home/bin" >> "${GITHUB_PATH:?}"
}

check_sum() {
    if command -v sha256sum > /dev/null; then sha256sum --check "$1"; else shasum -a 256 --check "$1"; fi
}

measure() {
    local run check plugin=() results=$home/results code=0 judged=0 verdict=
    # blanks separate; nothing is expanded
    read -ra run <<< "${RUN:-}"
    read -ra check <<< "${CHECK:-}"
    [ -z "${PLUGIN:-}" ] || plugin=(--plugin "$PLUGIN")
    mkdir -p "$home"
    rm -rf "$results"
    rtbench doctor
    if [ ${#run[@]} -gt 0 ]; then
        rtbench run "${run[@]}" ${plugin[@]+"${plugin[@]}"} -o "$results" || code=$?
        [ ! -e "$results/results.md" ] || cat "$results/results.md" >> "${GITHUB_STEP_SUMMARY:?}"
    fi
    mkdir -p "$results"
    local checked=(rtbench check -o "$home/checked" --overwrite ${check[@]+"${check[@]}"})
    if [ -n "${PLUGIN:-}" ] && [ -n "${BASE_PLUGIN:-}" ] && [ -e "$results/results.json" ]; then
        # what the run measured, both builds in turns
        checked+=(--baseline "$results" --plugin "$PLUGIN" --against "$BASE_PLUGIN")
    elif [ -n "${BASELINE:-}" ]; then
        checked+=(--baseline "$BASELINE" ${plugin[@]+"${plugin[@]}"})
    else
        checked=()
        echo "::notice::nothing to check against: set base-plugin or baseline"
    fi
    if [ ${#checked[@]} -gt 0 ]; then
        "${checked[@]}" | tee "$home/check.txt" || judged=${PIPESTATUS[0]}
        verdict=$(tail -n 1 "$home/check.txt")
        for file in "$home"/checked/check.*; do
            [ ! -e "$file" ] || mv "$file" "$results"
        done
    fi
    # wrong hits and failures of the run say more than what was checked after it
    [ "$code" != 0 ] || code=$judged
    { echo "results=$results" && echo "exit-code=$code" && echo "verdict=$verdict"; } >> "${GITHUB_OUTPUT:?}"
}

# One comment for each job, which is written anew.
comment() {
    local number=${GITHUB_REF#refs/pull/} matrix marker body=$home/comment.md id
    number=${number%%/*}
    # jobs of a matrix have one name, and other values
    matrix=$(tr -cd 'A-Za-z0-9._:,-' <<< "${MATRIX:-}")
    [ "$matrix" != null ] || matrix=
    marker="<!-- rtbench ${GITHUB_WORKFLOW:?} ${GITHUB_JOB:?}${matrix:+ $matrix} -->"
    {
        echo "$marker"
        [ ! -e "$RESULTS/check.md" ] || cat "$RESULTS/check.md"
        if [ -e "$RESULTS/results.md" ]; then
            printf '<details><summary>What was measured</summary>\n\n'
            cat "$RESULTS/results.md"
            printf '\n</details>\n'
        fi
    } > "$body"
    # the most that a comment may have
    if [ "$(wc -c < "$body")" -gt 65000 ]; then
        printf '%s\n%s\n\nThe tables are in the summary of the job.\n' "$marker" "$VERDICT" > "$body"
    fi
    local comments=repos/${GITHUB_REPOSITORY:?}/issues
    id=$(gh api --paginate "$comments/$number/comments" --jq ".[] | select(.body | startswith(\"$marker\")) | .id") || true
    id=${id%%$'\n'*}
    if [ -n "$id" ]; then
        gh api --silent --method PATCH "$comments/comments/$id" --field "body=@$body"
    else
        gh api --silent --method POST "$comments/$number/comments" --field "body=@$body"
    fi || echo "::warning::no comment was written: the token may not (permission pull-requests: write; none from forks)"
}

case ${1:-} in
install | measure | comment) "$1" ;;
*) echo "usage: scripts/action.sh install|measure|comment" >&2 && exit 2 ;;
esac
