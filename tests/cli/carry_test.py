"""What did not change since an earlier night is not measured again: same bytes but for the marks, and nothing damaged
is believed."""

import json
import pathlib
import shutil
import tempfile
import unittest

import harness
from harness import contents

SUITE = """[suite]
name = "two"
characters = ["one.glb", "two.glb"]
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
[[sweep]]
channel = "extension"
to = 60
step = 12
"""
PICTURES = """[pictures]
width = 48
height = 36
samples = 1
turntable_views = 3
sheet_columns = 2
"""
FAULTS = """[calibration]
poses = 4
faults = 2
"""
CARRIED = "carried over from the night "


class Nights:
    """A first night of two characters, made once, that each test goes on from in a copy."""

    text = SUITE
    options = ("--quick",)

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend carry ")
        cls.addClassCleanup(holder.cleanup)
        cls.first = pathlib.Path(holder.name) / "first"
        scenes = cls.first / "scenes"
        scenes.mkdir(parents=True)
        for name, vertices in (("one", 1500), ("two", 2500)):
            shutil.copy(harness.human(vertices), scenes / f"{name}.glb")
        (scenes / "two.toml").write_text(cls.text)
        done = cls.night_in(cls.first, "monday")
        assert done.returncode in (0, 1), done.stderr

    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="backbend carry ")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name) / "show"
        shutil.copytree(self.first, self.folder)

    @classmethod
    def night_in(cls, folder, run, *more):
        return harness.run_backbend(["nightly", "scenes/two.toml", "-o", folder / "runs" / run, "--history",
                                     "runs/history.jsonl", *cls.options, *more], folder)

    def night(self, run, *more):
        done = self.night_in(self.folder, run, *more)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done

    def carried(self, run):
        report = json.loads((self.folder / "runs" / run / "report.json").read_text())
        marks = {name.removeprefix("carried ") for name in report["provenance"] if name.startswith("carried ")}
        notes = {c["name"] for c in report["characters"] if any(CARRIED in note for note in c["notes"])}
        self.assertEqual(notes, marks - {"planted faults"})
        self.assertEqual(bool(notes), any("carried over" in reason for reason in report["reasons"]))
        return marks

    def unmarked(self, run):
        """The run's files, the report without its marks."""
        folder = self.folder / "runs" / run
        report = json.loads((folder / "report.json").read_text())
        report["provenance"] = {k: v for k, v in report["provenance"].items() if not k.startswith("carried ")}
        for character in report["characters"]:
            character["notes"] = [note for note in character["notes"] if CARRIED not in note]
        for lines in ("reasons", "detectors"):
            report[lines] = [line for line in report[lines] if "carried over" not in line]
        # Those that are made of the report have the marks, too.
        files = {name: what for name, what in contents(folder).items()
                 if name not in ("report.json", "index.html", "junit.xml", "report.md")}
        return report, files

    def assert_as_fresh(self, run, carried):
        """Another night of the same inputs and history, all measured, finds the same."""
        self.assertEqual(self.carried(run), set(carried))
        history = self.folder / "runs/history.jsonl"
        lines = history.read_text().splitlines(keepends=True)
        history.write_text("".join(lines[:-1]))
        self.night(f"{run} fresh", "--fresh")
        self.assertEqual(self.carried(f"{run} fresh"), set())
        found, expected = self.unmarked(run), self.unmarked(f"{run} fresh")
        self.assertEqual(found[0], expected[0])
        self.assertEqual(found[1], expected[1])


