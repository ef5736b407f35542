"""backbend inspect on the real characters: the spine and arms that their description names."""

import json

from harness import CommandTest, character

# What stands upright and has two arms; the animals are listed after them.
HUMANS = ["mh_male_13k.glb", "mh_male_214k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb",
          "cesium_man.glb", "mh_female_cmu_49_08_baked.glb"]
ANIMALS = ["bunny.glb", "apatosaurus.glb", "alpaca.glb", "snake.glb", "shark.glb"]


class RealCharacters(CommandTest):
    def setUp(self):
        super().setUp()
        self.listed = {row["file"]: row for row in json.loads(character("characters.json").read_text())}

    def inspect(self, name):
        return json.loads(self.assert_runs("inspect", character(name), "--json").stdout)

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

    def test_the_figures_are_those_of_the_file(self):
        for name in HUMANS[:2]:
            with self.subTest(name):
                meshes = self.inspect(name)["meshes"]
                self.assertEqual(sum(mesh["vertices"] for mesh in meshes), self.listed[name]["vertices"])
                self.assertEqual(sum(mesh["triangles"] for mesh in meshes), self.listed[name]["triangles"])


