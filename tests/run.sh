#!/bin/sh
# Installs what is needed from Debian's packages, builds tribus and its tests, and runs them.
# Arguments go to the test runner: tests/run.sh -R Sbus
cd "$(dirname "$0")/.."
. deploy/prepare.sh
# shellcheck disable=SC2086 # lists of words
install_packages $build_packages $test_packages
build ON all
cd build
exec ctest --output-on-failure --parallel "$(nproc)" "$@"
