#!/bin/sh
# Keeps what fuzzing has found worth it: tests/fuzz/keep.sh [TARGET...]
# Adds to the seeds in tests/fuzz/corpus as few inputs of build-sanitize/corpus as reach what those
# reach, short ones only; their names are their hashes. After tests/fuzz/run.sh.
set -eu
cd "$(dirname "$0")/../.."

longest=1024
build=build-sanitize
[ $# -gt 0 ] || set -- serial_decoders can_decoders dbc_file configuration recording \
    crash_recording control_socket monitor engine
for target in "$@"; do
    case $target in
        dbc_file) seeds="config/examples deploy/can" ;;
        configuration) seeds="config/examples" ;;
        *) seeds="" ;;
    esac
    all=$build/kept/$target
    rm -rf "$all"
    mkdir -p "$all"
    find "tests/fuzz/corpus/$target" $seeds -maxdepth 1 -type f -exec cp {} "$all" \;
    ls "$all" >"$build/kept/$target.before"
    $build/tests/fuzz/fuzz_"$target" -merge=1 -use_counters=0 -max_len=$longest "$all" \
        "$build/corpus/$target" >"$build/$target.merge.log" 2>&1
    ls "$all" | grep -vxFf "$build/kept/$target.before" | while read -r name; do
        cp "$all/$name" "tests/fuzz/corpus/$target/$name"
    done
    echo "$target: $(find "tests/fuzz/corpus/$target" -type f | wc -l) seeds," \
        "$(cat "tests/fuzz/corpus/$target"/* | wc -c) bytes"
done
