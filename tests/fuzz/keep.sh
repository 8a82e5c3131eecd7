#!/bin/sh
# Adds to the seeds in tests/fuzz/corpus:
#     tests/fuzz/keep.sh [TARGET...]       what tests/fuzz/run.sh found
#     tests/fuzz/keep.sh TARGET FILE...    these files, such as an input that broke a promise
# The first form takes from build-addresses/corpus only short inputs, and only as many as are needed
# to reach the same code.
set -eu
. "$(dirname "$0")/seeds.sh"

print_size() {
    awk -v target="$1" '{ bytes += length($2) / 2 }
        END { print target ": " NR " seeds, " bytes " bytes" }' "$corpus/$1.seeds"
}

if [ $# -gt 1 ] && [ -f "$2" ]; then
    add_seeds "$@"
    print_size "$1"
    exit
fi

cd "$(dirname "$0")/../.."
longest=1024
build=build-addresses
# shellcheck disable=SC2046 # a list of words
[ $# -gt 0 ] || set -- $(fuzz_targets)
for target in "$@"; do
    require_target "$target"
done
for target in "$@"; do
    all=$build/kept/$target
    unpack_seeds "$target" "$all"
    for folder in $(seed_folders "$target"); do
        find "$folder" -maxdepth 1 -type f -exec cp {} "$all" \;
    done
    find "$all" -type f >"$all.before"
    $build/tests/fuzz/fuzz_"$target" -merge=1 -use_counters=0 -max_len=$longest "$all" \
        "$build/corpus/$target" >"$build/$target.merge.log" 2>&1
    added=$(find "$all" -type f | grep -vxFf "$all.before" || true)
    # shellcheck disable=SC2086 # libFuzzer's names are hashes
    add_seeds "$target" $added
    print_size "$target"
done
