#!/usr/bin/env python3
"""Breaks tribus as tests/mutation/mutations.toml lists and finds out which test notices.

Called by run.sh, which describes the arguments. Exit status 1 if a mutation survived or could not be tried.
"""

import argparse
import dataclasses
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import time
import tomllib

import test_program

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build-mutation"
SOURCE = WORK / "source"
BUILD = WORK / "build"
LIST = ROOT / "tests/mutation/mutations.toml"
CAUGHT = ROOT / "tests/mutation/caught.md"

# The fastest suite first.
SUITES = ["unit", "property", "capture", "sim", "machine", "loopback"]
# Tests that read sources and do not run the program.
NO_TESTS_OF_THE_PROGRAM = "Tidy.*:MutationList.*"
NO_TEST = "no test"
# A test that takes this many times as long as the whole suite without a mutation hangs. For the
# tests that an entry names, there is also a minimum.
PATIENCE = 5
LEAST_PATIENCE_S = 120


@dataclasses.dataclass
class Mutation:
    name: str
    file: str
    text: str
    instead: str
    suite: str = "unit"
    filter: str = "*"


@dataclasses.dataclass
class Result:
    mutation: Mutation
    said: str
    # Whether it was tried and a test noticed it.
    good: bool


def say(text):
    print(text, file=sys.stderr, flush=True)


def copy_sources():
    """Copies only changed files, so that only these are built. Returns a digest of all files."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, check=True, capture_output=True).stdout.decode().split("\0")
    names = [name for name in listed if name and (ROOT / name).is_file()]
    digest = hashlib.sha256()
    for name in sorted(names):
        content = (ROOT / name).read_bytes()
        if not name.startswith("tests/mutation/"):
            digest.update(name.encode() + b"\0" + content + b"\0")
        copy = SOURCE / name
        if not copy.is_file() or copy.read_bytes() != content:
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(content)
            shutil.copymode(ROOT / name, copy)
    known = set(names)
    for path in SOURCE.rglob("*"):
        if path.is_file() and str(path.relative_to(SOURCE)) not in known:
            path.unlink()
    return digest.hexdigest()


def environment():
    inside = dict(os.environ)
    inside.setdefault("CCACHE_DIR", str(WORK / "ccache"))
    inside.setdefault("CCACHE_SLOPPINESS", "time_macros,pch_defines")
    return inside


def configure():
    """Configures as shipped, but without optimisations that take longer than they save."""
    shared = os.environ.get("TRIBUS_SHARED", ROOT.parent / "shared")
    subprocess.run(
        ["cmake", "-S", SOURCE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
         "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG", "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache",
         "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST", f"-DTRIBUS_SHARED={shared}",
         # A mutation may leave a variable unused.
         "-DTRIBUS_WERROR=OFF"],
        check=True, stdout=subprocess.DEVNULL, env=environment())


def build(suites, jobs):
    """Returns the compiler's output if the build failed, else None."""
    targets = [f"{suite}_tests" for suite in suites]
    done = subprocess.run(
        ["cmake", "--build", BUILD, "--parallel", str(jobs), "--target", *targets],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment())
    return None if done.returncode == 0 else done.stdout


def run_tests(suite, tests, limit_s):
    """Returns the first test that fails, and how if it crashed or hung; None if all pass."""
    with (WORK / f"{suite}.log").open("w+", errors="replace") as log:
        status, output = test_program.run(
            [BUILD / "tests" / f"{suite}_tests", "--gtest_fail_fast",
             "--gtest_color=no", f"--gtest_filter={tests}-{NO_TESTS_OF_THE_PROGRAM}"],
            log, limit_s, cwd=BUILD / "tests")
    last = test_program.last_test(output)
    if last is None:
        return NO_TEST
    if status is None:
        return f"{last}, which does not end"
    failed = test_program.failed_test(output)
    return failed or (f"{last}, which ends the program" if status != 0 else None)


