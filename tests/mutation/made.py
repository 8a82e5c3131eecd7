#!/usr/bin/python3
"""Breaks tribus by mutations that are made (make.py), and finds out which of them no test notices.

Called by run.sh, which describes the arguments. Exit status 1 if a mutation survived, 2 if none
could be tried.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import json
import multiprocessing
import os
import pathlib
import random
import re
import resource
import shutil
import subprocess
import sys
import threading
import time
import tomllib

import make
import test_program
from switched_build import Failed, HERE, OWN_ROOT, SwitchedBuild

WORK = OWN_ROOT / "build-mutation/made"
EQUIVALENT = HERE / "equivalent.toml"
PRODUCT = ["core/", "transports/", "pipelines/", "config/", "app/"]
# The fastest first.
ALL_SUITES = ["unit", "property", "capture", "sim", "gpio", "machine", "can", "loopback"]
# Those that run the program or a guest are asked for.
SUITES = ALL_SUITES[:-2]
# They wait more than they compute, and a stall of the machine may fail them.
WAITING = {"machine", "can", "loopback"}
# Tests that read sources, and tests of the second tier.
LEFT_OUT = ("Tidy.*:MutationList.*:References.*:Rights.*:Stays.*:Tables.*:Version.*:"
            "*InManyWorlds.*:InitTextOfEverySet.*:LivePageExamples.*:"
            "Further/LineJudgeAtAPort.*:Further/RecordedLineAtAPort.*")
# A test hangs if it takes this many times as long as without a mutation, and some seconds.
PATIENCE = 5
LEAST_PATIENCE_S = 10
# The tests that reach the fewest other mutations come first, for about this long.
FIRST_TESTS_MS = 1500
# Of tests that wait, the others run at once, and not more of them than take so long.
MOST_WAITING_MS = 40_000
MOST_BYTES = 4 << 30
# Of a filter that the kernel takes as one argument; a guest's kernel takes less in all.
LONGEST_FILTER = 100_000
LONGEST_RECORD_S = 900


@dataclasses.dataclass
class Test:
    suite: str
    name: str
    milliseconds: int
    reached: frozenset


@dataclasses.dataclass
class Result:
    mutation: make.Mutation
    noticed_by: str
    ran: int
    tests: int
    seconds: float


def say(text):
    print(text, file=sys.stderr, flush=True)


def product_files(folder):
    listed = subprocess.run(["git", "ls-files", "--", folder], cwd=OWN_ROOT, check=True,
                            capture_output=True, text=True).stdout.split()
    return [file for file in listed if file.endswith((".cpp", ".h")) and
            file.startswith(tuple(PRODUCT))]


def changed_lines(base):
    """The lines of the product that differ from a commit: {file: set of lines}."""
    said = subprocess.run(["git", "diff", "--unified=0", "--no-color", base, "--", *PRODUCT],
                          cwd=OWN_ROOT, check=True, capture_output=True, text=True).stdout
    lines = collections.defaultdict(set)
    file = None
    for line in said.splitlines():
        if line.startswith("+++ "):
            file = line.removeprefix("+++ b/") if line.endswith((".cpp", ".h")) else None
        hunk = re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line)
        if hunk and file:
            first, count = int(hunk[1]), int(hunk[2] or 1)
            lines[file].update(range(first, first + count))
    return {file: rows for file, rows in lines.items() if rows}


def equivalent_keys():
    entries = tomllib.loads(EQUIVALENT.read_text()).get("equivalent", [])
    return {entry["key"] for entry in entries}


class Campaign:
    def __init__(self, asked):
        self.asked = asked
        self.begin = time.time()
        self.until = self.begin + 60 * asked.minutes if asked.minutes else None
        suites = [suite for suite in ALL_SUITES if suite in (asked.suite or SUITES)]
        self.build = SwitchedBuild(asked.build, WORK, suites, asked.jobs)
        self.texts = {}
        self.fixed_numbers = 0
        self.lock = threading.Lock()
        self.workers = {}
        # Tests that fail without a mutation.
        self.failed = []

    def at(self, share):
        """When this share of the time is over; None if there is no limit."""
        return self.begin + share * (self.until - self.begin) if self.until else None

    def find(self):
        """All mutations that are asked for, before any is left out."""
        lines = changed_lines(self.asked.changed) if self.asked.changed else None
        files = list(lines) if lines is not None else \
            [file for folder in self.asked.folder for file in product_files(folder)]
        of_files = {}
        not_looked = 0
        until = self.at(0.3)
        with multiprocessing.Pool(self.asked.jobs) as pool:
            waiting = [(each, pool.apply_async(make.find, each))
                       for each in self.build.find(files)]
            for (_, _, paths), result in waiting:
                try:
                    of_files |= result.get(max(until - time.time(), 0) if until else None)
                except multiprocessing.TimeoutError:
                    not_looked += len(paths)
        if not_looked:
            say(f"No time to look for mutations in {not_looked} files")
        found = []
        for file, (mutations, fixed) in sorted(of_files.items()):
            self.texts[file] = make.read(self.build.root / file)
            self.fixed_numbers += fixed
            found += [mutation for mutation in mutations if lines is None or
                      lines[file] & set(range(mutation.line, mutation.last_line + 1))]
        return found

    def choose(self, found):
        """A sample in random order; some more than asked for, as a compiler refuses some."""
        if self.asked.key:
            return [mutation for mutation in found if mutation.key in self.asked.key]
        found.sort(key=lambda mutation: mutation.key)
        random.Random(self.asked.seed).shuffle(found)
        return found[:self.asked.count * 11 // 10 + 10] if self.asked.count else found

    def compile(self, chosen):
        """Returns those that compile."""
        numbers = {mutation.key: number for number, mutation in enumerate(chosen, 1)}
        refused = set()
        for _ in range(12):
            switched = {}
            for file in {mutation.file for mutation in chosen}:
                good = [each for each in chosen if each.file == file and each.key not in refused]
                switched[file] = make.Switched(self.texts[file], good, numbers)
            objects = self.build.write({file: each.text for file, each in switched.items()})
            said = self.build.compile(objects, self.at(0.5))
            if not said:
                return [each for each in chosen if each.key not in refused], numbers
            before = len(refused)
            for file, line, column in self.build.places_of_errors("\n".join(said)):
                refused |= {each.key for each in switched[file].to_blame(line, column)}
            (WORK / "compiler.log").write_text("\n".join(said))
            say(f"{len(refused) - before} mutations do not compile")
            if len(refused) == before:
                break
        raise Failed(f"The sources do not compile: see {WORK}/compiler.log")

    def record(self, highest):
        """Runs all tests once, without a mutation: which of them reaches what."""
        tests = []
        for suites, jobs in ((lambda suite: suite not in WAITING, self.asked.jobs),
                             (lambda suite: suite in WAITING - {"can"}, 6),
                             (lambda suite: suite == "can", self.asked.jobs)):
            shards = [(suite, shard) for suite in self.build.suites if suites(suite)
                      for shard in range(self.shards_of(suite))]
            with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
                recorded = pool.map(lambda each: self.record_shard(*each, highest), shards)
                tests += [test for each in recorded for test in each]
        return tests

    def shards_of(self, suite):
        return {"unit": 2, "sim": 2, "machine": 6, "can": 4, "loopback": 12}.get(suite, 1)

    def command(self, suite, seconds, environment, worker):
        """What runs the program of a suite: (words, environment)."""
        program = self.build.program_of_tests(suite)
        if suite != "can":
            return [str(program)], dict(os.environ, TMPDIR=self.temporary(), **environment)
        # A guest gets its environment by its command, and sees its folder of results as /lab.
        return ([str(OWN_ROOT / "tests/lab/run_uml"), str(self.guest(worker)), str(int(seconds)),
                 "/usr/bin/env",
                 *[f"{name}={value}" for name, value in environment.items()], str(program)],
                dict(os.environ))

    @staticmethod
    def guest(worker):
        return WORK / f"guest.{worker}"

    def record_shard(self, suite, shard, highest):
        folder = self.guest(shard) if suite == "can" else WORK
        folder.mkdir(exist_ok=True)
        file = folder / f"reached.{suite}.{shard}"
        file.write_bytes(bytes(highest + 1))
        lines = pathlib.Path(f"{file}.tests")
        lines.unlink(missing_ok=True)
        until = self.at(0.75)
        left = max(until - time.time(), 0.1) if until else None
        command, environment = self.command(suite, left or LONGEST_RECORD_S, {
            "TRIBUS_MUTATIONS_REACHED": f"/lab/{file.name}" if suite == "can" else str(file),
            "GTEST_TOTAL_SHARDS": str(self.shards_of(suite)), "GTEST_SHARD_INDEX": str(shard),
            "GTEST_FILTER": f"-{LEFT_OUT}"}, shard)
        with (WORK / f"{suite}.{shard}.log").open("w") as log:
            try:
                subprocess.run(command, cwd=self.build.build / "tests", env=environment, stdout=log,
                               stderr=subprocess.STDOUT, timeout=left)
            except subprocess.TimeoutExpired:
                say(f"No time for all {suite}_tests")
        tests = []
        if not lines.is_file():
            return tests
        for line in lines.read_text().splitlines():
            name, result, computed, took, *reached = line.split()
            if result == "failed":
                self.failed.append(name)
            if result == "passed":
                tests.append(Test(suite, name, int(took if suite in WAITING else computed),
                                  frozenset(int(number) for number in reached)))
        return tests

    def worker(self):
        """The number of this thread."""
        with self.lock:
            return self.workers.setdefault(threading.get_ident(), len(self.workers))

    def temporary(self):
        folder = WORK / "tmp"
        folder.mkdir(parents=True, exist_ok=True)
        return str(folder)

    def try_one(self, mutation, number, tests):
        """Runs the tests that reach it: the first ones of each suite, then the others."""
        begin = time.time()
        reaching = sorted((test for test in tests if number in test.reached),
                          key=lambda test: (len(test.reached), test.milliseconds))
        ran = 0
        for suite in self.build.suites:
            todo = [test for test in reaching if test.suite == suite]
            if suite in WAITING:
                todo = self.within(todo, MOST_WAITING_MS)
            begun = False
            while todo:
                now = todo if suite in WAITING and begun else self.some(todo)
                begun = True
                ran += len(now)
                todo = todo[len(now):]
                noticed = self.run(suite, now, number)
                if noticed and suite in WAITING and self.run(suite, now, 0):
                    noticed = ""
                if noticed:
                    return Result(mutation, noticed, ran, len(reaching), time.time() - begin)
        return Result(mutation, "", ran, len(reaching), time.time() - begin)

    @staticmethod
    def within(tests, milliseconds):
        """The first of these that take no longer together, but at least one."""
        total = 0
        for at, test in enumerate(tests):
            total += test.milliseconds
            if total > milliseconds and at > 0:
                return tests[:at]
        return tests

    def some(self, tests):
        """The first of these: few if they are quick, all others at once."""
        total = length = 0
        first = tests[0].suite
        for at, test in enumerate(tests):
            total += test.milliseconds
            length += len(test.name) + 1
            if (total > FIRST_TESTS_MS and at > 0 and len(tests) - at > 3 and
                    tests is not None and first != "property") or length > LONGEST_FILTER:
                return tests[:at]
        return tests

    def run(self, suite, tests, number):
        """The test that notices, or an empty text."""
        seconds = PATIENCE * sum(test.milliseconds for test in tests) / 1000 + LEAST_PATIENCE_S
        names = ":".join(test.name for test in tests)
        worker = self.worker()
        command, environment = self.command(
            suite, seconds, {"TRIBUS_MUTATION": str(number), "GTEST_FILTER": names,
                             "GTEST_FAIL_FAST": "1", "GTEST_COLOR": "no"}, worker)

        def limit():
            # A guest's memory is a large file.
            if suite != "can":
                resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
                resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
                resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        log = WORK / f"run.{worker}.log"
        with log.open("w+", errors="replace") as output:
            status, text = test_program.run(command, output, 4 * seconds,
                                            cwd=self.build.build / "tests", env=environment,
                                            preexec_fn=limit)
        if status == 0:
            return ""
        failed = test_program.failed_test(text) if status is not None else None
        return failed or f"{test_program.last_test(text) or 'the start'}, which does not end well"

    def try_all(self, chosen, numbers, tests):
        results = []
        todo = collections.deque(chosen)

        def work():
            while True:
                with self.lock:
                    if not todo or (self.until and time.time() > self.until):
                        return
                    mutation = todo.popleft()
                result = self.try_one(mutation, numbers[mutation.key], tests)
                with self.lock:
                    results.append(result)
                    self.tell(result, len(results), len(chosen))
        with concurrent.futures.ThreadPoolExecutor(self.asked.jobs) as pool:
            for worker in [pool.submit(work) for _ in range(self.asked.jobs)]:
                worker.result()
        return results

    def tell(self, result, number, of):
        mutation = result.mutation
        what = f"noticed by {result.noticed_by}" if result.noticed_by else \
            ("SURVIVED" if result.tests else "SURVIVED, no test reaches it")
        if self.asked.verbose or not result.noticed_by:
            say(f"{number}/{of} {mutation.file}:{mutation.line} {mutation.key} {mutation.kind}: "
                f"{what} ({result.ran} of {result.tests} tests, {result.seconds:.1f} s)")


def report(campaign, results, chosen, equivalent, left_out):
    survivors = [result for result in results if not result.noticed_by]
    for result in sorted(survivors, key=lambda each: (each.mutation.file, each.mutation.line)):
        mutation = result.mutation
        print(f"\n{mutation.file}:{mutation.line}  {mutation.key}  {mutation.kind}, "
              f"in {mutation.function}, " +
              (f"{result.tests} tests reach it, {result.ran} ran" if result.tests
               else "no test reaches it"))
        print(make.difference(campaign.texts[mutation.file], mutation)
              .encode("latin-1").decode(errors="replace"))
    (WORK / "results.json").write_text(json.dumps(
        [{"key": each.mutation.key, "file": each.mutation.file, "line": each.mutation.line,
          "kind": each.mutation.kind, "function": each.mutation.function,
          "noticed_by": each.noticed_by, "tests": each.tests} for each in results], indent=1))
    print(f"\n{len(results)} tried, {len(results) - len(survivors)} noticed, "
          f"{len(survivors)} survived; {equivalent} equivalent; "
          f"{len(chosen) - len(results)} left for want of time; {left_out} do not compile; "
          f"{campaign.fixed_numbers} numbers only the compiler sees")
    return survivors


def arguments():
    parser = argparse.ArgumentParser(prog="tests/mutation/run.sh", description=__doc__)
    parser.add_argument("--changed", metavar="BASE", help="lines that differ from this commit")
    parser.add_argument("--folder", action="append", default=[], help="or file")
    parser.add_argument("--count", type=int, help="a sample of so many")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--key", action="append", default=[], help="only this one, of the folder")
    parser.add_argument("--minutes", type=float, help="no mutation begins after that time")
    parser.add_argument("--suite", action="append", default=[], choices=ALL_SUITES,
                        help="only tests of this one; can in guests, loopback and can with the "
                        "programs mutated, too")
    parser.add_argument("--list", action="store_true", help="show them, run nothing")
    parser.add_argument("--verbose", action="store_true", help="say who noticed each")
    parser.add_argument("--build", default=str(OWN_ROOT / "build"), help="an up-to-date build")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    asked = parser.parse_args()
    if bool(asked.changed) == bool(asked.folder):
        parser.error("Say either --changed BASE or --folder FOLDER.")
    return asked


def main():
    asked = arguments()
    begin = time.time()
    WORK.mkdir(parents=True, exist_ok=True)
    campaign = Campaign(asked)
    found = campaign.find()
    say(f"{len(found)} mutations of {len(campaign.texts)} files, {time.time() - begin:.0f} s")
    chosen = campaign.choose(found)
    if asked.list:
        for mutation in chosen[:asked.count]:
            print(f"{mutation.file}:{mutation.line} {mutation.key} {mutation.kind} "
                  f"{mutation.function}")
            print(make.difference(campaign.texts[mutation.file], mutation))
        return 0
    if not chosen:
        return 0
    shutil.rmtree(WORK / "source", ignore_errors=True)
    shutil.rmtree(WORK / "include", ignore_errors=True)
    compiled, numbers = campaign.compile(chosen)
    left_out = len(chosen) - len(compiled)
    campaign.build.link()
    say(f"Built after {time.time() - begin:.0f} s")
    tests = campaign.record(len(chosen))
    say(f"{len(tests)} tests pass without a mutation, after {time.time() - begin:.0f} s")
    if campaign.failed:
        say(f"{len(campaign.failed)} fail without one, and can notice none: "
            f"{', '.join(campaign.failed[:9])}")
    compiled = compiled[:asked.count] if asked.count else compiled
    known = equivalent_keys()
    wanted = [mutation for mutation in compiled
              if mutation.key not in known or mutation.key in asked.key]
    built = [mutation for mutation in wanted if campaign.build.is_in_it(mutation.file)]
    results = campaign.try_all(built, numbers, tests)
    shutil.rmtree(WORK / "tmp", ignore_errors=True)
    survivors = report(campaign, results, wanted, len(compiled) - len(wanted), left_out)
    say(f"{(time.time() - begin) / 60:.1f} min")
    return 1 if survivors else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failed as failure:
        say(failure)
        sys.exit(2)
