# shellcheck shell=sh
# The seeds of the fuzz targets, for the scripts of this folder. corpus/TARGET.seeds has one line a
# seed: its name, a space, its bytes in hexadecimal. The name is the SHA-1 of the bytes, unless the
# seed was written by hand. Lines are sorted by name, and no bytes are there twice.

corpus=$(cd "$(dirname "$0")" && pwd)/corpus
# shellcheck disable=SC2034 # for the scripts that read this file
longest_input=8192 # bytes; driver.cpp cuts what is longer

fuzz_targets() {
    for seeds in "$corpus"/*.seeds; do
        basename "$seeds" .seeds
    done
}

# seed_folders TARGET: folders of the project whose files are seeds too.
seed_folders() {
    case $1 in
        dbc_file) echo config/examples deploy/can ;;
        configuration) echo config/examples ;;
    esac
}

require_target() {
    [ -f "$corpus/$1.seeds" ] || {
        echo "No fuzz target is called '$1'. There are: $(fuzz_targets | xargs)" >&2
        return 1
    }
}

# unpack_seeds TARGET FOLDER: one file a seed, as libFuzzer reads them.
unpack_seeds() {
    require_target "$1" || return 1
    rm -rf "$2" && mkdir -p "$2" || return 1
    while read -r name bytes; do
        printf %s "$bytes" | basenc --base16 --decode >"$2/$name" || {
            echo "$corpus/$1.seeds: the bytes of $name are damaged; restore the file from git" >&2
            return 1
        }
    done <"$corpus/$1.seeds"
}

# add_seeds TARGET [FILE...]: bytes that are there already keep their name.
add_seeds() {
    require_target "$1" || return 1
    seeds=$corpus/$1.seeds
    shift
    for file in "$@"; do
        size=$(wc -c <"$file") || return 1
        if [ "$size" -eq 0 ] || [ "$size" -gt $longest_input ]; then
            echo "$file has $size bytes; a seed has 1 to $longest_input. Nothing was added." >&2
            return 1
        fi
    done
    for file in "$@"; do
        echo "$(sha1sum <"$file" | cut -d ' ' -f 1) $(basenc --base16 --wrap=0 <"$file")"
    done | awk '!($2 in seen) { seen[$2]; print }' "$seeds" - | LC_ALL=C sort >"$seeds.new" &&
        mv "$seeds.new" "$seeds"
}
