"""Pictures of a night in which two rigs show the same."""

import unittest

from harness import CommandTest, human

RIG = '[[rig]]\nname = "{name}"\nrole = "{role}"\nsolver = {{ system = "{system}" }}\n'
SUITE = """[suite]
characters = ["one.glb"]
mappings = ["chest"]
envelope = "sweep"
[hunt]
percent = 0
[calibration]
poses = 4
faults = 2
[pictures]
width = 48
height = 36
samples = 1
turntable_views = 3
sheet_columns = 2
[[sweep]]
channel = "extension"
to = 60
step = 20
"""


class EqualRigs(CommandTest):
    def night(self, run, *rigs):
        """The frames of each rig, by its name."""
        self.write("night.toml", SUITE + "".join(RIG.format(name=name, role=role, system=system) for name, role, system in rigs))
        done = self.backbend("nightly", "night.toml", "-o", run)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        frames = {name: {path.name: path.read_bytes() for path in (self.folder / run / "review" / f"one_{name}_chest").glob("*.png")}
                  for name, _, _ in rigs}
        self.assertTrue(all(len(each) == 4 for each in frames.values()), {name: sorted(each) for name, each in frames.items()})
        return frames

    def test_the_second_of_them_has_the_pictures_that_it_has_alone_and_another_rig_its_own(self):
        self.write("one.glb", human(1500).read_bytes())
        first, second, other = ("first", "proposed", "three_bone"), ("second", "reference", "three_bone"), ("other", "reference", "isner")
        together = self.night("together", first, second, other)
        alone = self.night("alone", ("second", "proposed", "three_bone"), other)  # the same bodies before the cameras
        self.assertEqual(together["second"], alone["second"])
        self.assertEqual(together["second"], together["first"])
        self.assertEqual(together["other"], alone["other"])
        last = max(together["other"])
        self.assertNotEqual(together["other"][last], together["second"][last])


if __name__ == "__main__":
    unittest.main()
