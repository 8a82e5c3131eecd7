#!/bin/sh
# Looks for inputs that break a promise: tests/fuzz/run.sh [SECONDS] [TARGET...]
# Each target so long (default 60), with the address and undefined-behaviour sanitizers. What is
# found is left in build-fuzz/found/TARGET; what reaches new code is kept in build-fuzz/corpus/TARGET
# for the next time.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

seconds=${1:-60}
[ $# -eq 0 ] || shift
# shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
install_packages $build_packages clang-14 libclang-rt-14-dev
cmake --preset fuzz >&2
cmake --build --preset fuzz >&2

[ $# -gt 0 ] || set -- serial_decoders can_decoders dbc_file configuration recording \
    control_socket monitor engine
failed=""
for target in "$@"; do
    case $target in
        dbc_file) seeds="config/examples deploy/can" ;;
        configuration) seeds="config/examples" ;;
        *) seeds="" ;;
    esac
    echo "Fuzzing $target for $seconds s" >&2
    mkdir -p "build-fuzz/corpus/$target" "build-fuzz/found/$target"
    # shellcheck disable=SC2086 # a list of words
    build-fuzz/tests/fuzz/fuzz_"$target" -max_total_time="$seconds" -timeout=10 -max_len=8192 \
        -print_final_stats=1 -verbosity=0 -artifact_prefix="build-fuzz/found/$target/" \
        "build-fuzz/corpus/$target" "tests/fuzz/corpus/$target" $seeds 2>&1 |
        tee "build-fuzz/$target.log" | grep -E '^stat::number_of|^broken|ERROR|SUMMARY|Test unit' || true
    grep -q 'stat::number_of' "build-fuzz/$target.log" &&
        ! grep -qE 'ERROR|^broken' "build-fuzz/$target.log" || failed="$failed $target"
done
[ -z "$failed" ] || {
    echo "A promise was broken in:$failed; see build-fuzz/found and build-fuzz/TARGET.log" >&2
    exit 1
}
