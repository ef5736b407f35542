"""A very small night for tests of farms, faults and surroundings: two rigs and a canary on a body that
is made once, few poses, tiny pictures, everything else as in a real one."""

import pathlib
import shutil
import tempfile
import unittest

import harness

SMALL_PICTURES = """[pictures]
width = 48
height = 36
samples = 1
turntable_views = 3
sheet_columns = 2
"""

SUITE = """
[suite]
name = "tiny"
characters = ["human.glb"]
mappings = ["chest"]
envelope = "sweep"

[[rig]]
name = "curve"
role = "proposed"
solver = { system = "curve" }

[[rig]]
name = "isner"
role = "reference"
solver = { system = "isner" }

[[rig]]
name = "isner_flip"
role = "canary"
solver = { system = "isner" }
duty = { code = "BB001", sweep = "extension", mapping = "chest", joint = "top_vertebra", at_deg = 114.3, tolerance_deg = 0.3, twin = { system = "matrix_blend" } }

[[sweep]]
channel = "extension"
to = 120
step = 6

""" + SMALL_PICTURES


def prepare(folder):
    """Writes the suite and its character below `folder`; returns the suite's path."""
    scenes = pathlib.Path(folder) / "scenes"
    scenes.mkdir(parents=True)
    shutil.copy(harness.human(1500), scenes / "human.glb")
    (scenes / "tiny.toml").write_text(SUITE)
    return scenes / "tiny.toml"


def results(folder):
    """What a run is for: every file but the parts that farms work with."""
    return {name: what for name, what in harness.contents(pathlib.Path(folder)).items()
            if name.split("/")[0] not in ("parts", "farm")}


class NightTest(unittest.TestCase):
    """A night done by one process, to compare with."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend farm ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.suite = prepare(cls.folder)
        cls.whole = cls.nightly("whole")
        assert cls.whole.returncode == 1, cls.whole.stderr
        cls.expected = results(cls.folder / "whole")

    @classmethod
    def backbend(cls, *arguments, **options):
        return harness.run_backbend(arguments, cls.folder, **options)

    @classmethod
    def nightly(cls, run, *more, **options):
        return cls.backbend("nightly", cls.suite, "-o", cls.folder / run, *more, **options)

    def shard(self, run, share, *more):
        done = self.nightly(run, "--shard", share, *more)
        self.assertEqual(done.returncode, 0, done.stderr)

    def merge(self, *runs, code=1, output=None):
        done = self.backbend("merge", *[self.folder / run for run in runs],
                             *(["-o", self.folder / output] if output else []))
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def assert_whole(self, run):
        found = results(self.folder / run)
        self.assertEqual(sorted(found), sorted(self.expected))
        self.assertEqual([name for name in found if found[name] != self.expected[name]], [])
