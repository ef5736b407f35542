"""backbend inspect on the real characters: the spine and arms that their description names."""

import json

from bvh import walker
from harness import CommandTest, character

# What stands upright and has two arms; the animals are listed after them.
HUMANS = ["mh_male_13k.glb", "mh_male_214k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb",
          "cesium_man.glb", "mh_female_cmu_49_08_baked.glb"]
ANIMALS = ["bunny.glb", "apatosaurus.glb", "alpaca.glb", "snake.glb", "shark.glb"]


class RealCharacters(CommandTest):
    def setUp(self):
        super().setUp()
        self.listed = {row["file"]: row for row in json.loads(character("characters.json").read_text())}

    told = {}  # by character: what the program says of each is looked at by several tests

    def inspect(self, name):
        if name not in self.told:
            self.told[name] = self.assert_runs("inspect", character(name), "--json").stdout
        return json.loads(self.told[name])

    def test_humans_have_the_spine_and_arms_that_their_makers_gave_them(self):
        for name in HUMANS:
            with self.subTest(name):
                found = self.inspect(name)
                self.assertEqual(found["schema"], "backbend.inspect/1")
                self.assertEqual(found["spine"], self.listed[name]["spine"])
                for side in ("left", "right"):
                    self.assertEqual(found["arms"][side], self.listed[name]["arms"][side], side)

    def test_animals_have_the_spine_that_their_makers_gave_them(self):
        for name in ANIMALS:
            with self.subTest(name):
                self.assertEqual(self.inspect(name)["spine"], self.listed[name]["spine"])

    def test_the_chest_is_where_the_arms_hang_in_each_of_them(self):
        for name, row in self.listed.items():
            with self.subTest(name):
                found = self.inspect(name)
                self.assertEqual(found["chest"], row["chest"])
                self.assertTrue(found["driven"]["why"])
                # A fish is driven beyond its fins, a body without arms to its neck.
                self.assertEqual(found["driven"]["end"] == row["chest"], name not in ("shark.glb", "snake.glb"))

    def test_the_figures_are_those_of_the_file(self):
        for name in HUMANS[:2]:
            with self.subTest(name):
                meshes = self.inspect(name)["meshes"]
                self.assertEqual(sum(mesh["vertices"] for mesh in meshes), self.listed[name]["vertices"])
                self.assertEqual(sum(mesh["triangles"] for mesh in meshes), self.listed[name]["triangles"])


class SkeletonsAlone(CommandTest):
    def test_captures_have_the_spine_and_arms_that_their_readme_names(self):
        for name, spine, arm in (
                ("cmu_49_08_acrobatics.bvh", "Hips LowerBack Spine Spine1 Neck Neck1 Head", "LeftShoulder LeftArm"),
                ("cmu_131_01_mj_style.bvh", "Hips lowerback Chest Chest2 lowerneck Neck Head",
                 "LeftCollar LeftShoulder")):
            with self.subTest(name):
                file = character("motion/" + name)
                found = json.loads(self.assert_runs("inspect", file, "--json").stdout)
                self.assertEqual(found["spine"], spine.split())
                self.assertEqual(found["arms"]["left"][:2], arm.split())
                self.assertEqual([warning["code"] for warning in found["warnings"]], ["no_mesh"])
                self.assertEqual((found["meshes"], found["height"]), ([], None))
                text = self.assert_runs("inspect", file).stdout
                self.assertIn("a skeleton alone", text)
                self.assertNotIn("inf", text)

    def test_there_are_no_weights_to_suggest_for(self):
        result = self.backbend("inspect", self.write("walker.bvh", walker()), "--suggest")
        self.assertEqual((result.returncode, result.stdout), (3, ""))
        self.assertIn("walker.bvh: no mesh", result.stderr)
