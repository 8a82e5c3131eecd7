#!/bin/sh
# Installs what is needed from Debian's packages, builds tribus and its tests, and runs them.
# Arguments go to the test runner: tests/run.sh -R Sbus
# TRIBUS_LAB=full adds what the laboratory (tests/lab) does not do each time: other kernels, and
# drivers that have to be built. TRIBUS_LAB=service adds the installed package under systemd instead.
cd "$(dirname "$0")/.."
. deploy/prepare.sh
# shellcheck disable=SC2086 # lists of words
install_packages $build_packages $test_packages $bench_packages
tier=${TRIBUS_LAB:-fast}
tests/lab/prepare.sh "$tier" build/lab ||
    echo "The laboratory could not be prepared: its tests will fail, the others run." >&2
build ON all
case $tier in
    full) left_out=lab_service ;;
    service) left_out=lab_full ;;
    *) left_out='lab_full|lab_service' ;;
esac
set -- --label-exclude "$left_out" "$@"
cd build
exec ctest --output-on-failure --parallel "$(nproc)" "$@"
