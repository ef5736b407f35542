"""kill -9 at random instants: every file is whole or absent, and the run that takes up what is left ends with
the bytes of one that nobody stopped. BACKBEND_KILLS says how many [5]; docs/batteries.md has the last long run."""

import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import harness
from harness import run_backbend
from night import results

KILLS = int(os.environ.get("BACKBEND_KILLS", "5"))

SUITE = """[suite]
name = "short"
characters = ["human.glb"]
mappings = ["chest"]

[[rig]]
solver = { system = "even" }

[[rig]]
solver = { system = "curve" }
role = "reference"

[[sweep]]
channel = "extension"
to = 60
step = 20

[pictures]
width = 64
height = 48
samples = 1
sheet_columns = 2
"""


class KilledAtRandom(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend kills ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        made = run_backbend(["body", "-o", "human.glb", "--vertices", "2000"], cls.folder)
        assert made.returncode == 0, made.stderr
        (cls.folder / "short.toml").write_text(SUITE)
        started = time.monotonic()
        done = run_backbend(cls.command("whole"), cls.folder)
        cls.seconds = time.monotonic() - started
        assert done.returncode in (0, 1, 5), done.stderr
        cls.code, cls.expected = done.returncode, results(cls.folder / "whole")
        assert any(name.endswith(".exr") for name in cls.expected), cls.expected

    @staticmethod
    def command(out, *more):
        return ["nightly", "short.toml", "-o", out, "--quiet", *more]

    def test_what_is_left_is_whole_and_is_taken_up(self):
        draw = random.Random(1)
        hit = 0
        for number in range(KILLS):
            after_s = draw.uniform(0.0, self.seconds)
            with self.subTest(number=number, after_s=round(after_s, 3)):
                out = self.folder / "out"
                shutil.rmtree(out, ignore_errors=True)
                with subprocess.Popen([str(harness.BACKBEND), *self.command("out")], cwd=self.folder,
                                      env={"PATH": os.environ["PATH"], "HOME": str(self.folder)},
                                      stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                      stderr=subprocess.DEVNULL) as run:
                    try:
                        run.wait(after_s)
                    except subprocess.TimeoutExpired:
                        run.send_signal(signal.SIGKILL)
                    hit += run.wait() == -signal.SIGKILL
                for name, what in results(out).items() if out.exists() else ():
                    if ".tmp-" not in name:  # never got its name
                        self.assertEqual(what, self.expected.get(name), name)
                again = run_backbend(self.command("out", "--resume"), self.folder)
                self.assertEqual(again.returncode, self.code, again.stderr)
                self.assertEqual(results(out), self.expected)
        self.assertGreater(hit, 0, "no kill came before the end")
