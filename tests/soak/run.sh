#!/bin/sh
# Many pipelines for a long time: tests/soak/run.sh [SECONDS] [PIPELINES]
# By default 64 pipelines for an hour. Installs what is needed, builds, and ends with a list of the
# promises. The status is 1 if one was broken.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_libraries
build ON soak
exec build/tests/soak/soak "$@"
