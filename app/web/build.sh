#!/bin/sh
# Builds the page into app/web/page/dist: app/web/build.sh [--tests [FILE...]]. Needs node 18.19 or
# newer and npm; takes Debian's if there are none.
# --tests also checks types and runs the tests in Debian's Chromium and Firefox, or those FILEs of
# tests/, for which Chromium is enough: before a simulated server, or before the programs in
# build/app. All of them take some 25 minutes and put pictures of each screen into build/pictures.
set -eu
cd "$(dirname "$0")/page"
. ../../../deploy/prepare.sh

command -v npm >/dev/null || install_packages nodejs npm
npm ci --ignore-scripts --no-audit --no-fund >&2
node build.mjs
find dist -type f ! -name '*.gz' -exec gzip -9nkf {} +
[ "${1:-}" = --tests ] || exit 0
shift

command -v chromium >/dev/null || install_packages chromium fonts-dejavu-core
command -v python3 >/dev/null || install_packages python3
npx tsc --noEmit
if [ $# -gt 0 ]; then
    cd tests
    exec node --test --test-concurrency=1 "$@"
fi
command -v firefox-esr >/dev/null || install_packages firefox-esr
npm test
node tests/pictures.mjs ../../../build/pictures
