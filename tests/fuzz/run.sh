#!/bin/sh
# Looks for inputs that break a promise: tests/fuzz/run.sh [SECONDS] [TARGET...]
# Each target so long (default 60), with the address and undefined-behaviour sanitizers. What is
# found is left in build-sanitize/found/TARGET; what reaches new code is kept in
# build-sanitize/corpus/TARGET for the next time.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

seconds=${1:-60}
[ $# -eq 0 ] || shift
# llvm-14 has what turns addresses into lines.
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_libraries clang-14 libclang-rt-14-dev llvm-14
cmake --preset sanitize >&2
[ $# -gt 0 ] || set -- serial_decoders can_decoders dbc_file configuration recording \
    crash_recording control_socket monitor engine
build=build-sanitize
for target in "$@"; do
    cmake --build $build --target fuzz_"$target" >&2
done

failed=""
for target in "$@"; do
    case $target in
        dbc_file) seeds="config/examples deploy/can" ;;
        configuration) seeds="config/examples" ;;
        *) seeds="" ;;
    esac
    echo "Fuzzing $target for $seconds s" >&2
    mkdir -p "$build/corpus/$target" "$build/found/$target"
    # shellcheck disable=SC2086 # a list of words
    $build/tests/fuzz/fuzz_"$target" -max_total_time="$seconds" -timeout=10 -max_len=8192 \
        -print_final_stats=1 -artifact_prefix="$build/found/$target/" \
        "$build/corpus/$target" "tests/fuzz/corpus/$target" $seeds >"$build/$target.log" 2>&1 ||
        failed="$failed $target"
    grep -E 'INITED|DONE|^broken|runtime error|^SUMMARY|Test unit' "$build/$target.log" || true
done
[ -z "$failed" ] || {
    echo "A promise was broken in:$failed; see $build/found and $build/TARGET.log" >&2
    exit 1
}
