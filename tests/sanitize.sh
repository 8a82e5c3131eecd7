#!/bin/sh
# Runs tests with a sanitizer: tests/sanitize.sh threads|addresses [FILTER [SUITE...]]
# threads: data races, in the tests of data that threads share and in the built program over ptys.
# addresses: wrong addresses and undefined behaviour, in the tests that need no laboratory.
# FILTER is a filter of googletest. Any report of a sanitizer about any process is a failure; it is
# kept in the folder reports of the build.
cd "$(dirname "$0")/.."
. deploy/prepare.sh

usage() {
    echo "Usage: tests/sanitize.sh threads|addresses [FILTER [SUITE...]]" >&2
    exit 2
}

preset=${1:-}
case $preset in
    threads)
        compiler=""
        suites="thread_tests loopback_tests"
        ;;
    addresses)
        compiler="clang-14 libclang-rt-14-dev llvm-14"
        suites="unit_tests property_tests capture_tests sim_tests gpio_tests machine_tests loopback_tests"
        ;;
    *) usage ;;
esac
shift
filter=${1:-*}
[ $# -eq 0 ] || shift
# shellcheck disable=SC2086 # a list of words
[ $# -gt 0 ] || set -- $suites

# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_packages $compiler
cmake --preset "$preset" >&2
cmake --build --preset "$preset" --target "$@" >&2

reports=$PWD/build-$preset/reports
rm -rf "$reports"
mkdir -p "$reports"
options="log_path=$reports/report"
export ASAN_OPTIONS="$options:detect_stack_use_after_return=1:strict_string_checks=1"
export UBSAN_OPTIONS="$options:print_stacktrace=1"
export TSAN_OPTIONS="$options:second_deadlock_stack=1"

failed=""
for suite in "$@"; do
    echo "$suite with sanitizers" >&2
    build-$preset/tests/"$suite" --gtest_brief=1 --gtest_filter="$filter" || failed="$failed $suite"
done
if [ -n "$(ls "$reports")" ]; then
    grep -hE '^SUMMARY|runtime error' "$reports"/* | sort | uniq -c >&2 || true
    echo "The sanitizer has said something: see $reports" >&2
    exit 1
fi
[ -z "$failed" ] || {
    echo "Nothing was said by the sanitizer, but tests failed in:$failed" >&2
    exit 1
}
echo "Clean: $*"
