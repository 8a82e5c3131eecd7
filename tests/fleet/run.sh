#!/bin/sh
# Runs the program beside the engines with which people run many boards:
#
#   tests/fleet/run.sh [NAME...]    the tests in NAME*_test.py; by itself those in all *_test.py
#
# A test file names the Debian packages that it needs in a line `# Debian packages: ...`. Takes the
# programs from build/app, or from the folder TRIBUS_PROGRAMS.
set -eu
cd "$(dirname "$0")"
. ../../deploy/prepare.sh

TRIBUS_PROGRAMS=$(realpath "${TRIBUS_PROGRAMS:-../../build/app}")
export TRIBUS_PROGRAMS
[ $# -gt 0 ] || set -- ""
failed=0
for name in "$@"; do
    for file in "$name"*_test.py; do
        [ -e "$file" ] || {
            echo "tests/fleet/run.sh: no file is called $file" >&2
            exit 2
        }
        # shellcheck disable=SC2046 # a list of words
        install_packages python3 $(sed -n 's/^# Debian packages: //p' "$file")
        /usr/bin/python3 -m unittest -v "${file%.py}" || failed=1
    done
done
exit $failed
