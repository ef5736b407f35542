"""The bridges: what other programs write for `backbend check --baked`."""

import json
import math
import shutil
import sys
import unittest

import spine_rig
from harness import CommandTest, SOURCE

BRIDGES = SOURCE / "scenes/bridges"
sys.path.insert(0, str(BRIDGES))
import backbend_clip  # noqa: E402
import backbend_maya  # noqa: E402

BLENDER = shutil.which("blender")

# Spline IK keeps each bone's own roll, so the chest's twist is handed to the bones by drivers that
# read it back from a matrix: the way it is done, and the way it flips.
SPLINE_IK = spine_rig.spine() + """
bone("chest", 1.0, 1.2, deform=False)
bpy.ops.object.mode_set(mode="OBJECT")
line = bpy.data.curves.new("line", "CURVE")
line.dimensions = "3D"
spline = line.splines.new("POLY")
spline.points.add(5)
for k, point in enumerate(spline.points):
    point.co = (0, 0, 0.2 * k, 1)
curve = bpy.data.objects.new("line", line)
bpy.context.collection.objects.link(curve)
ik = rig.pose.bones["spine4"].constraints.new("SPLINE_IK")
ik.target, ik.chain_count, ik.y_scale_mode = curve, 5, "FIT_CURVE"
"""

DRIVEN_TWIST = """
for k in range(5):
    posed = rig.pose.bones[f"spine{k}"]
    posed.rotation_mode = "XYZ"
    driver = posed.driver_add("rotation_euler", 1).driver
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    target = variable.targets[0]
    target.id, target.bone_target = rig, "chest"
    target.transform_type, target.rotation_mode = "ROT_Y", "SWING_TWIST_Y"
    target.transform_space = "LOCAL_SPACE"
    driver.expression = f"{variable.name} * {'0.0' if k == 0 else '0.25'}"
"""

# One B-Bone whose end handle is the chest: its roll is the handle's.
B_BONE = spine_rig.ARMATURE + """
bone("hips", -0.2, 0.0)
spine = bone("spine", 0.0, 1.0, "hips")
bone("chest", 1.0, 1.2, "hips", deform=False)
spine.bbone_segments = SEGMENTS
spine.bbone_handle_type_start = spine.bbone_handle_type_end = "ABSOLUTE"
spine.bbone_custom_handle_start, spine.bbone_custom_handle_end = data.edit_bones["hips"], data.edit_bones["chest"]
bpy.ops.object.mode_set(mode="OBJECT")
"""

EXPORT = """
sys.path.insert(0, {folder!r})
import backbend_blender
mapping = {{"spine": {spine!r},
            "channels": {{"twist": [{{"control": "chest", "channel": "ry"}}]}}}}
backbend_blender.export(mapping, {path!r}, stress={stress})
"""


def flips(report):
    return [finding for finding in report["findings"] if finding["code"] == "BB001"]


@unittest.skipUnless(BLENDER, "Blender is not installed")
class ExportingFromBlender(CommandTest):
    SPINE = spine_rig.BONES

    def export(self, rig, spine=SPINE, stress=True):
        clip = self.folder / "rig.clip"
        spine_rig.run_script(self.folder, rig + EXPORT.format(folder=str(BRIDGES), spine=spine, path=str(clip), stress=stress))
        return clip

    def report(self, clip):
        result = self.backbend("check", "--baked", clip, "-o", clip.stem + ".run")
        self.assertIn(result.returncode, (0, 1), result.stderr)
        return json.loads((self.folder / (clip.stem + ".run") / "report.json").read_text())

    def test_spline_ik_whose_twist_is_read_from_a_matrix_flips_at_180(self):
        clip = self.export(SPLINE_IK + DRIVEN_TWIST)
        self.write("rig.backbend.toml", 'schema = "backbend.sidecar/1"\n[[control]]\nchannel = "twist"\ncontrol = "chest"\naxis = "Y"\n')
        found = flips(self.report(clip))
        self.assertTrue(found)
        # The sidecar beside the clip says which control it was: each finding says what to set.
        for finding in found:
            self.assertIn("cmds.setAttr(\"chest.rotateY\", %g)" % finding["control_deg"], finding["artist"]["maya"])
        # Twist comes back to one reading at +180 and -180, and nowhere else in +-360.
        for finding in found:
            self.assertLessEqual(abs(abs(finding["control_deg"]) - 180), 2, finding)
        self.assertEqual({finding["control_deg"] > 0 for finding in found}, {True, False})

    def test_spline_ik_within_half_a_turn_does_not(self):
        clip = self.export(SPLINE_IK + DRIVEN_TWIST, stress=False)
        report = self.report(clip)
        self.assertEqual(flips(report), [])
        self.assertEqual([finding for finding in report["findings"] if finding["code"] in ("BB002", "BB049")], [])
        # Every two degrees: the sweep is as fine as a rig that answers evenly allows.
        self.assertTrue([line for line in report["detectors"] if line.startswith("flips by sweep:") and "twist 5" in line],
                        report["detectors"])

    def test_a_twist_that_the_chain_does_not_carry_fails_by_name(self):
        report = self.report(self.export(SPLINE_IK, stress=False))
        (found,) = [finding for finding in report["findings"] if finding["code"] == "BB049"]
        self.assertEqual((found["verdict"], found["sweep"]), ("fail", "twist"))
        self.assertLess(found["value"], 0.05)

    def test_a_b_bone_whose_handle_twists_flips_at_180_however_fine_it_is_cut(self):
        for segments in (5, 6, 8, 10, 16, 32):
            with self.subTest(segments):
                clip = self.export(B_BONE.replace("SEGMENTS", str(segments)), ["hips", "spine"])
                header = json.loads(clip.read_bytes().split(b"\n", 1)[0])
                self.assertEqual(header["spine"], ["hips"] + [f"spine.seg{k:02d}" for k in range(segments)])
                found = flips(self.report(clip))
                self.assertTrue(found)
                for finding in found:
                    self.assertLessEqual(abs(abs(finding["control_deg"]) - 180), 2, finding)

    def test_a_b_bone_within_half_a_turn_does_not(self):
        clip = self.export(B_BONE.replace("SEGMENTS", "5"), ["hips", "spine"], stress=False)
        self.assertEqual(flips(self.report(clip)), [])


