# bash completion for tribus, tribus-web and tribus-mqtt. It starts the program once, which knows what
# fits (app/cli/completion.h).

_tribus()
{
    local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} typed=() word line joins=0
    # readline has broken words at "=" and ":", unless COMP_WORDBREAKS lacks them.
    for word in "${COMP_WORDS[@]:1:COMP_CWORD}"; do
        if [[ ${#typed[@]} -gt 0 && ($joins == 1 || $word == [=:]) ]]; then
            typed[-1]+=$word
        else
            typed+=("$word")
        fi
        [[ $word == [=:] ]] && joins=1 || joins=0
    done
    [[ $current == [=:] ]] && current=""
    # What readline replaces begins behind the last break.
    local kept="" paths=""
    [[ $current == --*=* ]] && kept=${current%%=*}=
    COMPREPLY=()
    while IFS= read -r line; do
        case $line in
            :*) paths=$line ;;
            *) COMPREPLY+=("$kept${line%%$'\t'*}") ;;
        esac
    done < <("$program" --complete "${typed[@]}" 2>/dev/null)
    if [[ -n $paths ]]; then
        compopt -o filenames 2>/dev/null
        local kind=-f
        [[ $paths == :folders ]] && kind=-d
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen $kind -P "$kept" -- "${current#"$kept"}")
    fi
}
complete -F _tribus tribus tribus-web tribus-mqtt
