"""Locale, time zone, umask, closed streams and odd working folders change no byte of what is written."""

import itertools
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import harness
from harness import contents

LOCALES = ("C", "de_DE.UTF-8", "tr_TR.UTF-8", "C.UTF-8", "nonsense")
ZONES = ("UTC", "Asia/Kolkata", "America/St_Johns", ":/nowhere", "")
STREAMS = ((), (0,), (1,), (2,), (0, 1, 2))
MASKS = (0o022, 0o077, 0o000)

# A library may set the process's locale at any time; this one does so before main().
SETS_LOCALE = """
#include <locale.h>
#include <stdio.h>
__attribute__((constructor)) static void set(void) { setlocale(LC_ALL, ""); }
"""


class Surrounded:
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend-surroundings-")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        # A small body: what is tried is the surroundings.
        shutil.copy(harness.human(1500), cls.folder / "human.glb")
        # Private locales with a decimal comma and a dotless i, where the system's tools can make them.
        cls.locales = cls.folder / "locales"
        cls.locales.mkdir()
        if shutil.which("localedef"):
            for name in ("de_DE", "tr_TR"):
                subprocess.run(["localedef", "-i", name, "-f", "UTF-8", cls.locales / f"{name}.UTF-8"],
                               capture_output=True, check=False)

    def run_in(self, name, command, locale="C", zone="UTC", closed=(), mask=0o022, gone=False, preload=None):
        """Exit code, what was written and what was said, in surroundings of its own."""
        out = self.folder / name
        work = self.folder / f"{name} work"
        work.mkdir()

        def surround():
            os.umask(mask)
            if gone:
                os.rmdir(work)
            for stream in closed:
                os.close(stream)

        settings = harness.bare_environment(self.folder, LC_ALL=locale, LANG=locale, TZ=zone, LOCPATH=str(self.locales))
        if preload:
            settings["LD_PRELOAD"] = str(preload)
        done = subprocess.run(
            [str(harness.BACKBEND), *command, "-o", str(out)], cwd=work, preexec_fn=surround,
            stdin=subprocess.DEVNULL, capture_output=True, timeout=harness.PATIENCE_S, env=settings)
        return done.returncode, contents(out) if out.exists() else None, done.stderr

    def check(self):
        return ["check", str(self.folder / "human.glb"), "--quick", "--quiet"]


class ThirtySurroundings(Surrounded, unittest.TestCase):
    def test_a_measured_run_is_the_same_in_thirty_of_them(self):
        code, expected, told = self.run_in("plain", self.check())
        self.assertIn(code, (0, 1, 5), told)
        self.assertIn("report.json", expected)
        combinations = list(itertools.product(LOCALES, ZONES, STREAMS, MASKS, (False, True)))
        # Every value of every one of them comes up; steps prime to the counts mix them.
        seen = [set() for _ in range(5)]
        for i in range(30):
            chosen = combinations[i * 101 % len(combinations)]
            for values, value in zip(seen, chosen):
                values.add(value)
            locale, zone, closed, mask, gone = chosen
            with self.subTest(locale=locale, zone=zone, closed=closed, mask=oct(mask), gone=gone):
                code_here, found, told = self.run_in(f"run {i}", self.check(), locale, zone, closed, mask, gone)
                self.assertEqual(found, expected, told)
                # Whoever cannot be told the result is told by the exit code that something is wrong.
                self.assertIn(code_here, (code,) if 1 not in closed else (code, harness.CANNOT_WRITE, harness.RETRY),
                              told)
        self.assertEqual([len(values) for values in seen], [5, 5, 5, 3, 2])


class PicturesInSurroundings(Surrounded, unittest.TestCase):
    def test_a_picture_is_the_same_in_some_of_them(self):
        command = ["render", str(self.folder / "human.glb"), "--res", "32x32", "--spp", "1", "--quiet"]
        code, expected, told = self.run_in("picture", command)
        self.assertEqual(code, 0, told)
        self.assertTrue(any(name.endswith(".exr") for name in expected))
        for i, (locale, zone) in enumerate(zip(LOCALES[1:], ZONES[1:])):
            found = self.run_in(f"picture {i}", command, locale, zone, (0,), 0o077)
            self.assertEqual(found[:2], (code, expected), found[2])


class ALocaleThatIsSet(Surrounded, unittest.TestCase):
    """A decimal comma in the process itself, as after a library's setlocale(LC_ALL, "")."""

    def test_changes_no_number(self):
        if b"__asan_init" in pathlib.Path(harness.BACKBEND).read_bytes():
            self.skipTest("the program holds a sanitizer, which must be loaded first")
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None or not (self.locales / "de_DE.UTF-8/LC_NUMERIC").exists():
            self.skipTest("no C compiler, or no German locale can be made here")
        source, shim = self.folder / "locale.c", self.folder / "locale.so"
        source.write_text(SETS_LOCALE)
        subprocess.run([compiler, "-shared", "-fPIC", "-o", shim, source], check=True)
        point = subprocess.run(
            [sys.executable, "-c", "import locale; locale.setlocale(locale.LC_ALL, ''); "
             "print(locale.localeconv()['decimal_point'])"], stdout=subprocess.PIPE, text=True, check=True,
            env={**os.environ, "LC_ALL": "de_DE.UTF-8", "LOCPATH": str(self.locales)}).stdout.strip()
        self.assertEqual(point, ",", "the German locale is none")
        plain = self.run_in("english", self.check())
        german = self.run_in("german", self.check(), locale="de_DE.UTF-8", preload=shim)
        self.assertEqual(german[:2], plain[:2], german[2])
