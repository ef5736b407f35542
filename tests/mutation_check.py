#!/usr/bin/env python3
"""Breaks the code on purpose, one small fault at a time, and counts how many of them the tests notice.

    tests/mutation_check.py solver --count 40 --seed 1
    tests/mutation_check.py metrics --only validate/metrics/chain/flip.cpp

Faults are a seeded sample of all places in a layer's sources (solver, skin, or metrics: validate/metrics) where one of
the operators below applies. The broken file is compiled in a build folder of its own (-O1, with its assertions and the
standard library's), linked before the layer's library into the layer's test program, and the tests are run until one
fails: those of the file's own name and those that noticed a fault in it before, then the quick ones, then the others.
The next fault is compiled meanwhile. No source is touched. A fault that does not compile, or that makes the same object code, counts for nothing.
Suites that take minutes are run only for the files whose own they are, and real characters are left out: they could
only notice more. With --whole, what none of these noticed is tried on every suite of the layer's program and of
validate_tests, with real characters: minutes each. Tests that take several times as long as without a fault count as
failed.

A survivor is a hole in the tests, or changes nothing that anybody could see: the latter stand with the reason in
mutation_exceptions.txt and count for nothing. Ends with 1 where fewer than nine in ten were noticed.
"""

import argparse
import concurrent.futures
import fnmatch
import json
import os
import pathlib
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[1]
EXCEPTIONS = pathlib.Path(__file__).with_name("mutation_exceptions.txt")
LAYERS = {"solver": ("solver", "solver_tests"), "skin": ("skin", "skin_tests"),
          "metrics": ("validate/metrics", "validate_tests")}
# Suites that take minutes, or that ask about whole runs: run only for the files whose own they are.
SLOW = {"solver": ("PropertyTable*",),
        "skin": ("BundledBody*", "BodyProxy*", "SharedCharacters*"),
        "metrics": ("Nightly*", "Calibrate*", "Waivers*", "Pictures*", "Check.*", "Limits*", "HostileNames*", "LookingAtIsner*")}


def swap(one, other):
    """Two operators: each becomes the other. Binary ones stand between spaces, as clang-format sets them."""
    return [(re.compile(re.escape(a)), lambda _, b=b: b, f"{a.strip()} to {b.strip()}")
            for a, b in ((one, other), (other, one))]


def plus(step):
    def changed(match):
        text = match.group()
        return repr(float(text) + step) if "." in text else str(int(text) + step)
    return changed


NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.'])")
OPERATORS = [
    *swap(" < ", " >= "), *swap(" > ", " <= "), *swap(" == ", " != "),
    (re.compile(" < "), lambda _: " <= ", "< to <="), (re.compile(" > "), lambda _: " >= ", "> to >="),
    (re.compile(" <= "), lambda _: " < ", "<= to <"), (re.compile(" >= "), lambda _: " > ", ">= to >"),
    *swap(" + ", " - "), *swap(" * ", " / "), *swap(" += ", " -= "), *swap(" *= ", " /= "), *swap(" && ", " || "),
    (NUMBER, plus(1), "constant + 1"), (NUMBER, plus(-1), "constant - 1"),
    (re.compile(r"(?<=[(\[{])-(?=[\w(])|(?<=[,=?:] )-(?=[\w(])|(?<=return )-(?=[\w(])"), lambda _: "", "sign dropped"),
    (re.compile(r"\bmax(?=\()"), lambda _: "min", "max to min"), (re.compile(r"\bmin(?=\()"), lambda _: "max", "min to max"),
    (re.compile(r"\bsin(?=\()"), lambda _: "cos", "sin to cos"), (re.compile(r"\bcos(?=\()"), lambda _: "sin", "cos to sin"),
    (re.compile(r"(?<=\w)\.x\b"), lambda _: ".y", "x to y"), (re.compile(r"(?<=\w)\.y\b"), lambda _: ".z", "y to z"),
    (re.compile(r"(?<=\w)\.z\b"), lambda _: ".x", "z to x"),
    (re.compile(r"\b(?:glm::normalize|glm::conjugate|std::abs)(?=\()"), lambda _: "", "normalize, conjugate or abs dropped"),
]
# A statement of one line: an assignment, a call, a jump. Declarations have a type before the name and do not match.
STATEMENT = re.compile(r"^\s+(?:[\w.:\[\]()>*-]+(?: [-+*/|&]?= .*| ?[+-]{2})|[\w.:>-]+\(.*\)|continue|break|[+-]{2}\w+);$")


