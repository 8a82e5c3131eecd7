#!/bin/sh
# Tests that the driver runs exactly the seeds that were added, and that it refuses a damaged file of
# seeds: seeds_test.sh DRIVER
set -eu
program=$1
driver() {
    "$program" print_input "$@"
}
. "$(dirname "$0")/seeds.sh"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
project_corpus=$corpus
corpus=$folder
cd "$folder"

expect() { # expect WHAT GOT WANTED
    [ "$2" = "$3" ] || {
        printf '%s:\n%s\ninstead of:\n%s\n' "$1" "$2" "$3" >&2
        exit 1
    }
}

# expect_refused SEEDS MESSAGE: the driver fails with it before it runs an input.
expect_refused() {
    printf %b "$1" >damaged.seeds
    if driver --runs 0 damaged.seeds >/dev/null 2>message; then
        expect "The driver's result for '$1'" "0, success" "a failure"
    fi
    grep -qF "damaged.seeds$2" message || expect "The message for '$1'" "$(cat message)" "$2"
}

# SHA-1 of "abc" (FIPS 180-4), of the byte 0 and of 'hello' as coreutils' sha1sum prints them.
abc='a9993e364706816aba3e25717850c26c9cd0d89d 616263'
zero='5ba93c9db0cff93f52b521d7420e43f6eda2784f 00'

printf abc >abc
printf abc >same_bytes
printf '\0' >zero
printf hello >hello
echo 'by_hand 68656C6C6F' >mine.seeds
add_seeds mine zero abc same_bytes hello
expect "Seeds after adding" "$(cat mine.seeds)" "$(printf '%s\n' "$zero" "$abc" 'by_hand 68656C6C6F')"
add_seeds mine abc
expect "Seeds after adding again" "$(wc -l <mine.seeds)" 3

unpack_seeds mine unpacked
expect "Files unpacked" "$(find unpacked -type f | sort | xargs)" \
    "unpacked/${zero% *} unpacked/${abc% *} unpacked/by_hand"
cmp zero "unpacked/${zero% *}"
cmp hello unpacked/by_hand

# The driver begins with an empty input.
expect "Inputs" "$(driver --runs 0 mine.seeds)" "
00
616263
68656c6c6f
4 seeds and 0 inputs made of them: every promise was kept"
expect "Inputs from files" "$(driver --runs 0 unpacked)" "$(driver --runs 0 mine.seeds)"

: >empty
if add_seeds mine empty 2>message; then
    expect "The result of adding an empty file" "0, success" "a failure"
fi
expect "The message for an empty file" "$(cat message)" \
    "empty has 0 bytes; a seed has 1 to 8192. Nothing was added."

if "$program" no_target --runs 0 mine.seeds >/dev/null 2>message; then
    expect "The driver's result for no_target" "0, success" "a failure"
fi
expect "The message for no_target" "$(cat message)" \
    "no_target: is no target; tests/fuzz/README.md lists them"

expect_refused '' ': is empty or its last line is cut off'
expect_refused 'a 00\nb 01' ': is empty or its last line is cut off'
expect_refused 'a 00\nb 0\n' ':2: is not a name, a space and pairs'
expect_refused 'a 00\nb 010\n' ':2: is not a name, a space and pairs'
expect_refused 'a 00\nb 0g\n' ':2: is not a name, a space and pairs'
expect_refused 'a 00\nb\n' ':2: is not a name, a space and pairs'
expect_refused '<<<<<<< HEAD\n' ':1: is not a name, a space and pairs'
expect_refused 'a 00\n\nb 01\n' ':2: is not a name, a space and pairs'
expect_refused 'b 00\na 01\n' ':2: its name is there twice, or the lines are not sorted'
expect_refused 'a 00\na 01\n' ':2: its name is there twice, or the lines are not sorted'

# The seeds of the project: each once, under its hash or a name of its own.
for target in $(corpus=$project_corpus fuzz_targets); do
    expect "Bytes twice in $target" \
        "$(cut -d ' ' -f 2 "$project_corpus/$target.seeds" | sort | uniq -d)" ""
done