def check_unbroken(digest, suites, jobs):
    """Returns how long each suite may take. Measures only once for the same sources."""
    green = WORK / "green.toml"
    known = tomllib.loads(green.read_text()) if green.is_file() else {}
    if known.get("sources") != digest:
        known = {"sources": digest, "seconds": {}}
    for suite in suites:
        if suite in known["seconds"]:
            continue
        begin = time.monotonic()
        failed = run_tests(suite, "*", 3600)
        if failed:
            sys.exit(f"Nothing is broken yet, and {failed} of {suite}_tests fails: "
                     f"see {WORK}/{suite}.log")
        known["seconds"][suite] = round(time.monotonic() - begin, 1)
        say(f"{suite}_tests: all pass in {known['seconds'][suite]} s")
        seconds = "\n".join(f"{name} = {value}" for name, value in known["seconds"].items())
        green.write_text(f'sources = "{digest}"\n[seconds]\n{seconds}\n')
    return {suite: max(PATIENCE * known["seconds"][suite], LEAST_PATIENCE_S) for suite in suites}


def attempt(mutation, limits, jobs):
    """Builds and runs the tests. The mutation has already been made in the file."""
    order = [mutation.suite] + [suite for suite in SUITES if suite != mutation.suite]
    for tries, suite in enumerate(order):
        error = build([suite], jobs)
        if error:
            (WORK / "compiler.log").write_text(error)
            return Result(mutation, "does not compile: see build-mutation/compiler.log", False)
        if tries == 0:
            caught = run_tests(suite, mutation.filter, LEAST_PATIENCE_S)
            if caught == NO_TEST:
                return Result(mutation, f"{mutation.filter} is no test of {suite}_tests", False)
            if caught:
                return Result(mutation, f"caught by {caught}", True)
        caught = run_tests(suite, "*", limits[suite])
        if caught:
            return Result(mutation, f"caught by {caught}", True)
    return Result(mutation, "SURVIVED", False)


def try_one(mutation, limits, jobs):
    path = SOURCE / mutation.file
    original = path.read_text()
    if original.count(mutation.text) != 1:
        return Result(mutation, f"its text is not once in {mutation.file}", False)
    path.write_text(original.replace(mutation.text, mutation.instead))
    try:
        return attempt(mutation, limits, jobs)
    finally:
        path.write_text(original)


def row(result):
    noticed = result.said.removeprefix("caught by ")
    test, _, how = noticed.partition(",")
    test = f"`{test}`" if result.good else test
    return (f"| {result.mutation.name} | `{result.mutation.file}` | "
            f"{test}{',' if how else ''}{how} |")


def table(rows):
    return "\n".join(["| broken | in | noticed by |", "|---|---|---|", *rows])


def record(mutations, results):
    """Writes the rows of these results. Rows of other mutations stay."""
    fresh = {result.mutation.name: row(result) for result in results}
    before = CAUGHT.read_text().splitlines() if CAUGHT.is_file() else []
    rows = []
    for mutation in mutations:
        begin = f"| {mutation.name} | `{mutation.file}` | "
        known = next((line for line in before if line.startswith(begin)),
                     f"{begin}not tried yet |")
        rows.append(fresh.get(mutation.name, known))
    CAUGHT.write_text(table(rows) + "\n")


def main():
    parser = argparse.ArgumentParser(prog="tests/mutation/run.sh", description=__doc__)
    parser.add_argument("patterns", nargs="*", metavar="PATTERN",
                        help="only mutations whose names contain it")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="of the compiler")
    parser.add_argument("--record", action="store_true", help=f"write {CAUGHT.relative_to(ROOT)}")
    asked = parser.parse_args()

    mutations = [Mutation(**entry) for entry in tomllib.loads(LIST.read_text())["mutation"]]
    chosen = [mutation for mutation in mutations if not asked.patterns or
              any(pattern.lower() in mutation.name.lower() for pattern in asked.patterns)]
    if not chosen:
        sys.exit("No mutation has such a name; tests/mutation/mutations.toml has them all.")

    begin = time.monotonic()
    digest = copy_sources()
    configure()
    say("Building what is not broken")
    error = build(SUITES, asked.jobs)
    if error:
        sys.exit(error)
    limits = check_unbroken(digest, SUITES, asked.jobs)
    results = []
    for number, mutation in enumerate(chosen, 1):
        started = time.monotonic()
        results.append(try_one(mutation, limits, asked.jobs))
        say(f"{number}/{len(chosen)} {mutation.name}: {results[-1].said} "
            f"({time.monotonic() - started:.0f} s)")
    good = sum(result.good for result in results)
    summary = f"{good} of {len(results)} noticed, {(time.monotonic() - begin) / 60:.0f} min"
    print(table(row(result) for result in results))
    say(summary)
    if asked.record:
        record(mutations, results)
    return 0 if good == len(results) else 1


if __name__ == "__main__":
    sys.exit(main())
