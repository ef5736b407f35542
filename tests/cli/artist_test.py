"""The line for the artist's program: what a finding says to set in Maya and Blender, run."""

import json
import math
import pathlib
import shutil
import subprocess
import tempfile
import types
import unittest

from harness import run_backbend

FINDINGS = 1
CONTROLS = """
[[control]]
channel = "extension"
control = "chest ctl'"
axis = "X"
sign = -1

[[control]]
channel = "twist"
control = "chest ctl'"
axis = "Y"
sign = 1
"""
BLENDER = """
import bpy, json, math, sys
bpy.ops.object.armature_add()
bpy.context.object.data.bones[0].name = "chest ctl'"
exec(open(sys.argv[-1]).read())
print("RESULT " + json.dumps([math.degrees(v) for v in bpy.context.object.pose.bones[0].rotation_euler]))
"""


class TheArtistsProgram(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend artist ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        for made in (("body", "-o", "hero.glb"), ("inspect", "hero.glb", "--save", "--json")):
            assert run_backbend(made, cls.folder).returncode == 0
        with open(cls.folder / "hero.backbend.toml", "a") as sidecar:
            sidecar.write(CONTROLS)
        run = run_backbend(["check", "hero.glb", "--rig", "three_bone", "-o", "run", "--res", "48x36", "--spp", "1"], cls.folder)
        assert run.returncode == FINDINGS, run.stderr
        cls.terminal = run.stdout
        report = json.loads((cls.folder / "run/report.json").read_text())
        cls.findings = [f for f in report["findings"] if f["rig"] == "three_bone" and f["pose"] != "rest"]

    @staticmethod
    def expected(pose):
        """Degrees about X and Y that the sidecar asks for; None where the pose moves what has no control."""
        channels = {name: float(value) for name, value in (part.split() for part in pose.split(", "))}
        if channels.get("side"):
            return None
        return [channels.get("flexion", 0) - channels.get("extension", 0), channels.get("twist", 0)]

    def test_every_finding_says_what_to_set_in_maya_or_nothing(self):
        seen = 0
        for finding in self.findings:
            want = self.expected(finding["pose"])
            if want is None:
                self.assertNotIn("artist", finding)
                continue
            angle = {"chest ctl'.rotateX": 0, "chest ctl'.rotateY": 0}
            cmds = types.SimpleNamespace(setAttr=lambda name, value: angle.__setitem__(name, value))
            modules = {"maya": types.SimpleNamespace(cmds=cmds)}
            line = finding["artist"]["maya"]
            exec(line, {"__builtins__": {"__import__": lambda name, *_: modules[name]}})
            self.assertEqual(list(angle.values()), want, line)
            seen += 1
        self.assertGreater(seen, 3)

    def test_the_worst_ones_line_is_in_the_terminal_whole(self):
        worst = next(f for f in self.findings if f["verdict"] == "fail")
        self.assertIn("maya: " + worst["artist"]["maya"] + "\n", self.terminal)

    def test_the_findings_folder_holds_it_and_blender_takes_up_the_pose(self):
        pictured = [f for f in self.findings if "artist" in f and f["pictures"]["before"]]
        self.assertTrue(pictured)
        for finding in pictured:
            place = (self.folder / "run" / finding["pictures"]["before"]).parent
            for program, line in finding["artist"].items():
                self.assertEqual((place / f"set_pose_{program}.py").read_text().splitlines()[1], line)
        if not shutil.which("blender"):
            self.skipTest("Blender is not installed")
        (self.folder / "pose.py").write_text(BLENDER)
        told = subprocess.run(["blender", "-b", "--factory-startup", "--python", self.folder / "pose.py", "--", place / "set_pose_blender.py"],
                              capture_output=True, encoding="utf-8", timeout=300)
        (line,) = [line for line in told.stdout.splitlines() if line.startswith("RESULT ")]
        found, want = json.loads(line[7:]), self.expected(finding["pose"])
        for axis in (0, 1):
            self.assertTrue(math.isclose(found[axis], want[axis], abs_tol=1e-4), (found, want))
