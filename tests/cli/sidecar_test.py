"""inspect --save and --suggest, and body around a skeleton."""

import json

import glb
from bvh import walker
from harness import USAGE, CommandTest, contents

class Sidecar(CommandTest):
    def spine(self, *arguments):
        found = json.loads(self.assert_runs("inspect", "hero.glb", "--json", *arguments).stdout)
        return found["spine"], found["chest"]

    def test_what_was_found_is_saved_and_found_again_by_itself(self):
        self.write("hero.glb", glb.tube())
        found = self.spine()
        self.assert_runs("inspect", "hero.glb", "--save", "--json")
        saved = (self.folder / "hero.backbend.toml").read_text()
        self.assertIn('schema = "backbend.sidecar/1"', saved)
        self.assertEqual(self.spine(), found)
        self.assert_runs("inspect", "hero.glb", "--save", "--json")
        self.assertEqual((self.folder / "hero.backbend.toml").read_text(), saved)

    def test_what_a_person_corrects_counts_until_the_command_line_says_otherwise(self):
        self.write("hero.glb", glb.tube())
        self.assert_runs("inspect", "hero.glb", "--save", "--chest", "chest", "--json")
        self.assertEqual(self.spine()[1], "chest")
        self.assertEqual(self.spine("--hip", "hips", "--chest", "neck")[1], "neck")

    def test_it_reaches_what_the_rig_bends(self):
        self.write("hero.glb", glb.tube())
        self.assert_runs("bake", "hero.glb", "-o", "free.glb")
        self.assert_runs("inspect", "hero.glb", "--save", "--chest", "chest", "--json")
        self.assert_runs("bake", "hero.glb", "-o", "saved.glb")
        self.assert_runs("bake", "hero.glb", "--chest", "chest", "-o", "said.glb")
        free, saved, said = ((self.folder / n).read_bytes() for n in ("free.glb", "saved.glb", "said.glb"))
        self.assertNotEqual(free, saved)
        self.assertEqual(saved, said)

    def test_a_sidecar_that_is_wrong_is_refused_naming_the_line(self):
        self.write("hero.glb", glb.tube())
        self.write("hero.backbend.toml", 'schema = "backbend.sidecar/1"\n[skeleton]\nspin = []\n')
        self.assert_refused("inspect", "hero.glb", names=["hero.backbend.toml:3:", "spin", "spine"])
        self.write("hero.backbend.toml", 'schema = "backbend.sidecar/1"\n[skeleton]\nchest = "ches"\n')
        self.assert_refused("inspect", "hero.glb", names=["'ches'", "'chest'"])
        self.write("hero.backbend.toml", 'schema = "backbend.sidecar/1"\n[space]\nup = "-Y"\n')
        self.assert_refused("inspect", "hero.glb", names=["hero.backbend.toml", "-Y", "--save"])

    def test_which_way_it_faces_can_be_specified_and_is_kept(self):
        self.write("hero.glb", glb.tube())
        facing = lambda *words: json.loads(self.assert_runs("inspect", "hero.glb", "--json", *words).stdout)["forward"]
        self.assertEqual(facing(), [0, 0, 1])
        self.assertEqual(facing("--forward", "-Z"), [0, 0, -1])
        self.assert_runs("inspect", "hero.glb", "--forward=-Z", "--save")
        self.assertEqual(facing(), [0, 0, -1])
        self.assert_runs("inspect", "hero.glb", "--save")
        self.assertIn('found_forward = "+Z"', (self.folder / "hero.backbend.toml").read_text())
        self.assertEqual(facing("--forward", "+X"), [1, 0, 0])
        self.assert_refused("inspect", "hero.glb", "--forward", "+Y", names=["hero.glb", "forward +Y", "up"])
        self.assert_refused("inspect", "hero.glb", "--forward", "back", code=USAGE, names=["--forward", "back", "+X"])

    def test_suggestions_change_nothing(self):
        self.write("hero.glb", glb.tube())
        before = contents(self.folder)
        report = json.loads(self.assert_runs("inspect", "hero.glb", "--suggest", "--json").stdout)
        self.assertEqual(report["schema"], "backbend.suggest/1")
        self.assertEqual(contents(self.folder), before)


class BodyAroundASkeleton(CommandTest):
    def test_a_bvh_becomes_a_character_with_its_joints(self):
        self.write("walk.bvh", walker())
        self.assert_refused("render", "walk.bvh", names=["walk.bvh", "backbend body"])
        self.assertIn("backbend body", self.assert_runs("inspect", "walk.bvh").stdout)
        self.assert_runs("body", "walk.bvh", "-o", "walker.glb", "--vertices", "3000")
        found = json.loads(self.assert_runs("inspect", "walker.glb", "--json").stdout)
        self.assertEqual(found["spine"], ["hips", "spine", "chest", "neck", "head"])
        self.assertEqual(found["arms"]["left"], ["LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand"])
        self.assertEqual(found["weights"]["unweighted"], 0)
        self.assertLessEqual(found["weights"]["most_influences"], 4)
        self.assertEqual(found["warnings"], [])

    def test_what_holds_no_skeleton_is_refused(self):
        self.write("walk.bvh", "HIERARCHY\n")
        self.assert_refused("body", "walk.bvh", "-o", "out.glb", names=["walk.bvh"])
        self.assert_refused("body", "absent.fbx", "-o", "out.glb", names=["absent.fbx"])
        self.write("point.bvh", "HIERARCHY\nROOT hips\n{\n OFFSET 0 0 0\n CHANNELS 3 Zrotation Xrotation "
                                "Yrotation\n}\nMOTION\nFrames: 1\nFrame Time: 1\n0 0 0\n")
        self.assert_refused("body", "point.bvh", "-o", "out.glb", names=["point.bvh"])