def code_lines(text):
    """Number, code and whether a statement begins there, of lines that hold code: no comment, include or words."""
    begins = True
    for number, line in enumerate(text.split("\n")):
        code = line.split("//")[0].rstrip()
        stripped = code.strip()
        if not stripped:
            continue
        if not stripped.startswith(("#", "using ", "namespace ", "assert(", "static_assert(")) and '"' not in code:
            yield number, code, begins
        begins = stripped.endswith((";", "{", "}", ":"))


def negated(code):
    """`if (a) ...` with its condition turned round; None where it does not end on this line."""
    match = re.search(r"\bif \(", code)
    if not match:
        return None
    depth, at = 1, match.end()
    while at < len(code) and depth:
        depth += {"(": 1, ")": -1}.get(code[at], 0)
        at += 1
    condition = code[match.end():at - 1]
    return None if depth or ";" in condition else f"{code[:match.end()]}!({condition}){code[at - 1:]}"


def faults_of(file, text):
    """Every fault that could be made: (file, line number, what, the line as it would be)."""
    for number, code, begins in code_lines(text):
        for pattern, change, what in OPERATORS:
            for match in pattern.finditer(code):
                yield file, number, what, code[:match.start()] + change(match) + code[match.end():]
        turned = negated(code)
        if turned:
            yield file, number, "condition negated", turned
        if begins and STATEMENT.match(code):
            yield file, number, "statement dropped", re.match(r"\s*", code).group() + ";"


class Program:
    """The layer's test program, whole and with one object replaced."""

    def __init__(self, build, name, jobs):
        self.build = build
        if not (build / "build.ninja").exists():
            # Each file by itself, since one of them is replaced.
            subprocess.run(["cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            "-DBACKBEND_UNITY=OFF"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ninja", "-C", build, f"-j{jobs}", name], check=True, stdout=subprocess.DEVNULL)
        self.compile = {each["file"]: shlex.split(each["command"])
                        for each in json.loads((build / "compile_commands.json").read_text())}
        told = subprocess.check_output(["ninja", "-C", build, "-t", "commands", "-s", f"tests/{name}"], text=True)
        # CMake writes `: && LINKER ... && :`, and after it the discovery of the tests, which is not wanted here.
        link = re.search(r"^: && (.*? -o tests/" + name + r" .*?)(?= && )", told, re.M).group(1)
        self.link = shlex.split(link)
        # Folders beside that of the tests, which look for other programs from where they stand.
        self.name = name
        self.folders = [build / f"{name}_fault_{side}" for side in (0, 1, 2)]
        for folder in self.folders:
            folder.mkdir(exist_ok=True)
        self.whole = self.folders[0] / "whole"
        shutil.copy(build / "tests" / name, self.whole)
        self.same = {}

    def compiled(self, file, text, folder):
        """The object of `text` in the place of `file`; None where it does not compile."""
        made = folder / (file.stem + ".o")
        (folder / file.name).write_text(text)
        words = [word for word in self.compile[str(file)] if word not in ("-O3", "-DNDEBUG")]
        if os.path.basename(words[0]) == "ccache":
            words = words[1:]
        words[words.index("-o") + 1] = made.name
        words[words.index("-c") + 1] = file.name  # without its folder: like code makes like bytes
        # The standard library's assertions see what goes past the end of an array.
        words += ["-O1", "-w", "-D_GLIBCXX_ASSERTIONS"]
        return made if subprocess.run(words, cwd=folder, capture_output=True).returncode == 0 else None

    def differs(self, file, text, folder):
        """Whether the object with the fault in the folder is another than without it."""
        if file not in self.same:
            self.same[file] = self.compiled(file, text, self.folders[2]).read_bytes()
        return (folder / (file.stem + ".o")).read_bytes() != self.same[file]

    def with_fault(self, file, text, number, line, folder):
        """The program with the fault; None where it does not compile or link."""
        lines = text.split("\n")
        lines[number] = line
        made = self.compiled(file, "\n".join(lines), folder)
        return self.linked(made, folder) if made else None

    def without_fault(self, file, text):
        """The program with the file compiled as a broken one is."""
        return self.linked(self.compiled(file, text, self.folders[2]), self.folders[2])

    def linked(self, made, folder):
        program = folder / self.name
        words = list(self.link)
        at = words.index("-o")
        words[at + 1] = str(program)
        words.insert(at, str(made))  # before the library, whose own object is then not asked for
        # A fault in what says where a template is made leaves others without it.
        return program if subprocess.run(words, cwd=self.build, capture_output=True).returncode == 0 else None


