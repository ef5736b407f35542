"""Rigify humans, made headless by Debian's own add-on on the body of a shared character, and the faults that were once
passed on them."""

import functools
import hashlib
import json
import os
import pathlib
import shutil
import tempfile
import unittest

import spine_rig
from harness import CommandTest, SOURCE, character

SCRIPT = SOURCE / "tests/cli/rigify_human.py"

MAPPING = {"armature": "rig", "spine": ["DEF-spine", "DEF-spine.001", "DEF-spine.002", "DEF-spine.003"],
           "arms": {"left": ["DEF-shoulder.L"], "right": ["DEF-shoulder.R"]},
           "channels": {"extension": [{"control": "chest", "channel": "rx", "per_degree": -1.0}],
                        "side": [{"control": "chest", "channel": "ry", "per_degree": 1.0}],
                        "twist": [{"control": "chest", "channel": "rz"}]}}
JOINTS = ("--hip", "DEF-spine", "--chest", "DEF-spine.003")

# A tweak bone follows the chest control: its channel, the control's axis and the driver of `var` in radians are left open.
TWEAK = """
for name in ("chest", "tweak_spine.002"):
    rig.pose.bones[name].rotation_mode = "XYZ"
driver = rig.pose.bones["tweak_spine.002"].driver_add(%r, %d).driver
variable = driver.variables.new()
variable.targets[0].id = rig
variable.targets[0].data_path = 'pose.bones["chest"].rotation_euler[%d]'
driver.expression = %r
"""
# It leaves the line of its neighbours as soon as the chest bends: a corner of some 25 degrees.
KINK = TWEAK % ("location", 2, 0, "0.016 * min(1, abs(var) / 0.2)")
# It turns about its bone between 30 and 32 degrees of twist.
JUMP = TWEAK % ("rotation_euler", 1, 2, "radians(%g) if abs(var) > radians(31) else 0")


def without_controls(report):
    """What a report says where no clean verdict on kinks can be had."""
    said = [line for line in report["detectors"] if line.startswith("kinks: no control is recorded")]
    asked = [line for line in report["next"] if "--rig" in line]
    return bool(said and asked)


@functools.lru_cache(maxsize=None)
def human():
    """The folder with hero.blend, hero.glb and hero_def.glb: made once for each build, since it takes a while."""
    body = character("mh_male_13k.glb")
    key = hashlib.sha256(SCRIPT.read_bytes() + body.read_bytes()).hexdigest()[:16]
    folder = pathlib.Path(os.environ.get("BACKBEND_BUILD") or tempfile.gettempdir(), "backbend_test_rigs", key)
    if not (folder / "hero_def.glb").is_file():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent) as making:  # another test may be making it, too
            spine_rig.blender(making, "--factory-startup", "--python-exit-code", "9", "--python", SCRIPT, "--", body,
                              pathlib.Path(making, "hero.blend"))
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
        spine_rig.blender(self.folder, "--enable-autoexec", human() / "hero.blend", "--python-exit-code", "9", "--python",
                          SCRIPT, "--", "motion", self.write("job.json", json.dumps(job)))

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

    def test_a_kink_that_a_cache_hides_is_said_to_be_hidden(self):
        self.motion(KINK, "extension", BACK, ["mdd"])
        report = self.clip("m.mdd", *JOINTS)
        self.assertTrue(of(report, "BB010") or without_controls(report), report["detectors"])

    def test_several_b_bones_in_a_row_are_judged_by_their_chain_alone(self):
        self.motion("", "twist", TWIST, ["clip"])
        report = self.clip("m.clip", body=None)
        self.assertEqual(of(report, "BB001"), [])
        self.assertEqual(len(report["characters"][0]["spine"]), 4 * 8)


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Twists(RigifyTest, CommandTest):
    FORMS = {"clip": "m.clip", "points": "m_points.clip", "mdd": "m.mdd", "pc2": "m.pc2", "baked": "m_baked.glb",
             "baked_def": "m_baked_def.glb"}

    def flips_of(self, plant):
        """{form: the frames at which each form's check finds a flip, with their sizes}"""
        self.motion(plant, "twist", TWIST[:31], self.FORMS)
        found = {}
        for form, name in self.FORMS.items():
            body = "hero_def.glb" if form == "baked_def" else "hero.glb"
            found[form] = {finding["frame"]: finding["value"] for finding in of(self.clip(name, *JOINTS, body=body), "BB001")}
        return found

    def test_a_jump_of_a_tweak_bone_between_two_poses_is_found_in_every_form(self):
        for form, found in self.flips_of(JUMP % 20).items():
            with self.subTest(form):
                frame = 17 if form.startswith("baked") else 16  # Blender's keys begin at frame 1
                self.assertEqual(list(found), [frame])
                self.assertGreater(found[frame], 8)  # B-Bones and skin carry a part of the bone's turn

    def test_the_same_motion_without_it_has_none_in_any_form(self):
        self.assertEqual(self.flips_of(""), {form: {} for form in self.FORMS})


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Mappings(RigifyTest, CommandTest):
    def of_mapping(self, **channels):
        mapping = {**MAPPING, "channels": channels}
        self.motion("", next(iter(channels)), BACK, ["clip"], mapping=mapping)
        return of(self.clip("m.clip", *JOINTS), "BB049")

    def test_a_control_that_does_not_move_the_spine_fails(self):
        (found,) = self.of_mapping(extension=[{"control": "hand_ik.L", "channel": "rx"}])
        self.assertLess(found["value"], 0.05)

    def test_a_wrong_sign_fails(self):
        (found,) = self.of_mapping(extension=[{"control": "chest", "channel": "rx", "per_degree": 1.0}])
        self.assertIn("other way round", found["detail"])


if __name__ == "__main__":
    unittest.main()
