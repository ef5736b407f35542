"""`backbend why`: the ingredient that made a finding, over files and rigs."""

import copy
import json
import pathlib
import shutil
import tempfile

import glb
from harness import CommandTest, USAGE, human, run_backbend


class Why(CommandTest):
    def setUp(self):
        super().setUp()
        self.write("v1.glb", human(1500).read_bytes())
        self.sound = (self.folder / "v1.glb").read_bytes()

    def why(self, *words, code=1):
        return json.loads(self.assert_runs("why", *words, "--json", "-q", code=code).stdout)

    def test_weights_are_named_with_their_vertices_and_what_check_says_of_both(self):
        self.write("v2.glb", glb.with_strays(self.sound))
        told = self.why("v1.glb", "v2.glb")
        self.assertEqual((told["ingredients"], told["changed"], told["coverage"]), (["weights"], ["weights"], 1.0))
        report = json.loads(self.backbend("check", "v2.glb", "--quick", "--json", "-o", "run").stdout)
        failing = {f["code"]: f["value"] for f in report["findings"] if f["verdict"] == "fail"}
        self.assertEqual({f["code"] for f in told["findings"]}, set(failing))
        for finding in told["findings"]:
            self.assertEqual(finding["value"], failing[finding["code"]])
            self.assertTrue(finding["vertices"])
            self.assertIsNone(finding["was"])
        said = self.assert_runs("why", "v1.glb", "v2.glb", "-q", code=1).stdout
        self.assertRegex(said, r"made by weights of .* on \d+ vert")
        self.assertIn("with the old one: passes", said)

    def test_of_many_versions_the_first_bad_one_is_told_and_broken_ones_are_skipped(self):
        for n in range(2, 8):
            self.write(f"v{n}.glb", self.sound if n < 5 else glb.with_strays(self.sound))
        self.write("v4.glb", b"glTF")
        told = self.why(*(f"v{n}.glb" for n in range(1, 8)))
        self.assertEqual((told["first_bad"]["version"], told["first_bad"]["last_good"]), ("v5.glb", "v3.glb"))
        self.assertIn("v4.glb", " ".join(told["first_bad"]["skipped"]))
        self.assertLessEqual(told["first_bad"]["measurements"], 3)  # ceil(log2(7))

    def test_versions_that_are_alike_have_nothing_to_tell(self):
        self.write("v2.glb", self.sound)
        self.assertEqual(self.why("v1.glb", "v2.glb", code=0)["findings"], [])

    def test_an_option_of_a_rig_is_named(self):
        self.write("old.toml", '[rig]\nsystem = "curve"\nbones = 10\n')
        self.write("new.toml", '[rig]\nsystem = "curve"\nbones = 11\nlength = "rest"\nfollow = "on_curve"\n')
        told = self.why("old.toml", "new.toml", "--character", "v1.glb")
        self.assertEqual(told["ingredients"], ["options"])
        self.assertTrue(any(finding["options"] == ["length"] for finding in told["findings"]))

    def test_what_cannot_be_compared_is_refused(self):
        self.assert_refused("why", "v1.glb", code=USAGE, names=["two versions"])
        self.assert_refused("why", "v1.glb", "gone.glb", names=["gone.glb"])
        self.write("broken.glb", b"glTF")
        self.assert_refused("why", "v1.glb", "broken.glb", names=["broken.glb"])


