# bash completion for tribus. It reads `tribus --help`, so it always fits the program.

_tribus()
{
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local program=${COMP_WORDS[0]} words=() help
    COMPREPLY=()
    if ((COMP_CWORD > 1)); then
        words=("${COMP_WORDS[1]}")
    fi
    help=$("$program" "${words[@]}" --help 2>/dev/null) || return 0
    # Many choices take several lines.
    help=$(sed -e ':more' -e '/{[^}]*,$/{N' -e 's/\n *//' -e 'b more' -e '}' <<<"$help")
    if ((COMP_CWORD > 1)) && [[ $current != -* ]]; then
        # The choices of an option are in its line: --format TEXT:{toml,json}
        local choices
        choices=$(sed -n "s/^ *\(-[a-zA-Z],\)\{0,1\}$previous [^{]*{\([^}]*\)}.*/\2/p" <<<"$help")
        if [[ $previous == --* && -n $choices ]]; then
            mapfile -t COMPREPLY < <(compgen -W "${choices//,/ }" -- "$current")
        else
            compopt -o filenames 2>/dev/null
            mapfile -t COMPREPLY < <(compgen -f -- "$current")
        fi
        return 0
    fi
    local candidates
    candidates=$(grep -oE '^ +(-[a-zA-Z],)?--[a-z0-9_-]+' <<<"$help" | grep -oE -- '--[a-z0-9_-]+')
    if ((COMP_CWORD == 1)); then
        candidates+=" "$(sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z0-9-]*\) .*/\1/p' <<<"$help")
    fi
    mapfile -t COMPREPLY < <(compgen -W "$candidates" -- "$current")
}
complete -F _tribus tribus