class CarryingOver(Nights, unittest.TestCase):
    def test_a_night_without_a_change_is_the_first_one_again(self):
        self.assertEqual(self.carried("monday"), set())
        told = self.night("tuesday")
        self.assertIn("2 of 2 characters carried over", told.stdout)
        page = (self.folder / "runs/tuesday/index.html").read_text()
        self.assertIn(CARRIED, page)
        self.assert_as_fresh("tuesday", ["one", "two"])
        self.night("wednesday")  # from what the fresh one left
        self.assertEqual(self.carried("wednesday"), {"one", "two"})
        self.night("thursday")   # and on from a night that was carried itself
        self.assertEqual(self.carried("thursday"), {"one", "two"})

    def test_only_the_character_that_changed_is_measured(self):
        with (self.folder / "scenes/two.glb").open("ab") as file:
            file.write(b"\0\0\0\0")
        self.night("tuesday")
        self.assert_as_fresh("tuesday", ["one"])

    def test_a_character_that_is_gone_is_an_entry_as_ever(self):
        (self.folder / "scenes/two.glb").unlink()
        done = self.night_in(self.folder, "tuesday")
        self.assertIn("two.glb", done.stderr)
        report = json.loads((self.folder / "runs/tuesday/report.json").read_text())
        self.assertIn("BB051", {finding["code"] for finding in report["findings"]}, done.stderr)
        self.assertEqual(self.carried("tuesday"), {"one"})

    def test_a_sidecar_that_comes_changes_its_character(self):
        saved = harness.run_backbend(["inspect", "scenes/one.glb", "--save"], self.folder)
        self.assertEqual(saved.returncode, 0, saved.stderr)
        self.night("tuesday")
        self.assert_as_fresh("tuesday", ["two"])

    def test_what_the_suite_says_of_rigs_sweeps_and_limits_changes_all(self):
        suite = self.folder / "scenes/two.toml"
        for run, old, new in (("rig", '"curve" }', '"curve", bones = 12 }'), ("sweep", "step = 12", "step = 10"),
                              ("limit", "[[sweep]]", '[[limit]]\ncode = "BB020"\nvalue = 3.0\nowner = "a lead"\n'
                                                     'reason = "a test"\n[[sweep]]')):
            suite.write_text(SUITE.replace(old, new))
            self.night(run)
            self.assertEqual(self.carried(run), set(), run)
        suite.write_text(SUITE)
        self.night("option", "--spp", "2")
        self.assertEqual(self.carried("option"), set())

    def test_what_the_suite_says_of_others_changes_nothing(self):
        suite = self.folder / "scenes/two.toml"
        suite.write_text(SUITE.replace('"one.glb", "two.glb"', '"two.glb"').replace('name = "two"', 'name = "two"\ntitle = "T"'))
        self.night("tuesday")
        self.assert_as_fresh("tuesday", ["two"])

    def test_nothing_damaged_is_believed(self):
        (first, second) = sorted((self.folder / "runs/carried").iterdir())
        report = self.folder / "runs/monday/report.json"

        def damage(path, what):
            """What Tuesday carries over after the damage; then all is as on Monday."""
            what(path, path.read_bytes())
            self.night("tuesday")
            carried = self.carried("tuesday")
            shutil.rmtree(self.folder)
            shutil.copytree(self.first, self.folder)
            return carried

        cut = lambda path, whole: path.write_bytes(whole[:-100])
        turned = lambda path, whole: path.write_bytes(whole.replace(b"headroom", b"headrooM", 1))
        swapped = lambda path, whole: path.write_bytes(second.read_bytes())
        empty = lambda path, whole: path.write_bytes(b"")
        for what in (cut, turned, empty):
            self.assertEqual(len(damage(first, what)), 1)
        self.assertEqual(len(damage(first, swapped)), 1)
        self.assertEqual(damage(report, cut), set())
        self.assertEqual(damage(report, lambda path, whole: path.unlink()), set())
        self.assertEqual(damage(self.folder / "runs/history.jsonl", empty), set())

    def test_what_is_damaged_is_told_and_measured_again(self):
        for entry in (self.folder / "runs/carried").iterdir():
            entry.write_bytes(entry.read_bytes()[:-100])
        told = self.night("tuesday")
        self.assertEqual(told.stderr.count("is not as it was written: measured again"), 2, told.stderr)
        self.assert_as_fresh("tuesday", [])

    def test_nights_that_belong_to_no_history_keep_nothing(self):
        done = harness.run_backbend(["nightly", "scenes/two.toml", "-o", "alone/run", "--quick"], self.folder)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertFalse((self.folder / "alone/carried").exists())


class CarryingPictures(Nights, unittest.TestCase):
    text = SUITE + PICTURES + FAULTS
    options = ()

    def test_pictures_come_along_and_the_planted_faults_are_not_tried_again(self):
        self.night("tuesday")
        pictures = [path for path in (self.folder / "runs/monday").rglob("*.png") if path.parent.name != "monday"]
        self.assertGreater(len(pictures), 10)
        for path in pictures:
            again = self.folder / "runs/tuesday" / path.relative_to(self.folder / "runs/monday")
            self.assertEqual(again.read_bytes(), path.read_bytes())
        # Monday's may go; Tuesday has its own.
        shutil.rmtree(self.folder / "runs/monday")
        self.night("wednesday")
        self.assert_as_fresh("wednesday", ["one", "two", "planted faults"])

    def test_a_picture_that_was_changed_is_made_again(self):
        picture = min((self.folder / "runs/monday/review").rglob("one_*/*.png"))
        picture.write_bytes(picture.read_bytes()[:-20])
        told = self.night("tuesday")
        self.assertIn(f"{picture.relative_to(self.folder / 'runs/monday')} has changed since", told.stderr)
        self.assert_as_fresh("tuesday", ["two", "planted faults"])
