
# Words end at blanks alone, not at colons and equal signs, and behind a comma the next name begins.
_rtbench_whole_words() {
    local line=${COMP_LINE:0:COMP_POINT} word cut list=
    word=${line##*[[:space:]]}
    # what bash replaces begins behind the last of its own breaks
    cut=${word%"$2"}
    [[ $2 != [:=] ]] || cut=$word
    read -ra COMP_WORDS <<<"$line"
    [[ -n $word ]] || COMP_WORDS+=("")
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    if [[ $word == *,* ]]; then
        list=${word%,*},
    fi
    COMP_WORDS[COMP_CWORD]=${word##*,}
    _rtbench "$1" "${word##*,}" "${COMP_WORDS[COMP_CWORD - 1]}"
    COMPREPLY=("${COMPREPLY[@]/#/$list}")
    COMPREPLY=("${COMPREPLY[@]#"$cut"}")
}
complete -F _rtbench_whole_words -o bashdefault -o default rtbench
