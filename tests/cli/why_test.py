"""`backbend why`: the ingredient that made a finding, over files and rigs."""

import json

import glb
from harness import CommandTest, USAGE


class Why(CommandTest):
    def setUp(self):
        super().setUp()
        self.assert_runs("body", "-o", "v1.glb", "--vertices", "1500")
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
