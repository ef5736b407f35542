"""The publish gate (scenes/bridges/publish): refused on new or worse findings, never by a fault of ours.

Run with a stand-in for the documented part of Pyblish everywhere, and with Pyblish itself where BACKBEND_PYBLISH names
the folder that holds its package."""

import json
import os
import pathlib
import stat
import subprocess
import sys
import time
import unittest

import glb
from harness import BACKBEND, CommandTest, PATIENCE_S, SOURCE, bare_environment, human
from pyblish_stand_in import AYON, PUBLISH, STAND_IN

GATE = SOURCE / "scenes/bridges/publish/backbend_publish.py"
PYBLISH = os.environ.get("BACKBEND_PYBLISH", "")
POINTER = "version https://example.org/spec/v1\noid sha256:" + 64 * "a" + "\nsize 1234\n"


class Gate:
    """Characters, and programs that stand in for a backbend that does not do its work."""

    def setUp(self):
        super().setUp()
        self.home = self.folder / "home"
        self.home.mkdir()
        self.good = self.write("hero_v002.glb", human(1500).read_bytes())  # passes; with strays it fails BB062
        self.bad = self.write("bad/hero_v003.glb", glb.with_strays(self.good.read_bytes()))

    def program(self, text):
        path = self.write("programs/backbend", f"#!{sys.executable}\n{text}")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return path

    def broken_programs(self):
        """(what it is, a program, what the warning must say)."""
        return (("missing", self.folder / "no such program", "not installed"),
                ("crashing", "import os; os.kill(os.getpid(), 11)", "signal 11"),
                ("internal error", "import sys; sys.exit('hero.glb: internal error')", None),
                ("code 70", "import sys; print('lost', file=sys.stderr); sys.exit(70)", "internal error; its last line: lost"),
                ("disk full", "import sys; sys.exit(75)", "ran out of room"),
                ("silent failure", "import sys; sys.exit(1)", "no report"),
                ("silent success", "pass", "no report"),
                ("nonsense", "import sys, pathlib; f = pathlib.Path(sys.argv[sys.argv.index('-o') + 1]); "
                             "(f / 'report.json').write_text('{'); sys.exit(1)", "no report"),
                ("contradiction", "import sys, pathlib; f = pathlib.Path(sys.argv[sys.argv.index('-o') + 1]); "
                                  "(f / 'report.json').write_text('{\"schema\": \"backbend.report/1\", \"exit_code\": 1}')",
                 "says otherwise"))

    def baseline_of(self, character):
        """A baseline that approves all that is wrong with a character, and how many findings that are."""
        (self.folder / "baseline.json").unlink(missing_ok=True)
        self.backbend("check", character, "--quick", "-o", "approved")
        self.assert_runs("approve", "--run", "approved", "--baseline", "baseline.json", "--reason", "seen", "--author", "ann")
        return self.folder / "baseline.json"


