#!/bin/sh
# Shows which lines and branches of the product the tests reach: tests/coverage.sh
# Builds in build-coverage, runs the suites that need no laboratory, and prints the shares of each
# folder. build-coverage/report/index.html shows each line.
cd "$(dirname "$0")/.."
. deploy/prepare.sh

# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $test_packages gcovr
suites="unit_tests property_tests capture_tests sim_tests gpio_tests machine_tests loopback_tests"
cmake --preset coverage >&2
# shellcheck disable=SC2086 # a list of words
cmake --build --preset coverage --target $suites >&2

find build-coverage -name '*.gcda' -delete
failed=""
for suite in $suites; do
    echo "$suite for coverage" >&2
    build-coverage/tests/"$suite" --gtest_brief=1 >&2 || failed="$failed $suite"
done

folders="core transports pipelines config app"
mkdir -p build-coverage/report
cd build-coverage
# shellcheck disable=SC2086 # a list of words
gcovr --root .. $(printf -- '--filter ../%s/ ' $folders) --exclude-throw-branches \
    --exclude-unreachable-branches -j "$(nproc)" --json-summary report/summary.json \
    --html-details report/index.html $folders >report/gcovr.log
cd ..
# shellcheck disable=SC2086 # a list of words
python3 - $folders <<'PYTHON'
import json
import re
import sys

files = json.load(open("build-coverage/report/summary.json"))["files"]


def row(name, files):
    counts = [sum(file[key] for file in files) for key in
              ("line_covered", "line_total", "branch_covered", "branch_total")]
    line, lines, branch, branches = counts
    print(f"| {name} | {lines} | {100 * line / lines:.1f} % | {branches} "
          f"| {100 * branch / branches:.1f} % |")


def source(file):
    """A header is found by the folder of its layer (deploy/cmake/layers.cmake)."""
    return re.sub(r"^build-coverage/layers/[^/]+/", "", file["filename"])


print("| folder | lines | reached | branches | reached |\n|---|---|---|---|---|")
for folder in sys.argv[1:]:
    row(f"`{folder}`", [file for file in files if source(file).startswith(folder + "/")])
row("all", files)
PYTHON
[ -z "$failed" ] || {
    echo "Tests failed in:$failed" >&2
    exit 1
}
