"""Rigify humans, made headless by Debian's own add-on on the body of a shared character, and the faults that were once
passed on them: each is found, or refused with its reason, live and in a clip."""

import functools
import hashlib
import json
import math
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

# A tweak bone of the spine follows a control of the chest beside its own place.
FOLLOW = """
rig.pose.bones["chest"].rotation_mode = "XYZ"
driver = rig.pose.bones["tweak_spine.002"].driver_add("rotation_euler", {axis}).driver
variable = driver.variables.new()
variable.targets[0].id = rig
variable.targets[0].data_path = 'pose.bones["chest"].rotation_euler[{source}]'
driver.expression = "{expression}"
"""
JUMP_AT = math.degrees(0.72)


def jump(size):
    """The tweak bone turns by `size` degrees about itself where the chest's twist passes JUMP_AT."""
    return FOLLOW.format(axis=1, source=2, expression=f"radians({size}) if var > 0.72 else 0")


# The tweak bone leaves the line of its neighbours as soon as the chest bends: a corner of some 25 degrees.
KINK = FOLLOW.replace('driver_add("rotation_euler", {axis})', 'driver_add("location", 2)').format(
    source=0, expression="0.016 * min(1, abs(var) / 0.2)")


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
        self.mapping = self.write("map.json", json.dumps({**MAPPING, "mesh": False}))

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

    def live(self, *sweeps, code=None):
        """A night of single sweeps, (channel, degrees), through the living rig."""
        self.write("night.toml", """
[suite]
name = "own"
title = "Own"
characters = ["hero.glb"]
envelope = "human"
mappings = ["chest"]
corners = false
[[rig]]
name = "hero"
solver = { system = "external", program = "blender", file = "hero.blend", map = "map.json" }
""" + "".join(f'[[sweep]]\nchannel = "{channel}"\nto = {to}\nstep = 3\n' for channel, to in sweeps))
        result = self.backbend("nightly", "night.toml", *JOINTS, "--quick", "-o", "night")
        self.assertIn(result.returncode, (0, 1, 5) if code is None else (code,), f"{result.stdout}\n{result.stderr}")
        return json.loads((self.folder / "night/report.json").read_text())


TWIST = [2.0 * k for k in range(46)]  # 0 to 90


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Jumps(RigifyTest, CommandTest):
    def test_a_twist_jump_of_a_tweak_bone_is_found_live_at_its_angle_with_its_size(self):
        for size in (20, 30):
            self.motion(jump(size))
            found = [finding for finding in of(self.live(("twist", 60)), "BB001") if finding["sweep"] == "twist"]
            self.assertEqual(len(found), 1)
            self.assertAlmostEqual(found[0]["control_deg"], JUMP_AT, delta=60e-4)

    def test_it_is_found_in_a_clip_a_baked_glb_and_in_caches_of_points(self):
        forms = {"clip": "m.clip", "points": "m_points.clip", "mdd": "m.mdd", "pc2": "m.pc2", "baked": "m_baked.glb"}
        for size in (20, 30):
            self.motion(jump(size), "twist", TWIST, forms)
            for form, name in forms.items():
                with self.subTest(f"{size} degrees, {form}"):
                    report = self.clip(name, *JOINTS)
                    found = of(report, "BB001")
                    self.assertTrue(found)
                    frames = [finding["frame"] if "controls" not in finding else finding["control_deg"] / 2 for finding in found]
                    self.assertTrue(any(abs(frame - JUMP_AT / 2) <= 1.5 for frame in frames), frames)


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

    def test_a_healthy_bend_passes_whichever_joints_were_exported(self):
        self.motion("", "extension", BACK, ["clip", "baked", "baked_def"])
        for name, body, joints in (("m.clip", "hero.glb", JOINTS), ("m_baked.glb", "hero.glb", ()),
                                   ("m_baked_def.glb", "hero_def.glb", ())):
            report = self.clip(name, *joints, body=body)
            self.assertEqual(of(report, "BB001", "BB010", "BB020", "BB021"), [], name)

    def test_a_jump_has_one_verdict_whichever_joints_were_exported(self):
        self.motion(jump(20), "twist", TWIST, ["baked", "baked_def"])
        seen, spines = [], []
        for name, body in (("m_baked.glb", "hero.glb"), ("m_baked_def.glb", "hero_def.glb")):
            report = self.clip(name, body=body)
            spines.append(report["characters"][0]["spine"])
            seen.append([(finding["code"], finding["place"]["joint"], finding["frame"], round(finding["value"], 1))
                         for finding in of(report, "BB001", "BB010", "BB020", "BB021")])
        self.assertEqual(spines[0], spines[1])
        self.assertEqual(spines[0][:4], MAPPING["spine"])
        self.assertEqual(seen[0], seen[1])
        self.assertEqual([code for code, *_ in seen[0]], ["BB001"])

    def test_several_b_bones_in_a_row_are_judged_by_their_chain_alone(self):
        self.motion("", "twist", TWIST, ["clip"])
        report = self.clip("m.clip", body=None)
        self.assertEqual(of(report, "BB001"), [])
        self.assertEqual(len(report["characters"][0]["spine"]), 4 * 8)


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Mappings(RigifyTest, CommandTest):
    def changed(self, channel, target):
        return {**MAPPING, "channels": {**MAPPING["channels"], channel: [target]}}

    def test_a_control_that_does_not_move_the_spine_fails_in_a_clip_and_live(self):
        wrong = self.changed("twist", {"control": "hand_ik.L", "channel": "ry"})
        self.motion("", "twist", TWIST[:20], ["clip"], mapping=wrong)
        for report in (self.clip("m.clip", *JOINTS), self.judge_live(wrong)):
            found = of(report, "BB049")
            self.assertEqual([finding["sweep"] for finding in found], ["twist"])

    def judge_live(self, mapping):
        self.mapping.write_text(json.dumps({**mapping, "mesh": False}))
        return self.live(("extension", 60), ("twist", 60), code=1)

    def test_a_wrong_sign_fails_live(self):
        found = of(self.judge_live(self.changed("extension", {"control": "chest", "channel": "rx", "per_degree": 1.0})), "BB049")
        self.assertEqual([finding["sweep"] for finding in found], ["extension"])
        self.assertIn("other way round", found[0]["detail"])

    def test_the_preset_stands_for_the_chest(self):
        self.write("night.toml", """
[suite]
name = "own"
title = "Own"
characters = ["hero.glb"]
envelope = "human"
mappings = ["chest"]
corners = false
[[rig]]
name = "hero"
solver = { system = "external", program = "blender", file = "hero.blend", map = "rigify" }
[[sweep]]
channel = "extension"
to = 30
step = 10
[[sweep]]
channel = "side"
to = 30
step = 10
[[sweep]]
channel = "twist"
to = 30
step = 10
""")
        result = self.backbend("nightly", "night.toml", *JOINTS, "--quick", "-o", "night")
        self.assertIn(result.returncode, (0, 1, 5), result.stderr)
        report = json.loads((self.folder / "night/report.json").read_text())
        self.assertEqual([finding for finding in report["findings"] if finding["code"] == "BB049"], [])
        asked = [row for row in report["rigs"][0]["coverage"] if row["code"] == "BB049"][0]
        self.assertEqual((asked["planned"], asked["measured"]), (3, 3))


if __name__ == "__main__":
    unittest.main()
