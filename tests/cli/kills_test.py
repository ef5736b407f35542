"""kill -9 at random instants, and at every call that changes a file: every file is whole or absent, and the run
that takes up what is left ends with the bytes of one that nobody stopped. BACKBEND_KILLS says how many at random
[5], BACKBEND_KILL_STEP at which of the calls [every 40th]; docs/batteries.md has the last long runs."""

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
from failing_calls_test import FaultTest
from harness import contents, run_backbend
from night import SMALL_PICTURES, results

KILLS = int(os.environ.get("BACKBEND_KILLS", "5"))
KILL_STEP = int(os.environ.get("BACKBEND_KILL_STEP", "40"))

SUITE = """[suite]
name = "short"
characters = ["human.glb"]
mappings = ["chest"]
envelope = "sweep"

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
        shutil.copy(harness.human(1500), cls.folder / "human.glb")
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
                                      env=harness.bare_environment(self.folder),
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


SMALLEST = """[suite]
name = "smallest"
characters = ["human.glb"]
mappings = ["chest"]
envelope = "sweep"

[[rig]]
solver = { system = "curve" }

[[sweep]]
channel = "extension"
to = 6
step = 6

[hunt]
percent = 0

""" + SMALL_PICTURES


class KilledAtEveryCall(FaultTest, unittest.TestCase):
    """The smallest night with pictures. What is on the disk changes only by calls that create, write, flush, close,
    name or remove: killed at any other system call it is what the next of these finds."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        shutil.copy(harness.human(1500), cls.folder / "human.glb")
        (cls.folder / "smallest.toml").write_text(SMALLEST)
        cls.out = cls.folder / "out"
        done = run_backbend(cls.command(), cls.folder)
        assert done.returncode in (0, 1, 5), done.stderr
        cls.code, cls.expected = done.returncode, results(cls.out)
        assert any(name.endswith(".exr") for name in cls.expected), cls.expected
        assert any(name.endswith(".mp4") for name in cls.expected), cls.expected

    @classmethod
    def command(cls):
        return ["nightly", "smallest.toml", "-o", cls.out, "--quiet"]

    def killed(self, at):
        return self.failing(self.command(), self.out, "any", -1, at, "backbend")

    def test_what_is_left_is_whole_and_is_taken_up(self):
        (self.folder / "count").unlink(missing_ok=True)
        shutil.rmtree(self.out)
        self.killed(0)
        calls = int((self.folder / "count").read_text())
        self.assertGreater(calls, 100, "the shim sees no calls")
        for at in range(1, calls + 1, KILL_STEP):
            with self.subTest(at=at, calls=calls):
                shutil.rmtree(self.out, ignore_errors=True)
                self.assertEqual(self.killed(at).returncode, -signal.SIGKILL)
                for name, what in results(self.out).items() if self.out.exists() else ():
                    if ".tmp-" not in name:  # never got its name
                        self.assertEqual(what, self.expected.get(name), name)
                again = run_backbend([*self.command(), "--resume"], self.folder)
                self.assertEqual(again.returncode, self.code, again.stderr)
                self.assertEqual(results(self.out), self.expected)
                self.assertEqual([name for name in contents(self.out) if ".tmp-" in name], [])

    def test_a_finished_run_is_written_again_over_itself(self):
        # Here every file is old or new, and both are the same bytes; nothing may go missing on the way.
        run_backbend(self.command(), self.folder)
        for at in range(1 + KILL_STEP // 2, 10 ** 6, 4 * KILL_STEP):
            done = self.killed(at)
            with self.subTest(at=at):
                for name, what in results(self.out).items():
                    if ".tmp-" not in name:
                        self.assertEqual(what, self.expected.get(name), name)
                self.assertLessEqual(set(self.expected), set(results(self.out)))
            if done.returncode != -signal.SIGKILL:
                break
        self.assertEqual(done.returncode, self.code, done.stderr)
