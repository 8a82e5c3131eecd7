# fish completion for tribus. It reads `tribus --help`, so it always fits the program.

function __tribus_commands
    tribus --help | string match -rg '^  ([a-z][a-z0-9-]*  +.*)$' | string replace -r '  +' \t
end

function __tribus_options
    set -l words (commandline -opc)
    tribus $words[2] --help 2>/dev/null | string match -rg '^ +(?:-[a-zA-Z],)?(--[a-z0-9_-]+)'
end

# The choices of an option are in its line, many of them in several lines: --format TEXT:{toml,json}
function __tribus_choices
    set -l words (commandline -opc)
    tribus $words[2] --help 2>/dev/null |
        string collect | string replace -ra ',\n +' ',' | string split \n |
        string match -rg -- "^ +(?:-[a-zA-Z],)?$words[-1] [^{]*\{([^}]*)\}" | string split ,
end

complete -c tribus -n 'test (count (commandline -opc)) -eq 1' -f -a '(__tribus_commands)'
complete -c tribus -n 'test (count (commandline -opc)) -gt 1; and test -z "$(__tribus_choices)"' -a '(__tribus_options)'
complete -c tribus -n 'test -n "$(__tribus_choices)"' -f -a '(__tribus_choices)'