class Suites:
    """The program's test suites, without those of SLOW, with the time that each takes without a fault."""

    def __init__(self, program, slow, limit):
        self.program, self.slow, self.limit = program, slow, limit
        told = program.folders[0] / "times.json"
        begun = time.monotonic()
        done = self.run(program.whole, f"-{self.pattern(slow)}", limit, f"--gtest_output=json:{told}")
        if done is None or done.returncode != 0:
            sys.exit("the tests fail, or take too long, without any fault")
        self.seconds = {}
        for each in json.loads(told.read_text())["testsuites"]:
            seconds = float(each["time"].rstrip("s"))
            self.seconds[each["name"]] = seconds
            if "/" in each["name"]:  # with parameters: as its test calls it, too
                bare = each["name"].split("/")[-1]
                self.seconds[bare] = self.seconds.get(bare, 0.0) + seconds
        self.whole = time.monotonic() - begun

    @staticmethod
    def pattern(names):
        return ":".join(pattern for each in sorted(names) for pattern in (each, f"*/{each}"))

    def run(self, binary, wanted, limit, *more, characters=False):
        """Seconds of processor time: other work on the machine makes no fault."""
        environment = os.environ if characters else {**os.environ, "BACKBEND_CHARACTERS": "/nonexistent"}
        try:
            return subprocess.run(["prlimit", f"--cpu={round(limit)}", binary, "--gtest_brief=1", f"--gtest_filter={wanted}", *more],
                                  capture_output=True, text=True, errors="replace", cwd=self.program.build,
                                  timeout=max(300, 5 * limit), env=environment)
        except subprocess.TimeoutExpired:
            return None

    def noticed(self, binary, names):
        """Which of these suites fails first; None: none; "crash": the program; "time": they take much longer than they should."""
        if not names:
            return None
        wanted = self.pattern(name if "*" in name else name + ".*" for name in names)
        usual = sum(self.seconds.get(name, self.limit) for name in names)
        return self.failed(self.run(binary, wanted, 20 + min(5 * usual, self.limit), "--gtest_fail_fast"))

    @staticmethod
    def failed(done):
        if done is None or done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            return "time"
        if done.returncode == 0:
            return None
        failed = re.search(r"^\[  FAILED  \] ([\w/]+)\.", done.stdout, re.M)
        return failed.group(1) if failed else "crash"


class Whole:
    """All suites, with real characters, of the layer's program and of the one that joins the layers."""

    def __init__(self, suites, joined, limit):
        self.suites, self.joined, self.limit = suites, joined, limit
        for program in {suites.program, joined}:
            begun = time.monotonic()
            if self.ends(program.whole) is not None:
                sys.exit(f"{program.name} fails, or takes too long, without any fault")
            print(f"all of {program.name} take {time.monotonic() - begun:.0f} s", flush=True)

    def ends(self, binary):
        return self.suites.failed(self.suites.run(binary, "*", self.limit, "--gtest_fail_fast", characters=True))

    def noticed(self, binary, made):
        """As Suites.noticed, of a program with a fault and of the object that has it."""
        found = self.ends(binary)
        if not found and self.joined is not self.suites.program:
            found = self.ends(self.joined.linked(made, binary.parent))
        return found


