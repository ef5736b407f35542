"""Rigify humans, made headless by Debian's own add-on on the body of a shared character, and the faults that were once
passed on them."""

import functools
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import harness
from harness import CommandTest, SOURCE, character

SCRIPT = SOURCE / "tests/cli/rigify_human.py"

MAPPING = {"armature": "rig", "spine": ["DEF-spine", "DEF-spine.001", "DEF-spine.002", "DEF-spine.003"],
           "arms": {"left": ["DEF-shoulder.L"], "right": ["DEF-shoulder.R"]},
           "channels": {"extension": [{"control": "chest", "channel": "rx", "per_degree": -1.0}],
                        "side": [{"control": "chest", "channel": "ry", "per_degree": 1.0}],
                        "twist": [{"control": "chest", "channel": "rz"}]}}
JOINTS = ("--hip", "DEF-spine", "--chest", "DEF-spine.003")

# A tweak bone leaves the line of its neighbours as soon as the chest bends: a corner of some 25 degrees.
KINK = """
rig.pose.bones["chest"].rotation_mode = "XYZ"
driver = rig.pose.bones["tweak_spine.002"].driver_add("location", 2).driver
variable = driver.variables.new()
variable.targets[0].id = rig
variable.targets[0].data_path = 'pose.bones["chest"].rotation_euler[0]'
driver.expression = "0.016 * min(1, abs(var) / 0.2)"
"""


def blender(*words, folder):
    # Its exporter needs numpy, which is the system's: another Python that comes first on the path would hide it.
    told = subprocess.run(["blender", "--background", *map(str, words)], capture_output=True, text=True,
                          env=harness.bare_environment(folder, PATH="/usr/bin:" + os.environ["PATH"]),
                          timeout=harness.PATIENCE_S)
    assert told.returncode == 0, told.stdout + told.stderr


@functools.lru_cache(maxsize=None)
def human():
    """The folder with hero.blend, hero.glb and hero_def.glb: made once for each build, since it takes a while."""
    body = character("mh_male_13k.glb")
    key = hashlib.sha256(SCRIPT.read_bytes() + body.read_bytes()).hexdigest()[:16]
    folder = pathlib.Path(os.environ.get("BACKBEND_BUILD") or tempfile.gettempdir(), "backbend_test_rigs", key)
    if not (folder / "hero_def.glb").is_file():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent) as making:  # another test may be making it, too
            blender("--factory-startup", "--python-exit-code", "9", "--python", SCRIPT, "--", body,
                    pathlib.Path(making, "hero.blend"), folder=making)
            folder.mkdir(exist_ok=True)
            for made in sorted(pathlib.Path(making).glob("hero*"), key=lambda path: path.name == "hero_def.glb"):
                os.replace(made, folder / made.name)
    return folder


def of(report, *codes):
    return [finding for finding in report["findings"] if finding["code"] in codes and finding["verdict"] == "fail"]


class RigifyTest:
    def setUp(self):
        super().setUp()
        for name in ("hero.blend", "hero.glb", "hero_def.glb"):
            shutil.copy(human() / name, self.folder / name)

    def motion(self, plant="", channel="twist", values=(), forms=(), mapping=None):
        """Plants a fault into hero.blend, or exports a motion of it as m.clip, m_points.clip, m.mdd, ..."""
        job = {"plant": plant, "channel": channel, "values": list(values), "forms": list(forms),
               "mapping": mapping or MAPPING, "out": str(self.folder / "m"),
               "save": "" if forms else str(self.folder / "hero.blend")}
        blender("--enable-autoexec", human() / "hero.blend", "--python-exit-code", "9", "--python", SCRIPT, "--", "motion",
                self.write("job.json", json.dumps(job)), folder=self.folder)

    def clip(self, name, *more, body="hero.glb"):
        """A check of a clip without pictures; its report."""
        result = self.backbend("check", *([body] if body else []), "--baked", name, *more, "--quick", "-o", "clip")
        self.assertIn(result.returncode, (0, 1, 5), f"{result.stdout}\n{result.stderr}")
        return json.loads((self.folder / "clip/report.json").read_text())


TWIST = [2.0 * k for k in range(46)]  # 0 to 90
BACK = [2.0 * k for k in range(31)]  # 0 to 60


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Bends(RigifyTest, CommandTest):
    def test_a_kink_at_a_tweak_bone_is_found_in_a_clip_with_its_controls(self):
        self.motion(KINK, "extension", BACK, ["clip"])
        for body, joints in (("hero.glb", JOINTS), (None, ())):
            with self.subTest(body):
                found = of(self.clip("m.clip", *joints, body=body), "BB010")
                self.assertEqual(len(found), 1)
                self.assertRegex(found[0]["place"]["joint"], r"^DEF-spine\.00[12]")

    def test_several_b_bones_in_a_row_are_judged_by_their_chain_alone(self):
        self.motion("", "twist", TWIST, ["clip"])
        report = self.clip("m.clip", body=None)
        self.assertEqual(of(report, "BB001"), [])
        self.assertEqual(len(report["characters"][0]["spine"]), 4 * 8)


if __name__ == "__main__":
    unittest.main()