class PublishTest:
    """Through Pyblish's own functions; `packages` is the folder that holds Pyblish."""

    def packages(self):
        raise NotImplementedError

    def publish(self, job, **environment):
        (self.folder / "published").unlink(missing_ok=True)
        told = subprocess.run([sys.executable, "-B", self.write("publish.py", PUBLISH), json.dumps(job)], cwd=self.folder,
                              env=bare_environment(self.home, PYTHONPATH=str(self.packages()), PYBLISHPLUGINPATH=str(GATE.parent),
                                                   BACKBEND_PUBLISH_PROGRAM=str(BACKBEND), BACKBEND_PUBLISH_OPTIONS="--quick",
                                                   BACKBEND_PUBLISH_OUTPUT=str(self.folder / "runs"), **environment),
                              capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(told.returncode, 0, told.stderr)
        said = json.loads(told.stdout.splitlines()[-1])
        said["published"] = (self.folder / "published").is_file()
        return said

    def test_a_good_rig_is_published(self):
        said = self.publish({"instance": {"files": [str(self.good), "notes.txt"]}})
        self.assertEqual((said["errors"], said["warnings"], said["published"]), ([], [], True), said)
        self.assertEqual(said["outcomes"], ["pass"])

    def test_a_bad_rig_is_refused_with_what_to_do_and_links(self):
        said = self.publish({"instance": {"backbend": {"character": str(self.bad), "options": ["--res", "48x36", "--spp", "1"]}}})
        self.assertFalse(said["published"])
        (error,) = said["errors"]
        lines = error.splitlines()
        self.assertRegex(lines[0], r"^hero_v003\.glb: \d+ findings? over a limit$")
        found = [line for line in lines if line.startswith("  BB")]
        self.assertTrue(any(line.startswith(("  BB062", "  BB064")) for line in found), error)
        for line in found:
            self.assertRegex(line, r"(WEIGHTS|INPUT|SKELETON|POSE): .{8,}$")
        self.assertIn("run backbend repair", error)
        page = pathlib.Path(lines[-1].replace("page: ", ""))
        self.assertTrue(page.is_file())
        pictures = [pathlib.Path(line.split("picture: ")[1]) for line in lines if "picture: " in line]
        for picture in pictures:
            self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")

    def test_what_was_approved_is_published_and_what_is_new_is_not(self):
        old = self.write("hero_v001.glb", self.bad.read_bytes())
        baseline = str(self.baseline_of(old))
        said = self.publish({"instance": {"backbend": {"character": str(self.bad), "baseline": baseline}}})  # another version
        self.assertEqual((said["errors"], said["published"]), ([], True))
        self.baseline_of(self.good)  # approves nothing
        said = self.publish({"instance": {"backbend": {"character": str(self.bad), "baseline": baseline}}})
        self.assertIn("new or worse", said["errors"][0])
        self.assertFalse(said["published"])

    def test_faults_of_ours_are_warnings_that_say_so(self):
        for what, program, says in self.broken_programs():
            with self.subTest(what):
                path = program if isinstance(program, pathlib.Path) else self.program(program)
                said = self.publish({"instance": {"backbend": {"character": str(self.bad), "program": str(path)}}})
                if says is None:  # exit code 1 with a line, and no report
                    says = "internal error"
                self.assertEqual((said["errors"], said["published"], said["outcomes"]), ([], True, ["not_judged"]), said)
                (warning,) = said["warnings"]
                self.assertIn(says, warning)
                self.assertIn("was not judged", warning)

    def test_a_slow_one_is_ended_with_what_it_started(self):
        marker = self.folder / "grandchild"
        late = f"import time, pathlib; time.sleep(6); pathlib.Path({str(marker)!r}).touch()"
        path = self.program(f"import subprocess, sys, time\nsubprocess.Popen([sys.executable, '-c', {late!r}])\ntime.sleep(600)")
        begun = time.monotonic()
        said = self.publish({"instance": {"backbend": {"character": str(self.bad), "program": str(path), "time_limit": 1.5}}})
        self.assertEqual((said["errors"], said["published"]), ([], True))
        self.assertIn("did not finish within 1.5 s", said["warnings"][0])
        time.sleep(max(0.0, 9 - (time.monotonic() - begun)))
        self.assertFalse(marker.exists())

    def test_a_file_that_is_not_a_character_is_refused_by_what_is_wrong_with_it(self):
        self.bad.write_text(POINTER)
        said = self.publish({"instance": {"backbend": str(self.bad)}})
        self.assertIn("is a Git LFS pointer; run git lfs pull", said["errors"][0])
        self.assertFalse(said["published"])
        said = self.publish({"instance": {"backbend": {"character": str(self.bad), "unreadable": "warn"}}})
        self.assertEqual((said["errors"], said["published"]), ([], True))

    def test_what_only_the_extractors_write_is_judged_before_it_is_integrated(self):
        representation = {"stagingDir": str(self.bad.parent), "files": self.bad.name, "name": "glb"}
        said = self.publish({"instance": {}, "extracted": {"representations": [representation]}})
        self.assertFalse(said["published"])
        self.assertIn("over a limit", said["errors"][0])
        said = self.publish({"instance": {}})  # and nothing at all: said
        self.assertTrue(said["published"])
        self.assertIn("was not judged", said["warnings"][0])

    def test_instances_of_other_families_are_left_alone(self):
        said = self.publish({"family": "camera", "instance": {"files": [str(self.bad)]}})
        self.assertEqual((said["errors"], said["warnings"], said["outcomes"], said["published"]), ([], [], [None], True))

    def test_an_open_scene_without_instances_is_one(self):
        said = self.publish({"context": {"currentFile": str(self.bad)}})
        self.assertFalse(said["published"])
        self.assertIn("over a limit", said["errors"][0])


class WithAStandIn(PublishTest, Gate, CommandTest):
    def packages(self):
        for name, text in STAND_IN.items():
            self.write("packages/pyblish/" + name, text)
        return self.folder / "packages"

    def test_ayon_gets_its_own_exception_with_markdown(self):
        self.write("packages/ayon_core/__init__.py", "")
        self.write("packages/ayon_core/pipeline/__init__.py", "")
        self.write("packages/ayon_core/pipeline/publish/__init__.py", AYON)
        said = self.publish({"instance": {"backbend": str(self.bad)}})
        self.assertEqual((said["kinds"], said["published"]), (["PublishValidationError"], False))
        told = json.loads(said["errors"][0])
        self.assertIn("over a limit", told["message"])
        self.assertRegex(told["description"], r"\[Page with all findings\]\(<file://.*index\.html>\)")
        said = self.publish({"instance": {"backbend": str(self.bad), "active": False}})  # switched off by the artist
        self.assertEqual((said["errors"], said["published"]), ([], True))


@unittest.skipUnless(PYBLISH, "BACKBEND_PYBLISH does not name a folder with Pyblish")
class WithPyblish(PublishTest, Gate, CommandTest):
    def packages(self):
        return pathlib.Path(PYBLISH)


class AsAHook(Gate, CommandTest):
    def hook(self, *words, program=BACKBEND):
        return subprocess.run([sys.executable, "-B", GATE, *map(str, words)], cwd=self.folder, capture_output=True, text=True,
                              env=bare_environment(self.home, BACKBEND_PUBLISH_PROGRAM=str(program)), timeout=PATIENCE_S)

    def test_exit_codes_are_those_of_a_hook(self):
        for words, code, says in ((["--quick", self.good, "notes.txt"], 0, ""), (["--quick", self.bad], 1, "refused: hero_v003.glb"),
                                  (["--quick", self.good, self.bad], 1, "refused"), (["notes.txt"], 0, ""), ([], 2, "usage")):
            with self.subTest(words=words):
                told = self.hook(*words)
                self.assertEqual(told.returncode, code, told.stdout + told.stderr)
                self.assertIn(says, told.stderr)

    def test_a_pointer_of_git_lfs_is_named(self):
        pointer = self.write("pointer.glb", POINTER)
        told = self.hook("--quick", pointer)
        self.assertEqual(told.returncode, 1)
        self.assertIn("pointer.glb: is a Git LFS pointer; run git lfs pull", told.stderr)

    def test_faults_of_ours_let_a_commit_pass_unless_it_is_strict(self):
        for what, program, _ in self.broken_programs():
            with self.subTest(what):
                path = program if isinstance(program, pathlib.Path) else self.program(program)
                told = self.hook(self.bad, program=path)
                self.assertEqual(told.returncode, 0, told.stderr)
                self.assertIn("warning: ", told.stderr)
                self.assertEqual(self.hook("--strict", self.bad, program=path).returncode, 1)

    def test_a_line_a_finding_says_what_to_do(self):
        lines = self.hook("--quick", self.bad).stderr.splitlines()
        found = [line for line in lines if line.startswith("  BB")]
        self.assertTrue(found)
        for line in found:
            self.assertRegex(line, r"^  BB\d{3} [a-z].*(WEIGHTS|INPUT|SKELETON|POSE|SOLVER|RIG): \S")


class Pointers(CommandTest):
    """Git LFS leaves a text in place of a file that was not fetched."""

    def test_every_input_says_what_it_is(self):
        pointer = self.write("hero.glb", POINTER)
        clip = self.write("hero.clip", POINTER)
        scene = self.write("hero.blend", POINTER)
        body = self.write("tube.glb", glb.tube())
        for words in (["check", pointer], ["inspect", pointer], ["repair", pointer, "--dry-run"], ["check", body, "--baked", clip],
                      ["check", body, "--rig", f"blender:{scene}", "--chest", "neck"], ["check", body, "--baseline", clip]):
            with self.subTest(words=words):
                self.assert_refused(*words, "--quiet", names=["is a Git LFS pointer; run git lfs pull"])


if __name__ == "__main__":
    unittest.main()
