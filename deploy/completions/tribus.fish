# fish completion for tribus, tribus-web and tribus-mqtt. It starts the program once, which knows what
# fits (app/cli/completion.h).

function __tribus_words
    set -l before (commandline -opc)
    set -l current "$(commandline -ct)"
    # fish replaces the whole word.
    set -l kept (string match -r -- '^--[^=]*=' $current)
    for line in ($before[1] --complete $before[2..] $current 2>/dev/null)
        switch $line
            case ':files'
                __fish_complete_path $current
            case ':folders'
                __fish_complete_directories $current
            case '*'
                echo "$kept$line"
        end
    end
end

for program in tribus tribus-web tribus-mqtt
    complete -c $program -f -a '(__tribus_words)'
end
