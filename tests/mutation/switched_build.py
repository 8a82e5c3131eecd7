"""Builds programs of tests from an existing build, with other texts for some sources and headers.

Only what these texts are in is compiled again; all else is linked as the build has it.
"""

import collections
import concurrent.futures
import hashlib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
OWN_ROOT = HERE.parents[1]
INCLUDED = re.compile(r'^#include "(/[^"]*\.cpp)"$', re.MULTILINE)
PROGRAMS = ["tribus", "tribus-web", "tribus-mqtt"]
PLACE = re.compile(r"(/[^:\s]+):(\d+):(\d+):")


class Failed(Exception):
    """A compiler or the linker failed for a reason that no mutation has."""


class SwitchedBuild:
    def __init__(self, build, work, suites, jobs):
        self.build = pathlib.Path(build).resolve()
        home = re.search("^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$",
                         (self.build / "CMakeCache.txt").read_text(), re.MULTILINE)
        self.root = pathlib.Path(home[1])
        self.work = work
        self.jobs = jobs
        self.suites = suites
        self.with_programs = bool({"loopback", "can"} & set(suites))
        targets = [f"tests/{'lab/' if suite == 'can' else ''}{suite}_tests" for suite in suites]
        if self.with_programs:
            targets += [f"app/{program}" for program in PROGRAMS]
        self.commands = {}
        self.links = {}
        self.archive_of = {}
        for line in self.ninja("commands", *targets).splitlines():
            self.read_command(line)
        self.read_dependencies()
        self.read_arguments()

    def file_of(self, path):
        """Of the project: the path from its root; else None."""
        real = os.path.realpath(path)
        return os.path.relpath(real, self.root) if real.startswith(f"{self.root}/") else None

    def ninja(self, tool, *arguments):
        return subprocess.run(["ninja", "-C", self.build, "-t", tool, *arguments],
                              check=True, capture_output=True, text=True).stdout

    def read_command(self, line):
        """Keeps it if it compiles, archives or links."""
        archived = re.search(r"ar qc (\S+)\s+(.*?) && ", line)
        if archived:
            for part in archived[2].split():
                self.archive_of[part] = archived[1]
            return
        if line.startswith(": && "):
            words = shlex.split(line.removeprefix(": && ").split(" && ")[0])
            if "-o" in words:
                self.links[words[words.index("-o") + 1]] = words
            return
        if " -c " not in line:
            return
        words = shlex.split(line.split(" && ")[0])
        if words[0].endswith("ccache"):
            del words[0]
        if "-o" in words and "-c" in words:
            self.commands[words[words.index("-o") + 1]] = words

    def read_dependencies(self):
        self.needs = collections.defaultdict(set)
        known = {}
        made = None
        for line in self.ninja("deps").splitlines():
            if not line.startswith(" "):
                made = line.partition(":")[0]
                continue
            path = os.path.join(self.build, line.strip())
            if path not in known:
                known[path] = self.file_of(path)
            if known[path]:
                self.needs[made].add(known[path])
        for made, words in self.commands.items():
            self.needs[made].update(self.sources(words))
        # Who includes a precompiled header needs what is in it.
        for made, files in self.needs.items():
            for header in [file for file in files if file.endswith("cmake_pch.hxx.gch")]:
                own = os.path.relpath(self.root / header, self.build)
                if own != made:
                    files |= self.needs.get(own, set())

    def sources(self, words):
        """The sources that a command compiles: those of a joined file."""
        source = pathlib.Path(words[words.index("-c") + 1])
        if "/Unity/" not in str(source):
            return [self.file_of(source)] if self.file_of(source) else []
        return [self.file_of(path) for path in INCLUDED.findall(source.read_text())]

    def read_arguments(self):
        """For each file, what libclang needs for a source that includes it: (source, arguments)."""
        self.users = {}
        nearest = {}
        for made in sorted(self.commands):
            own = set(self.sources(self.commands[made]))
            for file in self.needs[made]:
                distance = (file not in own, -len(os.path.commonprefix([made, file])))
                if file not in nearest or distance < nearest[file][0]:
                    nearest[file] = distance, made
        for file, (_, made) in nearest.items():
            self.users[file] = made

    def arguments(self, made):
        words = self.commands[made]
        kept = []
        for at, word in enumerate(words):
            if word.startswith(("-I", "-D", "-std=")):
                kept.append(word)
            elif word == "-isystem":
                kept += [word, words[at + 1]]
        return kept

    def find(self, files):
        """What make.find needs for these files: (source, arguments, {path: file})."""
        users = collections.defaultdict(list)
        for file in files:
            if file in self.users:
                users[self.users[file]].append(file)
        return [(self.build / self.commands[made][self.commands[made].index("-c") + 1],
                 ["-x", "c++", "-w", *self.arguments(made)],
                 {os.path.realpath(self.root / file): file for file in of_one})
                for made, of_one in users.items()]

    def write(self, texts):
        """Writes these texts of files; returns the objects that have to be compiled."""
        self.texts = texts
        for file, text in texts.items():
            path = self.path_of(file)
            path.parent.mkdir(parents=True, exist_ok=True)
            data = text.encode("latin-1")
            if not path.is_file() or path.read_bytes() != data:
                path.write_bytes(data)
        return [made for made in self.commands
                if not made.endswith(".gch") and
                (self.names_the_program(made) or self.has_to_have(made))]

    def has_to_have(self, made):
        """Has a mutated source, or is of the layer of a mutated header.

        Sources elsewhere, such as tests, have the header as it was; but tests are not optimised, so
        they call its functions, which are those of `headers_alone`.
        """
        layer = made.partition("/")[0]
        return any(file in self.texts and (file.endswith(".cpp") or file.startswith(f"{layer}/"))
                   for file in self.needs[made])

    def headers_alone(self, headers):
        """Compiles all inline functions of these headers, called or not."""
        source = self.work / "joined/headers.cpp"
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text("".join(f'#include "{file}"\n' for file in headers))
        arguments = []
        for file in headers:
            arguments += [each for each in self.arguments(self.users[file])
                          if each not in arguments]
        words = ["c++", f"-I{self.work / 'include'}", *arguments, "-O0", "-fkeep-inline-functions",
                 "-ffunction-sections", "-fdata-sections", "-c", str(source),
                 "-o", str(self.work / "objects/headers.o"), *self.options()]
        return words, self.digest(words, headers)

    def options(self):
        return [f"-I{OWN_ROOT}", "-include", str(HERE / "switch.h"), "-w", "-Wno-narrowing",
                "-fdiagnostics-column-unit=byte"]

    def digest(self, words, files):
        texts = [self.texts[file] for file in sorted(files) if file in self.texts]
        return hashlib.sha256("\0".join([*words, *texts]).encode()).hexdigest()

    def names_the_program(self, made):
        return self.with_programs and made.startswith(("tests/CMakeFiles/loopback", "tests/lab/"))

    def path_of(self, file):
        return self.work / ("include" if file.endswith(".h") else "source") / file

    def command(self, made):
        """The command and what it compiles, as a text that tells when that has changed."""
        words = list(self.commands[made])
        source = words[words.index("-c") + 1]
        files = self.sources(words)
        if any(file in self.texts for file in files):
            text = pathlib.Path(source).read_text() if "/Unity/" in source else \
                f'#include "{source}"\n'
            for file in files:
                if file in self.texts:
                    text = text.replace(f'"{self.root / file}"', f'"{self.path_of(file)}"')
            source = self.work / "joined" / f"{made.replace('/', '_')}.cpp"
            source.parent.mkdir(parents=True, exist_ok=True)
            source.write_text(text)
        words[words.index("-c") + 1] = str(source)
        words[words.index("-o") + 1] = str(self.work / "objects" / made)
        has_header = "-include" in words
        if has_header:
            at = words.index("-include") + 1
            words[at] = self.precompiled(words[at])
        else:
            words = ["-O1" if word in ("-O2", "-O3", "-Os") else word for word in words]
        words[1:1] = [f"-I{self.work / 'include'}"]
        words += self.options()
        if self.with_programs:
            words += [f'-D{name}="{self.program(program)}"' for name, program in
                      (("TRIBUS_PROGRAM", "tribus"), ("TRIBUS_WEB", "tribus-web"),
                       ("TRIBUS_MQTT", "tribus-mqtt"))] if self.names_the_program(made) else []
        return words, self.digest(words, self.needs[made])

    def program(self, name):
        return self.work / "app" / name

    def program_of_tests(self, suite):
        return self.work / "tests" / f"{suite}_tests"

    def precompiled(self, header):
        """The precompiled header, with the texts that are in it."""
        made = os.path.relpath(header, self.build) + ".gch"
        files = sorted(self.needs[made] & set(self.texts))
        if not files:
            return header
        copy = self.work / "precompiled" / made.removesuffix(".gch")
        copy.parent.mkdir(parents=True, exist_ok=True)
        text = f'#include "{HERE / "switch.h"}"\n' + pathlib.Path(header).read_text()
        copy.write_text(text)
        words = list(self.commands[made])
        words[words.index("-o") + 1] = f"{copy}.gch"
        words[words.index("-include") + 1] = str(copy)
        words[1:1] = [f"-I{self.work / 'include'}"]
        words += ["-w", "-Wno-narrowing", "-fdiagnostics-column-unit=byte"]
        self.headers[str(copy)] = words, self.digest([*words, text], files)
        return str(copy)

    def compile_one(self, job):
        words, digest = job
        made = pathlib.Path(words[words.index("-o") + 1])
        stamp = pathlib.Path(f"{made}.stamp")
        if self.is_made(words, digest):
            return ""
        made.parent.mkdir(parents=True, exist_ok=True)
        stamp.unlink(missing_ok=True)
        left = self.until - time.time() if self.until else None
        if left is not None and left <= 0:
            return ""
        try:
            done = subprocess.run(words, cwd=self.build, capture_output=True, text=True,
                                  timeout=left, env=dict(os.environ, LC_ALL="C"))
        except subprocess.TimeoutExpired:
            return ""
        if done.returncode == 0:
            stamp.write_text(digest)
            return ""
        return done.stderr or "failed"

    def compile(self, made, until=None):
        """Compiles these objects; returns what the compilers said of errors.

        What is not compiled at that time stays as it was.
        """
        self.headers = {}
        self.until = until
        headers = sorted(file for file in self.texts if file.endswith(".h"))
        alone = [self.headers_alone(headers)] if headers else []
        jobs = {each: self.command(each) for each in made}
        own = [each for each in made if set(self.sources(self.commands[each])) & set(self.texts)]
        # What is wrong shows in the first ones.
        steps = [alone, [jobs[each] for each in own], list(self.headers.values()),
                 list(jobs.values())]
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            for step in steps:
                said = [each for each in pool.map(self.compile_one, step) if each]
                if said:
                    return said
        self.objects = {each: words[words.index("-o") + 1] for each, (words, digest) in jobs.items()
                        if self.is_made(words, digest)}
        self.alone_objects = [words[words.index("-o") + 1] for words, digest in alone
                              if self.is_made(words, digest)]
        return []

    def is_in_it(self, file):
        """Whether an object with the text of this file was compiled."""
        return (file.endswith(".h") and self.alone_objects != [] or
                any(file in self.needs[made] for made in self.objects))

    @staticmethod
    def is_made(words, digest):
        made = words[words.index("-o") + 1]
        stamp = pathlib.Path(f"{made}.stamp")
        return os.path.exists(made) and stamp.is_file() and stamp.read_text() == digest

    def places_of_errors(self, said):
        """(file, line, column) in our texts that errors complain of."""
        files = {str(self.path_of(file)): file for file in self.texts}
        places, before = set(), set()
        every = set()
        for line in said.splitlines():
            named = {(files[path], int(row), int(column))
                     for path, row, column in PLACE.findall(line) if path in files}
            every |= named
            if ": error: " not in line:
                before |= named
                continue
            places |= named or before
            before = set()
        return places or every

    def link(self):
        extra = []
        for name in ("switch", "reached_by_tests"):
            made = self.work / "objects" / f"{name}.o"
            made.parent.mkdir(parents=True, exist_ok=True)
            self.must_run(["c++", "-std=c++20", "-O1", f"-I{OWN_ROOT}", "-c", HERE / f"{name}.cpp",
                           "-o", made])
            extra.append(str(made))
        jobs = []
        for output, words in self.links.items():
            if output.endswith("_tests"):
                suite = pathlib.Path(output).name.removesuffix("_tests")
                jobs.append((words, self.program_of_tests(suite), extra))
            elif self.with_programs and pathlib.Path(output).name in PROGRAMS:
                jobs.append((words, self.program(pathlib.Path(output).name), extra[:1]))
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            for _ in pool.map(lambda job: self.link_one(*job), jobs):
                pass

    def link_one(self, words, output, extra):
        output.parent.mkdir(parents=True, exist_ok=True)
        own = [word for word in words if word in self.commands]
        archives = set(words)
        ours = [self.objects[made] for made in self.objects
                if self.archive_of.get(made) in archives and made not in own]
        words = [self.objects.get(word, word) for word in words]
        words[words.index("-o") + 1] = str(output)
        # The first definition counts.
        words[1:1] = [*extra, *self.alone_objects, *ours, "-Wl,-z,muldefs,--gc-sections"]
        self.must_run(words)

    def must_run(self, words):
        done = subprocess.run([str(word) for word in words], cwd=self.build, capture_output=True,
                              text=True)
        if done.returncode != 0:
            sys.stderr.write(done.stderr[:8000])
            raise Failed(f"{words[0]} failed")
