#!/bin/sh
# Breaks tribus in small ways, one at a time, and reports which test notices.
#
# Mutations that are made, of any source of the product:
#     tests/mutation/run.sh --changed BASE [--minutes N]      of lines that differ from a commit
#     tests/mutation/run.sh --folder FOLDER [--count N --seed N]
# Survivors are shown with what they change; what is equivalent stands in equivalent.toml. They need
# the build of tests/run.sh..
#
# Mutations that are listed:
#     tests/mutation/run.sh [--jobs N] [--record] [PATTERN...]
# Without patterns it runs all of mutations.toml, otherwise the entries whose names contain a
# pattern. --record writes the rows of these entries into tests/mutation/caught.md. Works in
# build-mutation.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh
case " $*" in
    *" --changed"* | *" --folder"*) made=true ;;
    *) made=false ;;
esac
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
if $made; then
    install_packages $build_packages $test_packages $mutation_packages git
    # Debian's own: the package is for no other.
    /usr/bin/python3 tests/mutation/make_test.py --failfast 2>/dev/null ||
        { echo "tests/mutation/make_test.py fails" >&2 && exit 2; }
    exec /usr/bin/python3 tests/mutation/made.py "$@"
fi
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_packages ccache git
exec python3 tests/mutation/run.py "$@"
