#!/bin/sh
# Simulates random worlds for a long time: tests/sim/run.sh [HOURS] [FIRST_SEED]
# HOURS are simulated hours (default 1000). The default seeds occur in no other test run. For a world
# that breaks a promise it prints the command that runs it again, and adds its seed to
# tests/sim/regression_seeds.txt, which every test run goes through.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

hours=${1:-1000}
first=${2:-1000001}
# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_libraries
build ON sim_tests

# Length of one world (tests/sim/random_world.h).
seconds=34
# Worlds for each process.
share=500
# Worlds of each kind: serial only, with CAN, with CAN and reloads, and with CAN and stalls.
worlds=$((hours * 3600 / seconds / 4))
found=$(mktemp)
trap 'rm -f "$found"' EXIT
echo "Simulating four times $worlds worlds, $hours hours" >&2
seq "$first" "$share" $((first + worlds - 1)) |
    TRIBUS_LAST=$((first + worlds - 1)) TRIBUS_SHARE=$share xargs -P "$(nproc)" -I '{}' sh -c '
        last=$(({} + TRIBUS_SHARE - 1))
        [ "$last" -le "$TRIBUS_LAST" ] || last=$TRIBUS_LAST
        TRIBUS_SEED={}-$last build/tests/sim_tests --gtest_brief=1 \
            --gtest_filter="NeverStale.no_r*" 2>&1 |
            grep -vE "^\[|^Running main" || true' | tee "$found"

seeds=$(sed -n -e 's/.*replay: TRIBUS_SEED=\([0-9]*\) .*no_random_world_breaks.*/\1/p' \
    -e 's/.*replay: TRIBUS_SEED=\([0-9]*\) .*_with_can_.*/can \1/p' \
    -e 's/.*replay: TRIBUS_SEED=\([0-9]*\) .*no_reload_.*/reload \1/p' \
    -e 's/.*replay: TRIBUS_SEED=\([0-9]*\) .*no_reader_.*/stall \1/p' "$found" | sort -u)
if [ -n "$seeds" ]; then
    echo "$seeds" >>tests/sim/regression_seeds.txt
    echo "Promises were broken in worlds $(echo "$seeds" | tr '\n' ' ')" >&2
    exit 1
fi
echo "Four times $worlds worlds, $hours hours: every promise was kept"
