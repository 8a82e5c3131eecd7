#!/bin/sh
# Prints a table of the bounds in real time and what this machine reaches. First installs what is
# needed from Debian's packages and builds. Needs root for real time. Arguments: see --help.
#   tests/bench/bounds.sh                      all rows, about 8 minutes on a quiet machine
#   tests/bench/bounds.sh --only latency,cpu   some rows
#   tests/bench/bounds.sh --long               a million frames where lost frames are counted
cd "$(dirname "$0")/../.."
. deploy/prepare.sh
# shellcheck disable=SC2086 # lists of words
install_packages $build_packages $test_packages $bench_packages $arm_packages socat stress-ng rt-tests
build ON tribus bounds heap_trap_preload
exec build/tests/bench/bounds "$@"
