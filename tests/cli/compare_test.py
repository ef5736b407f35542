"""backbend compare: rigs, characters, clips and run folders, pose by pose."""

import json
import shutil

from harness import BAD_INPUT, USAGE, CommandTest, human

HUMAN = human(1500)
FAST = ("--quick", "--sweeps", "standard")
# Rigs on a small body: the bundled one is made anew by each command that names no character.
ON_HUMAN = ("--character", HUMAN)


class Comparing(CommandTest):
    def compared(self, *words, code=None):
        result = self.backbend("compare", *words, "-o", "out")
        if code is not None:
            self.assertEqual(result.returncode, code, result.stderr)
        return json.loads((self.folder / "out/report.json").read_text())["comparisons"], result

    def test_a_rig_with_itself_is_a_draw(self):
        (one,), result = self.compared("even", "even", *ON_HUMAN, *FAST)
        self.assertEqual((one["a_better"], one["b_better"], one["mixed"], one["ahead"]), (0, 0, 0, ""))
        self.assertEqual(one["same"], one["paired"])
        self.assertEqual(one["unpaired"], 0)
        self.assertEqual((one["worst_of_a"], one["worst_of_b"]), ([], []))
        self.assertIn("a draw", result.stdout)

    def test_its_last_line_is_who_is_ahead_and_what_each_side_is_short_of(self):
        _, result = self.compared("even", "isner", *FAST)  # on the bundled human
        last = " ".join(result.stdout.rstrip().split("\n\n")[-1].split())
        self.assertRegex(last, r"^even is ahead of isner: over a limit in \d+ of \d+ poses, isner in \d+\.")
        self.assertIn("isner is short of", last)
        self.assertNotIn("PASS", result.stdout)

    def test_isner_loses_on_backbends_all_over_pose_space(self):
        (one,), result = self.compared("even", "isner", *ON_HUMAN, "--quick")
        self.assertEqual(one["ahead"], "a")
        self.assertGreater(one["b_over"], 2 * one["a_over"])
        # The map: five twists by five side bends, each over the whole extension.
        grid = [sweep for sweep in one["sweeps"] if sweep["sweep"].startswith("grid ")]
        self.assertEqual(len(grid), 25)
        self.assertTrue(all(len(sweep["marks"]) == len(sweep["control_deg"]) == 11 for sweep in grid))
        self.assertIn("twist -90", result.stdout)

    def test_frames_show_what_speaks_against_each_side(self):
        (one,), _ = self.compared("even", "isner", *ON_HUMAN, "--sweeps", "standard", "--res", "64x48", "--spp", "1")
        self.assertTrue(one["worst_of_b"])
        for pose in one["worst_of_a"] + one["worst_of_b"]:
            for key in ("a_path", "b_path"):
                self.assertTrue((self.folder / "out" / pose[key]).is_file(), pose)
            self.assertIn("--rig even", pose["a_command"])
            self.assertIn("--rig isner", pose["b_command"])

    def test_two_bodies_are_matched_by_their_surface(self):
        (self.folder / "new").mkdir()
        for path in ("v1.glb", "new/v1.glb"):
            shutil.copy(HUMAN, self.folder / path)
        (one,), result = self.compared("v1.glb", "new/v1.glb", *FAST)
        self.assertEqual(one["matched"], 1)
        self.assertEqual((one["a"], one["b"]), ("new/v1.glb", "v1.glb"))
        self.assertEqual((one["ahead"], one["same"]), ("", one["paired"]))
        report = json.loads((self.folder / "out/report.json").read_text())
        self.assertEqual([rig["role"] for rig in report["rigs"]], ["reference", "proposed"])
        self.assertEqual(len({rig["character"] for rig in report["rigs"]}), 2)

    def test_runs_are_compared_without_rendering_or_writing(self):
        for name, rig in (("before", "even"), ("after", "isner")):
            self.backbend("check", HUMAN, "--rig", f"{rig}", "--quick", "-o", name)
            path = self.folder / name / "report.json"
            path.write_text(path.read_text().replace(f'"{rig}"', '"spine"'))
        before = sorted(self.folder.iterdir())
        worse = self.backbend("compare", "before", "after")
        self.assertEqual(worse.returncode, 1, worse.stderr)
        self.assertIn("before is ahead", worse.stdout)
        better = self.backbend("compare", "after", "before/report.json", "--json")
        self.assertEqual(better.returncode, 0, better.stderr)
        (one,) = json.loads(better.stdout)["comparisons"]
        self.assertEqual(one["ahead"], "a")
        self.assertEqual(sorted(self.folder.iterdir()), before)

    def test_clips_are_compared_frame_by_frame(self):
        for rig in ("even", "isner"):
            self.backbend("bake", HUMAN, "--rig", rig, "--sweep", "extension", "-o", rig + ".glb")
        (one,), result = self.compared("even.glb", "isner.glb", "--baked")
        self.assertEqual((one["a"], one["b"]), ("isner.glb", "even.glb"))
        self.assertGreater(one["paired"], 10)
        self.assertEqual(one["ahead"], "b")
        (same,), _ = self.compared("even.glb", "even.glb", "--baked")
        self.assertEqual((same["ahead"], same["same"]), ("", same["paired"]))

    def test_two_kinds_and_what_is_not_there_are_refused(self):
        shutil.copy(HUMAN, self.folder / "v1.glb")
        self.assert_refused("compare", "even", "v1.glb", code=USAGE, names=["even", "v1.glb"])
        self.assert_refused("compare", "v1.glb", "gone.glb", code=BAD_INPUT, names=["gone.glb"])
        self.assert_refused("compare", "gone", "even", code=BAD_INPUT, names=["gone"])
        (self.folder / "empty").mkdir()
        self.assert_refused("compare", "empty", "empty", code=BAD_INPUT, names=["empty"])
