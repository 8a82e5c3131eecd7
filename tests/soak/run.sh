#!/bin/sh
# Many pipelines for a long time: tests/soak/run.sh [SECONDS] [PIPELINES], by default 64 for an hour.
# Installs what is needed, builds, and ends with what was promised and kept; status 1 where it was not.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_libraries
build ON soak
exec build/tests/soak/soak "$@"
