"""What must hold for solver, skinner and renderer, tried on this machine by the program itself."""

import json

from harness import BAD_INPUT, CommandTest, SOURCE, USAGE, human

HUMAN = SOURCE / "scenes/characters/human.toml"


class Selftest(CommandTest):
    def test_every_property_holds_with_its_bound_and_margin(self):
        self.write("human.glb", human(3000).read_bytes())
        rig = self.write("show.toml", '[rig]\nsystem = "even"\nbones = 7\nreach = 0.5\n')
        told = self.assert_runs("selftest", "--character", "human.glb", "--rig", rig, "--rig", "curve:length=rest",
                                "--json")
        document = json.loads(told.stdout)
        self.assertEqual(document["schema"], "backbend.selftest/1")
        rows = document["properties"]
        self.assertEqual({row["layer"] for row in rows}, {"solver", "skin", "render"})
        self.assertEqual({row["subject"] for row in rows if row["layer"] == "solver"}, {"show", "curve:length=rest"})
        for row in rows:
            self.assertTrue(row["holds"], row)
            self.assertLessEqual(row["worst"], row["bound"], row)
            self.assertGreater(row["cases"], 0, row)
        # Rounding is at work somewhere: properties that could not fail would all be exact.
        self.assertTrue(any(0 < row["worst"] for row in rows if row["layer"] == "solver"))
        self.assertTrue(any(0 < row["worst"] for row in rows if row["layer"] == "skin"))
        self.assertEqual(len({(row["subject"], row["layer"], row["property"]) for row in rows}), len(rows))
        table = self.assert_runs("selftest", "--character", "human.glb", "--rig", rig)
        self.assertIn("margin", table.stdout.splitlines()[0])
        self.assertEqual(table.stdout.count(" holds\n"), len(table.stdout.splitlines()) - 2)
        self.assertRegex(table.stdout.splitlines()[-1], r"^all \d+ properties hold$")

    def test_what_cannot_be_tried_is_refused(self):
        self.assert_refused("selftest", "--rig", "nosuch", names=["nosuch"])
        self.assert_refused("selftest", "--character", "nosuch.glb", code=BAD_INPUT, names=["nosuch.glb"])
        self.assert_refused("selftest", "--nosuch", code=USAGE, names=["--nosuch"])
