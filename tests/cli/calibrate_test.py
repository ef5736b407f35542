"""backbend calibrate: what it prints is what it stores, and what it stores is whole."""

import json

from harness import CANNOT_WRITE, SOURCE, USAGE, CommandTest

SMALL = ("calibrate", "--bones", "24", "--tubes", "22", "--poses", "20", "--faults", "6", SOURCE / "scenes/characters/snake.toml")


class Calibrating(CommandTest):
    def test_prints_and_stores_the_smallest_fault_of_every_detector(self):
        result = self.backbend(*SMALL, "-o", "out")
        self.assertIn(result.returncode, (0, 1), result.stderr)
        stored = json.loads((self.folder / "out/calibration.json").read_text())
        self.assertEqual(stored["schema"], "backbend.calibration/1")
        self.assertEqual(stored["ok"], result.returncode == 0)
        lines = result.stdout.splitlines()
        table = (self.folder / "out/calibration.md").read_text().splitlines()
        self.assertEqual(len(table), 2 + len(stored["detectors"]))
        for row, line, cells in zip(stored["detectors"], lines, table[2:]):
            self.assertTrue(line.startswith(row["detector"] + "  " + row["body"] + ": "), line)
            self.assertIn(f"{row['false_alarms']} of {row['clean_poses']} clean poses flagged", line)
            self.assertIn("| %s | %s | %s |" % (row["detector"], row["code"], row["body"]), cells)
        found = {row["detector"] for row in stored["detectors"]}
        self.assertLessEqual({"flip", "chain kink", "mesh kink", "weight sum", "wrong vertex"}, found)
        self.assertEqual({path.name for path in (self.folder / "out").iterdir()},
                         {"calibration.json", "calibration.md"})

    def test_nonsense_is_refused_before_any_work(self):
        self.assert_refused("calibrate", "--bones", "2", code=USAGE, names=["--bones"])
        self.assert_refused("calibrate", "gone.glb", names=["gone.glb"])
        self.write("file", "x")
        self.assert_refused("calibrate", "-o", "file", code=CANNOT_WRITE, names=["file"])