class FakeMaya:
    """A scene of three joints, of which `chest` follows the attribute `ctl.rotateY` by half."""

    def __init__(self):
        self.value = {"ctl.rotateY": 5.0, "ctl.swing": 0.0}
        self.path = ["|hips", "|hips|grp|spine", "|hips|grp|spine|chest"]

    def objExists(self, name):
        return name in self.value or any(path.endswith("|" + name) for path in self.path)

    def ls(self, name, long):
        return [path for path in self.path if path.endswith("|" + name)]

    def listRelatives(self, root, allDescendents, type, fullPath):
        return list(reversed(self.path[1:]))

    def xform(self, name, query, worldSpace, matrix=False, translation=False):
        if translation:
            return [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
        half = math.radians(self.value["ctl.rotateY"] - 5.0) / 2
        turned = name.endswith("chest")
        c, s = (math.cos(half), math.sin(half)) if turned else (1.0, 0.0)
        # Row vectors, as Maya writes them.
        return [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 10.0 * self.path.index(name), 0, 1]

    def getAttr(self, name):
        return self.value[name]

    def setAttr(self, name, value):
        self.value[name] = value

    def upAxis(self, query, axis):
        return "y"

    def currentUnit(self, query, linear):
        return "cm"

    def about(self, version):
        return "2025"

    def file(self, query, sceneName):
        return "/studio/secret/hero.ma"


MAPPING = {"spine": ["hips", "spine", "chest"], "mesh": "body",
           "channels": {"twist": [{"control": "ctl", "channel": "ry", "per_degree": 2.0}]}}


class ExportingFromMaya(CommandTest):
    """The core of the Maya script, with a stand-in for maya.cmds."""

    def export(self, mapping=None, cmds=None):
        path = self.folder / "maya.clip"
        cmds = cmds or FakeMaya()
        backbend_maya.export_with(cmds, mapping or MAPPING, str(path), say=lambda line: None)
        header, numbers = path.read_bytes().split(b"\n", 1)
        return json.loads(header), numbers, cmds

    def test_joints_know_their_parents_across_groups(self):
        header, _, _ = self.export()
        self.assertEqual([(j["name"], j["parent"]) for j in header["joints"]],
                         [("hips", -1), ("spine", 0), ("chest", 1)])

    def test_every_value_of_a_sweep_is_a_pose_with_its_control(self):
        header, numbers, _ = self.export()
        values = [pose["controls"]["twist"] for pose in header["poses"]]
        self.assertEqual(values, list(range(-90, 91, 2)))
        self.assertEqual(len(numbers), 4 * len(values) * (16 * 3 + 3 * 2))

    def test_the_scene_is_left_as_it_was(self):
        _, _, cmds = self.export()
        self.assertEqual(cmds.value["ctl.rotateY"], 5.0)

    def test_no_path_of_the_studio_is_written(self):
        header, _, _ = self.export()
        self.assertEqual(header["source"]["file"], "hero.ma")

    def test_the_tool_reads_it(self):
        self.export(dict(MAPPING, spine=["hips", "spine", "chest"]))
        result = self.backbend("check", "--baked", "maya.clip", "-o", "out")
        self.assertIn(result.returncode, (0, 1), result.stderr)
        report = json.loads((self.folder / "out/report.json").read_text())
        self.assertEqual(flips(report), [])
        # Centimetres became metres.
        self.assertAlmostEqual(report["characters"][0]["spine_length"], 0.2, places=6)

    def test_mistakes_of_a_mapping_are_named(self):
        for change, words in (({"channels": {}}, "channels"),
                              ({"channels": {"bend": []}}, "'bend' is none of"),
                              ({"channels": {"twist": [{"control": "ctl"}]}}, "channels/twist/0/channel"),
                              ({"channels": {"twist": [{"control": "ctl", "channel": "rq"}]}}, "ctl.rq"),
                              ({"spine": ["hips"]}, "fewer than two"),
                              ({"spine": ["hips", "torso"]}, "'torso'"),
                              ({"root": "world"}, "'world'")):
            with self.subTest(words):
                with self.assertRaises(ValueError) as caught:
                    self.export(dict(MAPPING, **change))
                self.assertIn(words, str(caught.exception))
                self.assertFalse((self.folder / "maya.clip").exists())


class WritingClips(CommandTest):
    def test_a_writer_refuses_what_no_reader_takes(self):
        writer = backbend_clip.ClipWriter([("hips", -1, [1.0] * 16)])
        with self.assertRaises(ValueError):
            writer.add([[1.0] * 15])
        with self.assertRaises(ValueError):
            writer.add([[math.nan] * 16])
        with self.assertRaises(ValueError):
            writer.add([[1.0] * 16], points=[1.0])
        self.assertEqual(writer.header["poses"], [])

    def test_a_stress_sweep_stands_for_the_standard_one(self):
        names = [name for name, _ in backbend_clip.sweeps({"twist": [], "side": []}, stress=True)]
        self.assertEqual(sorted(names), ["side", "twist"])
        twist = dict(backbend_clip.sweeps({"twist": []}, stress=True))["twist"]
        self.assertEqual((twist[0], twist[-1], len(twist)), (-360, 360, 361))

    def test_every_channel_goes_to_the_end_of_the_envelope_and_to_its_corners(self):
        channels = {name: [] for name in ("extension", "flexion", "side", "twist")}
        for name, envelope in backbend_clip.ENVELOPES.items():
            found = backbend_clip.paths({"channels": channels, "envelope": name})
            for channel, needs in envelope.items():
                reached = [pose[channel] for pose in dict(found)[channel]]
                self.assertGreaterEqual(max(reached), needs, (name, channel))
            ends = [poses[-1] for path, poses in found if path.startswith("corner ")]
            self.assertEqual(len(ends), 20, name)
            self.assertIn({"extension": envelope["extension"], "side": -envelope["side"], "twist": envelope["twist"]}, ends)
            self.assertEqual({abs(value) for value in found[-1][1][-1].values()}, {0}, "the way back ends at rest")

    def test_its_corners_and_names_are_those_of_the_program(self):
        told = json.loads(self.assert_runs("list", "sweeps", "--json").stdout)
        program = {row["name"] for row in told if row["name"].startswith("corner ")}
        channels = {name: [] for name in ("extension", "flexion", "side", "twist")}
        ours = {name for name, _ in backbend_clip.corners(channels, backbend_clip.ENVELOPES["human"])}
        self.assertEqual(ours, program)

    def test_compound_poses_are_tried_between_them(self):
        channels = {name: [] for name in ("extension", "flexion", "side", "twist")}
        found = backbend_clip.paths({"channels": channels})
        beyond = [name for name, poses in found for pose in poses
                  if pose.get("extension", 0) >= 80 and pose.get("side", 0) >= 20 and pose.get("twist", 0) >= 45]
        self.assertGreaterEqual(len(beyond), 8)

    def test_one_control_takes_the_sum_of_its_channels(self):
        ctl = [{"control": "chest", "channel": "rx", "per_degree": -1}]
        mapping = {"spine": ["a", "b"], "channels": {"extension": ctl, "side": ctl}}
        now, seen = {}, []
        writer = backbend_clip.ClipWriter([("a", -1, [0.0] * 16)])
        backbend_clip.record(mapping, False, lambda control, channel, value: now.update({channel: value}),
                             lambda: (seen.append(now["rx"]) or [[0.0] * 16], []), writer, say=lambda text: None)
        poses = writer.header["poses"]
        self.assertEqual(len(poses), len(seen))
        for pose, value in zip(poses, seen):
            self.assertAlmostEqual(-sum(pose["controls"].values()), value)
        self.assertEqual(now["rx"], 0, "the control is left at rest")

    def test_a_wrong_envelope_of_a_mapping_is_named(self):
        mapping = {"spine": ["a", "b"], "channels": {"twist": [{"control": "c", "channel": "rx"}]}}
        for envelope in ("horse", {"bend": 3}, {"side": -3}, 5):
            with self.assertRaises(ValueError) as caught:
                backbend_clip.check_mapping(dict(mapping, envelope=envelope))
            self.assertIn("envelope", str(caught.exception))
