#!/usr/bin/env python3
"""Breaks the code on purpose, one small fault at a time, and counts how many of them the tests notice.

    tests/mutation_check.py solver --count 40 --seed 1
    tests/mutation_check.py metrics --only validate/metrics/flip.cpp

Faults are a seeded sample of all places in a layer's sources (solver, skin, or metrics: validate/metrics) where one of
the operators below applies. The broken file is compiled in a build folder of its own (-O1), linked before the layer's
library into the layer's test program, and the tests are run until one fails: those of the file's own name first. No
source is touched. A fault that does not compile, or that makes the same object code, counts for nothing. Suites that
take minutes are run only for the files whose own they are, unless --slow; those and real characters, which are left
out, could only notice more.

A survivor is a hole in the tests, or changes nothing that anybody could see: the latter stand with the reason in
mutation_exceptions.txt and count for nothing. Ends with 1 where fewer than nine in ten were noticed.
"""

import argparse
import json
import os
import pathlib
import random
import re
import shlex
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[1]
EXCEPTIONS = pathlib.Path(__file__).with_name("mutation_exceptions.txt")
LAYERS = {"solver": ("solver", "solver_tests"), "skin": ("skin", "skin_tests"),
          "metrics": ("validate/metrics", "validate_tests")}
# Suites that take minutes: run only for the files whose own they are.
SLOW = {"solver": ("PropertyTable.*", "Even.*"),
        "skin": ("BundledBody*", "BodyProxy*", "SharedCharacters*", "Body*"),
        "metrics": ("Nightly*", "Calibrat*", "Artist*", "ProxyWeights*", "Run*", "Waivers*", "Import*", "Systems*", "Selftest*",
                    "Judge*", "Sample*")}


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


