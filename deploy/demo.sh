#!/bin/sh
# Installs what is needed from Debian's packages, builds tribus, and runs its demo.
# Arguments go to the demo: deploy/demo.sh --seconds 20
cd "$(dirname "$0")/.."
. deploy/prepare.sh
# shellcheck disable=SC2086 # a list of words
install_packages $build_packages
build OFF tribus
exec build/app/tribus demo "$@"
