"""A small slice of tests/battery/blender_steps.py: steps and pulses planted in drivers of a live Blender rig."""

import shutil
import sys
import unittest

import harness
from harness import CommandTest, SOURCE

sys.path.insert(0, str(SOURCE / "tests/battery"))
import blender_steps  # noqa: E402


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Steps(CommandTest):
    def test_steps_and_wide_pulses_are_found_at_their_angles_with_their_sizes_and_nothing_else(self):
        events = blender_steps.plant(7, steps=12, pulses=8)
        blender_steps.make(self.folder, events)
        found, widths, evaluations = blender_steps.judge_live(harness.BACKBEND, self.folder, servers=1)
        wrong, (steps, _, wide) = blender_steps.compare(events, found, widths)
        self.assertEqual(wrong, [])
        self.assertEqual(steps, 12)
        self.assertGreater(wide, 0)
        self.assertLess(wide, 8)  # some are narrower than what the report says it sees
        self.assertEqual(set(widths), set(blender_steps.ENDS))
        self.assertGreater(evaluations, 4 * 45)


class Comparing(unittest.TestCase):
    """What the battery counts as wrong."""

    EVENTS = [{"channel": "twist", "bone": 1, "at": 20.0, "size": 10.0, "width": None},
              {"channel": "twist", "bone": 2, "at": 40.0, "size": 10.0, "width": 1.0}]
    FOUND = [("twist", 20.0, 10.0), ("twist", 40.0, 10.0), ("twist", 41.0, 10.0)]

    def wrong(self, found, width=0.5):
        return blender_steps.compare(self.EVENTS, found, {"twist": width})[0]

    def test_all_found_is_right(self):
        self.assertEqual(self.wrong(self.FOUND), [])

    def test_a_step_that_is_missing_misplaced_or_of_another_size_is_wrong(self):
        self.assertIn("was not found", self.wrong(self.FOUND[1:])[0])
        self.assertEqual(len(self.wrong([("twist", 20.01, 10.0), *self.FOUND[1:]])), 2)
        self.assertIn("10.200 deg found", self.wrong([("twist", 20.0, 10.2), *self.FOUND[1:]])[0])

    def test_what_was_not_planted_is_wrong(self):
        self.assertIn("nothing was planted", self.wrong([*self.FOUND, ("twist", 50.0, 3.0)])[0])

    def test_a_pulse_may_be_missed_only_below_the_width_that_is_stated(self):
        self.assertIn("is said to be seen", self.wrong(self.FOUND[:2])[0])
        self.assertEqual(self.wrong(self.FOUND[:1], width=2.0), [])

    def test_what_is_planted_is_the_seeds_and_apart(self):
        events = blender_steps.plant(3, 100, 40)
        self.assertEqual(events, blender_steps.plant(3, 100, 40))
        self.assertNotEqual(events, blender_steps.plant(4, 100, 40))
        self.assertEqual(sum(event["width"] is None for event in events), 100)
        for a, b in zip(events, events[1:]):
            if a["channel"] == b["channel"]:
                self.assertGreater(b["at"] - a["at"] - (a["width"] or 0), 0.049)


if __name__ == "__main__":
    unittest.main()