def faults_of(file):
    """Every fault that could be made: (file, line number, what, the line as it would be)."""
    for number, code, begins in code_lines(file.read_text()):
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
        self.build, self.path = build, build / "tests" / name
        if not (build / "build.ninja").exists():
            subprocess.run(["cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DBACKBEND_WERROR=OFF"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ninja", "-C", build, f"-j{jobs}", name], check=True, stdout=subprocess.DEVNULL)
        self.compile = {each["file"]: shlex.split(each["command"])
                        for each in json.loads((build / "compile_commands.json").read_text())}
        told = subprocess.check_output(["ninja", "-C", build, "-t", "commands", "-s", f"tests/{name}"], text=True)
        # CMake writes `: && LINKER ... && :`, and after it the discovery of the tests, which is not wanted here.
        link = re.search(r"^: && (.*? -o tests/" + name + r" .*?)(?= && )", told, re.M).group(1)
        self.link = shlex.split(link)

    def objects(self, file, text):
        """The object of `text` in the place of `file`; None where it does not compile."""
        broken = self.build / "mutant" / file.name
        broken.parent.mkdir(exist_ok=True)
        broken.write_text(text)
        made = broken.with_suffix(".o")
        words = list(self.compile[str(file)])
        if os.path.basename(words[0]) == "ccache":
            words = words[1:]
        words[words.index("-o") + 1] = str(made)
        words[words.index("-c") + 1] = str(broken)
        # Broken or not, the source has the same name here, so that like code makes like bytes.
        done = subprocess.run([*words, "-w"], cwd=self.build, capture_output=True)
        return made if done.returncode == 0 else None

    def with_object(self, made):
        program = self.build / "mutant" / "tests"
        words = list(self.link)
        at = words.index("-o")
        words[at + 1] = str(program)
        words.insert(at, str(made))  # before the library, whose own object is then not asked for
        subprocess.run(words, cwd=self.build, check=True, capture_output=True)
        return program


def own_suites(folder, file):
    """A filter for the suites of the tests that bear the file's name, or its first word; empty: there is none."""
    tests = SOURCE / "tests" / folder.split("/")[0]
    names = set()
    for test in [tests / f"{file.stem}_test.cpp", *tests.glob(f"{file.stem.split('_')[0]}*_test.cpp")]:
        if test.exists():
            names |= set(re.findall(r"^TEST(?:_F|_P)?\((\w+),", test.read_text(), re.M))
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("layer", choices=LAYERS)
    parser.add_argument("--count", type=int, default=40, help="faults that compile and change something [40]")
    parser.add_argument("--seed", type=int, default=1, help="of the sample [1]")
    parser.add_argument("--only", default="", help="files whose path holds this")
    parser.add_argument("--slow", action="store_true", help="try what the others let pass on the slow suites, too")
    parser.add_argument("--jobs", type=int, default=2, help="of the first build [2]")
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/mutants")
    parser.add_argument("--seconds", type=float, default=120, help="after which tests that hang count as failed [120]")
    parser.add_argument("--minutes", type=float, default=1e9, help="after which no other fault is begun")
    options = parser.parse_args()
    folder, name = LAYERS[options.layer]
    program = Program(options.build.resolve(), name, options.jobs)
    listed = set()
    if EXCEPTIONS.exists():
        for line in EXCEPTIONS.read_text().splitlines():
            if line.strip() and not line.startswith("#"):
                listed.add(tuple(part.strip() for part in line.split(" :: ")[:2]))

    def passes(binary, names, but=()):
        wanted = ":".join(pattern for each in sorted(names) for pattern in (f"{each}.*", f"*/{each}.*")) or "*"
        unwanted = ":".join(pattern for each in but for pattern in (each, "*/" + each))
        try:
            return subprocess.run([binary, "--gtest_brief=1", "--gtest_fail_fast", f"--gtest_filter={wanted}-{unwanted}"],
                                  capture_output=True, cwd=program.build, timeout=options.seconds,
                                  env={**os.environ, "BACKBEND_CHARACTERS": "/nonexistent"}).returncode == 0
        except subprocess.TimeoutExpired:
            return False

    slow = SLOW[options.layer]
    begun = time.monotonic()
    if not passes(program.path, (), slow):
        parser.exit(3, "the tests fail, or take too long, without any fault\n")
    print(f"the tests take {time.monotonic() - begun:.1f} s without a fault", flush=True)
    faults = [fault for file in sorted((SOURCE / folder).rglob("*.cpp")) if options.only in str(file) and str(file) in program.compile
              for fault in faults_of(file)]
    random.Random(options.seed).shuffle(faults)
    same, killed, survivors, excepted = {}, 0, [], 0
    for file, number, what, line in faults:
        if killed + len(survivors) >= options.count or time.monotonic() - begun > 60 * options.minutes:
            break
        text = file.read_text()
        if file not in same:
            same[file] = program.objects(file, text).read_bytes()
        lines = text.split("\n")
        before, lines[number] = lines[number].strip(), line
        place = str(file.relative_to(SOURCE))
        if (place, line.strip()) in listed:
            excepted += 1
            continue
        made = program.objects(file, "\n".join(lines))
        if made is None or made.read_bytes() == same[file]:
            continue
        binary = program.with_object(made)
        own = own_suites(folder, file)
        noticed = (bool(own) and not passes(binary, own)) or not passes(binary, (), slow)
        if options.slow and not noticed:
            noticed = not passes(binary, [suite.rstrip(".*") for suite in slow])
        killed += noticed
        if not noticed:
            survivors.append(place)
        print(f"{'killed   ' if noticed else 'SURVIVED '} {place}:{number + 1} :: {what} :: {before}"
              + ("" if what in ("condition negated", "statement dropped") else f"  =>  {line.strip()}"), flush=True)
    tried = killed + len(survivors)
    print(f"{options.layer}: {killed} of {tried} noticed ({100 * killed / max(tried, 1):.0f} %), {excepted} listed as seen by nobody; "
          f"{len(faults)} places, seed {options.seed}")
    return 0 if tried and killed >= 0.9 * tried else 1


if __name__ == "__main__":
    sys.exit(main())