class Runs(CommandTest):
    """Versions that are folders of earlier runs."""

    @classmethod
    def setUpClass(cls):
        """The two runs, of which each test has a copy: it may edit its own."""
        super().setUpClass()
        holder = tempfile.TemporaryDirectory(prefix="backbend why ")
        cls.addClassCleanup(holder.cleanup)
        cls.made = pathlib.Path(holder.name)
        sound = human(1500).read_bytes()
        for name, body in (("v1", sound), ("v2", glb.with_strays(sound))):
            (cls.made / f"{name}.glb").write_bytes(body)
            run_backbend(["check", f"{name}.glb", "--quick", "-o", f"runs/{name}"], cls.made)

    def setUp(self):
        super().setUp()
        shutil.copytree(self.made, self.folder, symlinks=True, dirs_exist_ok=True)

    def why(self, *words, code=1):
        return json.loads(self.assert_runs("why", *words, "--json", "-q", code=code).stdout)

    def test_two_runs_are_told_apart_as_their_files_are(self):
        runs, files = self.why("runs/v1", "runs/v2"), self.why("v1.glb", "v2.glb")
        self.assertEqual(runs["ingredients"], ["weights"])
        self.assertEqual(runs["findings"], files["findings"])
        self.assertEqual(self.why("runs/v1/report.json", "v2.glb")["findings"], files["findings"])

    def test_a_character_under_another_name_is_found_by_its_content(self):
        (self.folder / "kept").mkdir()
        (self.folder / "v1.glb").rename(self.folder / "kept/hero_old.glb")
        (self.folder / "v2.glb").rename(self.folder / "kept/hero.glb")
        told = self.why("runs/v1", "runs/v2", "--characters", "kept")
        self.assertEqual(told["ingredients"], ["weights"])
        self.assert_refused("why", "runs/v1", "runs/v2", names=["v1.glb", "--characters"])

    def edit_report(self, run, change):
        path = self.folder / "runs" / run / "report.json"
        report = json.loads(path.read_text())
        change(report)
        path.write_text(json.dumps(report))

    def as_of_the_sound_body(self, version=None):
        """v2's run, as an older program might have made it of the sound body: with one of its failures."""
        sound = json.loads((self.folder / "runs/v1/report.json").read_text())["characters"][0]

        def change(report):
            report["characters"][0].update(file=sound["file"], hash=sound["hash"])
            report["findings"] = [next(f for f in report["findings"] if f["verdict"] == "fail")]
            if version:
                report["provenance"]["backbend"] = version

        self.edit_report("v2", change)
        return json.loads((self.folder / "runs/v2/report.json").read_text())["findings"][0]

    def test_what_only_another_program_saw_is_the_programs(self):
        finding = self.as_of_the_sound_body()
        told = self.why("runs/v1", "runs/v2")
        self.assertEqual(told["ingredients"], ["program"])
        self.assertEqual([f["code"] for f in told["findings"]], [finding["code"]])
        self.assertIsNone(told["findings"][0]["without"])
        self.assertIn("another build of this version", told["differences"]["program"])
        said = self.assert_runs("why", "runs/v1", "runs/v2", "-q", code=1).stdout
        self.assertIn("made by program", said)
        self.assertIn("this program measures a pass", said)

    def test_the_program_that_measured_a_run_is_named_with_its_version(self):
        self.as_of_the_sound_body("0.0.9")
        self.assertIn("runs/v2: backbend 0.0.9 -> ", self.why("runs/v1", "runs/v2")["differences"]["program"])

    def test_a_waived_failure_is_one_still(self):
        def waived(report):
            for finding in report["findings"]:
                if finding["verdict"] == "fail":
                    finding["verdict"] = "waived"

        self.write("v3.glb", (self.folder / "v2.glb").read_bytes())
        self.backbend("check", "v3.glb", "--quick", "-o", "runs/v3")
        self.edit_report("v2", waived)
        self.assertEqual(self.why("runs/v2", "runs/v3", code=0)["findings"], [])

    def test_failures_of_other_sweeps_are_left_out_and_counted(self):
        def elsewhere(report):
            finding = copy.deepcopy(next(f for f in report["findings"] if f["verdict"] == "fail"))
            finding["sweep"] = "walk"
            report["findings"].append(finding)

        self.edit_report("v2", elsewhere)
        told = self.why("runs/v1", "runs/v2")
        self.assertIn("1 failure in other sweeps", " ".join(told["notes"]))
        self.assertEqual(told["findings"], self.why("v1.glb", "v2.glb")["findings"])

    def test_runs_that_were_judged_otherwise_are_refused(self):
        self.backbend("check", "v2.glb", "--quick", "--envelope", "creature", "-o", "runs/wide")
        self.assert_refused("why", "runs/v1", "runs/wide", names=["runs/wide", "envelope", "creature"])
        self.edit_report("v2", lambda report: [row.update(limit=30) for row in report["checks"] if row["code"] == "BB011"])
        self.assert_refused("why", "runs/v1", "runs/v2", names=["runs/v2", "limit 25 and 30 of BB011"])

    def test_a_spine_that_is_understood_otherwise_now_is_refused(self):
        self.edit_report("v1", lambda report: report["characters"][0]["spine"].pop())
        self.assert_refused("why", "runs/v1", "runs/v2", names=["its spine is now"])

    def test_of_a_run_of_several_characters_one_is_named(self):
        self.backbend("compare", "v1.glb", "v2.glb", "--quick", "--sweeps", "standard", "-o", "runs/both")
        self.assert_refused("why", "runs/both", "runs/both", names=["a run of 2 characters", "--character"])
        self.assert_refused("why", "runs/both", "runs/both", "--character", "v9.glb", names=["no character 'v9.glb'"])

    def test_a_run_that_cannot_be_used_is_refused(self):
        self.write("bad/report.json", "{}")
        self.assert_refused("why", "bad", "v1.glb", names=["bad"])
        self.assert_refused("why", "runs/none/report.json", "v1.glb", names=["runs/none"])
        self.assert_refused("why", "runs/v1", "v2.glb", "--rig", "curve", names=["runs/v1", "curve"])