def own_suites(folder, file):
    """The suites of the tests that bear the file's name, and those that bear its first word."""
    tests = SOURCE / "tests" / folder.split("/")[0]

    def suites(found):
        return {name for test in found for name in re.findall(r"^TEST(?:_F|_P)?\((\w+),", test.read_text(), re.M)}

    return suites(tests.rglob(f"{file.stem}_test.cpp")), suites(tests.rglob(f"{file.stem.split('_')[0]}*_test.cpp"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("layer", choices=LAYERS)
    parser.add_argument("--count", type=int, default=40, help="faults that compile and change something [40]")
    parser.add_argument("--seed", type=int, default=1, help="of the sample [1]")
    parser.add_argument("--only", default="", help="files whose path holds this")
    parser.add_argument("--whole", action="store_true", help="try what the quick tests let pass on all of them, with real characters")
    parser.add_argument("--jobs", type=int, default=2, help="of the first build [2]")
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/mutants")
    parser.add_argument("--seconds", type=float, default=900, help="of processor time that tests may take without a fault [900]")
    parser.add_argument("--minutes", type=float, default=1e9, help="after which no other fault is begun")
    options = parser.parse_args()
    folder, name = LAYERS[options.layer]
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))  # a fault may ask for memory without end
    program = Program(options.build.resolve(), name, options.jobs)
    listed = set()
    if EXCEPTIONS.exists():
        for line in EXCEPTIONS.read_text().splitlines():
            if line.strip() and not line.startswith("#"):
                listed.add(tuple(part.strip() for part in line.split(" :: ")[:2]))
    suites = Suites(program, SLOW[options.layer], options.seconds)
    whole = None
    if options.whole:
        joined = program if name == "validate_tests" else Program(program.build, "validate_tests", options.jobs)
        whole = Whole(suites, joined, options.seconds)
    print(f"the tests take {suites.whole:.1f} s without a fault", flush=True)
    quick = {suite for suite, seconds in suites.seconds.items() if seconds < max(0.5, 0.01 * suites.whole)}

    def slow(names):
        return {name for name in names if any(fnmatch.fnmatch(name, pattern.removesuffix(".*")) for pattern in SLOW[options.layer])}

    texts = {file: file.read_text() for file in sorted((SOURCE / folder).rglob("*.cpp"))
             if options.only in str(file) and str(file) in program.compile}
    faults = [fault for file, text in texts.items() for fault in faults_of(file, text)]
    random.Random(options.seed).shuffle(faults)
    begun = time.monotonic()
    excepted = 0

    def planted():
        """Every fault that compiles, with its program. Two folders, for one is in use while the other is made."""
        nonlocal excepted
        made = 0
        for file, number, what, line in faults:
            if (str(file.relative_to(SOURCE)), line.strip()) in listed:
                excepted += 1
                continue
            binary = program.with_fault(file, texts[file], number, line, program.folders[made % 2])
            if binary is not None:
                made += 1
                yield file, number, what, line, binary

    killed, survivors, seen_by, sound = 0, [], {}, set()
    with concurrent.futures.ThreadPoolExecutor(1) as worker:
        source = planted()
        ahead = worker.submit(next, source, None)
        while killed + len(survivors) < options.count and time.monotonic() - begun < 60 * options.minutes:
            fault = ahead.result()
            if fault is None:
                break
            ahead = worker.submit(next, source, None)
            file, number, what, line, binary = fault
            own, near = own_suites(folder, file)
            first = (own | near) - slow(own | near) | seen_by.setdefault(file, set())
            noticed = (suites.noticed(binary, first) or suites.noticed(binary, quick - first)
                       or suites.noticed(binary, suites.seconds.keys() - quick - first)
                       or suites.noticed(binary, slow(own)))
            place = str(file.relative_to(SOURCE))
            if not noticed and not program.differs(file, texts[file], binary.parent):
                continue
            if whole and not noticed:
                noticed = whole.noticed(binary, binary.parent / (file.stem + ".o"))
            if noticed == "crash" and file not in sound:
                if suites.noticed(program.without_fault(file, texts[file]), first | quick):
                    sys.exit(f"{place} fails its assertions, or the tests, without any fault")
                sound.add(file)
            if noticed:
                killed += 1
                if noticed in suites.seconds:
                    seen_by[file].add(noticed)
            else:
                survivors.append(place)
            print(f"{'killed   ' if noticed else 'SURVIVED '} {place}:{number + 1} :: {what} :: "
                  f"{texts[file].splitlines()[number].strip()}"
                  + ("" if what in ("condition negated", "statement dropped") else f"  =>  {line.strip()}")
                  + (f"  [{noticed}]" if noticed else ""), flush=True)
    tried = killed + len(survivors)
    print(f"{options.layer}: {killed} of {tried} noticed ({100 * killed / max(tried, 1):.0f} %), {excepted} listed as seen by nobody; "
          f"{len(faults)} places, seed {options.seed}")
    return 0 if tried and killed >= 0.9 * tried else 1


if __name__ == "__main__":
    sys.exit(main())
