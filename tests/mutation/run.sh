#!/bin/sh
# Breaks tribus in small ways, one at a time, and reports which test notices:
#     tests/mutation/run.sh [--jobs N] [--record] [PATTERN...]
# Without patterns it runs all of mutations.toml, otherwise the entries whose names contain a
# pattern. --record writes the rows of these entries into tests/mutation/caught.md. Works in
# build-mutation.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_packages ccache git
exec python3 tests/mutation/run.py "$@"
