#!/bin/sh
# Breaks tribus in small ways, one at a time, and says which test notices: tests/mutation/run.sh
# [--jobs N] [--record] [PATTERN...]. Without patterns all of mutations.toml, else those whose names
# contain one. --record writes the rows of those that were run into tests/mutation/caught.md. Works in
# build-mutation.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_packages ccache git
exec python3 tests/mutation/run.py "$@"
