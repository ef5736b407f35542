"""The emulations beside what they are called, joint by joint: `matrix_blend` beside spines that Rigify
generated, `spline_ik` beside Blender's constraint. The tables in the docs are of stored poses; where
Blender is installed finer sweeps of the living program are asked for, too."""

import json
import math
import shutil
import subprocess
import unittest

from harness import CommandTest, SOURCE
from solve_test import degrees_between

BLENDER = shutil.which("blender")
STORED = SOURCE / "tests/solver/blender_poses.json"
SCRIPT = SOURCE / "tests/cli/blender_poses.py"

MOST_DEGREES, MOST_PERCENT = 0.1, 0.1  # of any joint; percent of the spine from hip to chest
SWEEPS = ("extension", "side", "twist", "compound")  # what a rig is asked for before it is called one


def is_half_turn(controls):
    """One control is exactly half a turn from rest: which way round it goes is rounding's choice."""
    return any(sorted(map(abs, controls[name])) == [0, 0, 180] for name in ("hip", "chest"))


def toml_of(case):
    options = "".join(f"{key} = {json.dumps(value)}\n" for key, value in case["options"].items())
    lines = [f"[rig]\nsystem = {json.dumps(case['system'])}\n{options}\n[chain]\njoints = {json.dumps(case['chain'])}\n"]
    for time, pose in enumerate(case["poses"]):
        lines.append(f"[[key]]\ntime = {time}\npose = {{ "
                     + ", ".join(f"{name} = {json.dumps(value)}" for name, value in pose["controls"].items()) + " }\n")
    return "\n".join(lines)


class Emulations(CommandTest):
    def differences(self, case):
        """{sweep: (degrees, percent of spine)}, the worst of any joint of its poses."""
        self.write("case.toml", toml_of(case))
        lines = self.assert_runs("solve", "case.toml", "--sweep", f"time=0:{len(case['poses']) - 1}:1").stdout.splitlines()
        self.assertEqual(len(lines), len(case["poses"]))
        spine = math.dist(case["chain"][0], case["chain"][-1])
        worst, excused = {}, []
        for line, pose in zip(lines, case["poses"]):
            joints = json.loads(line)["joints"]
            self.assertEqual(len(joints), len(pose["position"]))
            degrees = max(degrees_between(j["turn"], t) for j, t in zip(joints, pose["turn"]))
            percent = max(100 * math.dist(j["position"], p) / spine for j, p in zip(joints, pose["position"]))
            if case["system"] == "matrix_blend" and is_half_turn(pose["controls"]):
                excused.append(pose["sweep"])
                continue
            before = worst.get(pose["sweep"], (0.0, 0.0))
            worst[pose["sweep"]] = (max(before[0], degrees), max(before[1], percent))
        # What is not compared is known by name, and nothing else.
        self.assertEqual(excused, ["extension", "twist"] if case["system"] == "matrix_blend" else [])
        return worst

    def assert_near(self, cases):
        self.assertEqual({case["system"] for case in cases}, {"matrix_blend", "spline_ik"})
        for case in cases:
            worst = self.differences(case)
            self.assertTrue(set(SWEEPS) <= set(worst), case["name"])
            for sweep, (degrees, percent) in worst.items():
                with self.subTest(f"{case['system']}, {case['name']}: {sweep}"):
                    self.assertLessEqual(degrees, MOST_DEGREES)
                    self.assertLessEqual(percent, MOST_PERCENT)

    def test_the_pages_tables_hold(self):
        """`| case | sweep | ... |`, then a row for each stored case with `degrees / percent` of each
        sweep: none is left out, none is exceeded, none is said to be far worse than it is."""
        cases = json.loads(STORED.read_text())["cases"]
        self.assert_near(cases)
        for system in ("matrix_blend", "spline_ik"):
            rows = [[cell.strip(" `") for cell in line.strip("|").split("|")]
                    for line in (SOURCE / f"docs/rigs/{system}.md").read_text().splitlines() if line.startswith("|")]
            head = next(i for i, row in enumerate(rows) if row[0] == "case")
            sweeps = rows[head][1:]
            self.assertTrue(set(SWEEPS) <= set(sweeps))
            stated = {row[0]: row[1:] for row in rows[head + 2:] if len(row) == len(sweeps) + 1}
            measured = {case["name"]: self.differences(case) for case in cases if case["system"] == system}
            self.assertEqual(set(stated), set(measured))
            for name, cells in stated.items():
                self.assertEqual(set(sweeps), set(measured[name]) - {"rest"})
                for sweep, cell in zip(sweeps, cells):
                    for said, seen in zip(map(float, cell.split(" / ")), measured[name][sweep]):
                        with self.subTest(f"{system}, {name}: {sweep} {seen}"):
                            self.assertLessEqual(seen, said)
                            self.assertLessEqual(said, max(2 * seen, 0.001))

    @unittest.skipUnless(BLENDER, "Blender is not installed")
    def test_the_living_program_is_met(self):
        out = self.folder / "poses.json"
        told = subprocess.run([BLENDER, "--background", "--factory-startup", "--python-exit-code", "9", "--python", SCRIPT,
                               "--", out, "5"], cwd=self.folder, capture_output=True, text=True, timeout=600)
        self.assertEqual(told.returncode, 0, told.stdout + told.stderr)
        self.assert_near(json.loads(out.read_text())["cases"])
