"""backbend diff: two pictures or two folders, its verdicts, exit codes and JSON."""

import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from harness import CommandTest, human, run_backbend

DIFFERENT, INCOMPLETE, NOTHING = 1, 4, 5


class Diffing(CommandTest):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend diff ")
        cls.addClassCleanup(holder.cleanup)
        cls.made = pathlib.Path(holder.name)
        for name, more in (("rest", ()), ("seed", ("--seed", "7")), ("bent", ("--pose", "extension=20"))):
            result = run_backbend(["render", human(), "--rig", "even", "--res", "96x72", "--spp", "16", "--aovs", "all",
                                   "--mode", "clay", "--name", "frame", "-o", name, *more], cls.made)
            assert result.returncode == 0, result.stderr
        cls.picture = {name: next((cls.made / name).rglob("*.exr")) for name in ("rest", "seed", "bent")}

    def told(self, a, b, code, *more):
        """The JSON; `code` None: whether they are alike is not asked."""
        if code is None:
            return json.loads(self.backbend("diff", a, b, "--json", *more).stdout)
        return json.loads(self.assert_runs("diff", a, b, "--json", *more, code=code).stdout)

    def measures(self, a, b, code):
        picture, = self.told(a, b, code)["pictures"]
        return {row["name"]: row for row in picture["measures"]}, picture

    def test_a_picture_is_the_same_as_itself(self):
        rows, picture = self.measures(self.picture["rest"], self.picture["rest"], 0)
        self.assertTrue(picture["identical"])
        self.assertEqual(rows["perceptual_hdr_mean"]["value"], 0)

    def test_another_seed_differs_by_noise_only(self):
        rows, picture = self.measures(self.picture["rest"], self.picture["seed"], 0)
        self.assertFalse(picture["identical"])
        self.assertEqual(rows["within_noise"]["verdict"], "pass")

    def test_twenty_degrees_of_bend_are_seen_by_every_metric(self):
        rows, picture = self.measures(self.picture["rest"], self.picture["bent"], DIFFERENT)
        self.assertEqual(picture["verdict"], "fail")
        for name in ("normal_mean", "within_noise", "outline_p95"):
            self.assertEqual(rows[name]["verdict"], "fail", name)
        self.assertGreater(rows["perceptual_hdr_mean"]["value"], 0)
        self.assertLess(rows["silhouette_overlap"]["value"], 0.95)

    def test_limits_are_the_callers(self):
        plain = self.folder / "plain"
        plain.mkdir()
        for name in ("rest", "bent"):  # without variance nothing but the limits decides
            subprocess.run(["oiiotool", self.picture[name], "--ch", "R,G,B,A", "-o", plain / (name + ".exr")], check=True)
        pair = (plain / "rest.exr", plain / "bent.exr")
        rows, _ = self.measures(*pair, None)
        flip = rows["perceptual_hdr_mean"]["value"]
        self.assertGreater(flip, 0)
        self.told(*pair, DIFFERENT, "--flip", str(flip / 2))
        self.told(*pair, 0, "--flip", str(min(1, flip * 2)))

    def test_folders_are_compared_name_by_name(self):
        for side in ("a", "b"):
            (self.folder / side / "deep").mkdir(parents=True)
            shutil.copy(self.picture["rest"], self.folder / side / "deep" / "one.exr")
        self.assertEqual(self.told("a", "b", 0)["pictures"][0]["name"], "deep/one.exr")
        shutil.copy(self.picture["rest"], self.folder / "a" / "two.exr")
        told = self.told("a", "b", INCOMPLETE)
        self.assertFalse(told["complete"])
        self.assertEqual(told["pictures"][1]["missing_in"], "b")
        shutil.copy(self.picture["bent"], self.folder / "b" / "two.exr")
        self.assertEqual([row["verdict"] for row in self.told("a", "b", DIFFERENT)["pictures"]], ["pass", "fail"])

    def test_nothing_to_compare_is_not_a_pass(self):
        (self.folder / "empty").mkdir()
        self.told("empty", "empty", NOTHING)

    def test_what_cannot_be_compared_is_one_line(self):
        self.write("broken.exr", b"not a picture")
        (self.folder / "folder").mkdir()
        self.assert_refused("diff", self.picture["rest"], "broken.exr", names=["broken.exr"])
        self.assert_refused("diff", self.picture["rest"], "gone.exr", names=["gone.exr"])
        self.assert_refused("diff", "folder", "broken.exr", names=["folder"])
        small = self.folder / "small.exr"
        subprocess.run(["oiiotool", self.picture["rest"], "--ch", "R,G,B,A", "--resize", "48x36", "-o", small], check=True)
        self.assert_refused("diff", self.picture["rest"], small, names=["96x72", "48x36"])

    def test_its_words_say_what_its_json_says(self):
        result = self.assert_runs("diff", self.picture["rest"], self.picture["bent"], code=DIFFERENT)
        self.assertIn("DIFFERS", result.stdout)
        self.assertIn("1 different", result.stdout)


if __name__ == "__main__":
    unittest.main()
