#!/bin/sh
# Runs the program against implementations of others: tests/peers/run.sh. They come from npm; node
# and npm come from Debian if there are none. Takes the program from build/app, or from the folder
# TRIBUS_PROGRAMS.
set -eu
cd "$(dirname "$0")"
. ../../deploy/prepare.sh

command -v npm >/dev/null || install_packages nodejs npm
npm ci --ignore-scripts --no-audit --no-fund >&2
exec node --test --test-concurrency=1 ./*.test.mjs
