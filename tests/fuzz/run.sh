#!/bin/sh
# Looks for inputs that break a promise: tests/fuzz/run.sh [SECONDS] [TARGET...]
# SECONDS is for each target (default 60). The address and undefined-behaviour sanitizers are on.
# Inputs that break a promise are left in build-addresses/found/TARGET, inputs that reach new code in
# build-addresses/corpus/TARGET, where the next run starts.
. "$(dirname "$0")/seeds.sh"
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

seconds=${1:-60}
[ $# -eq 0 ] || shift
# llvm-14 translates addresses into lines.
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_libraries clang-14 libclang-rt-14-dev llvm-14
cmake --preset addresses >&2
# shellcheck disable=SC2046 # a list of words
[ $# -gt 0 ] || set -- $(fuzz_targets)
build=build-addresses
for target in "$@"; do
    cmake --build $build --target fuzz_"$target" >&2
done

failed=""
for target in "$@"; do
    seeds=$build/seeds/$target
    unpack_seeds "$target" "$seeds"
    echo "Fuzzing $target for $seconds s" >&2
    mkdir -p "$build/corpus/$target" "$build/found/$target"
    # shellcheck disable=SC2046 # a list of words
    $build/tests/fuzz/fuzz_"$target" -max_total_time="$seconds" -timeout=10 \
        -max_len="$longest_input" -print_final_stats=1 -artifact_prefix="$build/found/$target/" \
        "$build/corpus/$target" "$seeds" $(seed_folders "$target") >"$build/$target.log" 2>&1 ||
        failed="$failed $target"
    grep -E 'INITED|DONE|^broken|runtime error|^SUMMARY|Test unit' "$build/$target.log" || true
done
[ -z "$failed" ] || {
    echo "A promise was broken in:$failed; see $build/found and $build/TARGET.log" >&2
    exit 1
}
