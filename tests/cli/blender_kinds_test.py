"""What rigs in Blender are made of, each asked live: constraints, Spline IK, B-Bones in a row, linked and overridden
characters. The faults that are planted are found, and what does not arrive is said."""

import json
import math
import shutil
import subprocess
import unittest

import bridges_test
import harness
from blender_rig_test import BlenderRig
from harness import CommandTest, SOURCE

# The bones follow the control by constraints alone: a quarter of its turn each.
CONSTRAINTS = """
rig.animation_data_clear()
for k in range(1, 5):
    posed = rig.pose.bones[f"spine{k}"]
    copied = posed.constraints.new("COPY_ROTATION")
    copied.target, copied.subtarget = rig, "chest_ctl"
    copied.target_space = copied.owner_space = "LOCAL"
    copied.mix_mode, copied.influence = "ADD", 0.25
"""

# The bones follow a curve whose ends are hooked to two controls.
SPLINE_IK = """
rig.animation_data_clear()
bpy.ops.object.mode_set(mode="EDIT")
low = data.edit_bones.new("hips_ctl")
low.head, low.tail, low.use_deform = (0, 0, 0), (0, 0, 0.2), False
bpy.ops.object.mode_set(mode="OBJECT")
line = bpy.data.curves.new("line", "CURVE")
line.dimensions = "3D"
spline = line.splines.new("BEZIER")
spline.bezier_points.add(1)
for point, height in zip(spline.bezier_points, (0, 1)):
    point.handle_left_type = point.handle_right_type = "FREE"
    point.co = (0, 0, height)
    point.handle_left, point.handle_right = (0, 0, height - 0.4), (0, 0, height + 0.4)
curve = bpy.data.objects.new("line", line)
bpy.context.collection.objects.link(curve)
for name, points in (("hips_ctl", [0, 1, 2]), ("chest_ctl", [3, 4, 5])):
    hook = curve.modifiers.new(name, "HOOK")
    hook.object, hook.subtarget = rig, name
    hook.matrix_inverse = (rig.matrix_world @ rig.pose.bones[name].matrix).inverted() @ curve.matrix_world
    hook.vertex_indices_set(points)
ik = rig.pose.bones["spine4"].constraints.new("SPLINE_IK")
ik.target, ik.chain_count, ik.y_scale_mode = curve, 5, "MODE"
"""

LINK = """
import bpy, sys
how, library, out = sys.argv[-3:]
bpy.ops.wm.read_factory_settings(use_empty=True)
with bpy.data.libraries.load(library, link=True) as (there, here):
    here.collections = ["Collection"]
found = bpy.data.collections["Collection"]
if how == "linked":
    bpy.context.scene.collection.children.link(found)
else:
    stand = bpy.data.objects.new("hero", None)
    stand.instance_type, stand.instance_collection = "COLLECTION", found
    bpy.context.scene.collection.objects.link(stand)
if how == "overridden":
    bpy.context.view_layer.update()
    found.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, reference=stand)
bpy.ops.wm.save_as_mainfile(filepath=out)
"""


def of(report, code):
    return [finding for finding in report["findings"] if finding["code"] == code]


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Kinds(BlenderRig, CommandTest):
    def flips(self, report, sweep):
        return [finding for finding in of(report, "BB001") if finding["sweep"] == sweep]

    def test_constraints_are_evaluated_and_one_whose_influence_jumps_is_found(self):
        self.make(more=CONSTRAINTS)
        healthy = self.night(*self.ALL, code=None)
        self.assertEqual(of(healthy, "BB001") + of(healthy, "BB049"), [])
        self.make(more=CONSTRAINTS + """
driver = copied.driver_add("influence").driver
variable = driver.variables.new()
variable.targets[0].id, variable.targets[0].data_path = rig, 'pose.bones["chest_ctl"].rotation_euler[1]'
driver.expression = "0.25 if var < 0.7 else 0.75"
""")
        found = self.flips(self.night(*self.ALL, code=1), "twist")
        self.assertEqual(len(found), 1)
        self.assertAlmostEqual(found[0]["control_deg"], math.degrees(0.7), delta=60e-4)
        self.assertAlmostEqual(found[0]["value"], math.degrees(0.7) / 2, delta=0.2)

    def test_spline_ik_bends_in_every_scale_mode_and_does_not_carry_the_chests_twist(self):
        for mode in ("NONE", "FIT_CURVE", "BONE_ORIGINAL"):
            with self.subTest(mode):
                self.make(more=SPLINE_IK.replace("MODE", mode))
                report = self.night(*self.ALL, code=1)
                lost = of(report, "BB049")
                self.assertEqual([finding["sweep"] for finding in lost], ["twist"], lost)
                self.assertIn("nothing of it arrives", lost[0]["detail"])
                self.assertEqual(lost[0]["verdict"], "fail")
                self.assertEqual(of(report, "BB001") + of(report, "BB044"), [])
                measured = {row["channel"]: row["measured"] for row in report["rigs"][0]["headroom"]}
                self.assertEqual(measured, {"extension": True, "flexion": True, "side": True, "twist": False})

    def test_presets_find_the_control_at_the_end_of_the_curve(self):
        handles = """
bpy.ops.object.mode_set(mode="EDIT")
low = data.edit_bones.new("hips_ctl")
low.head, low.tail, low.use_deform = (0, 0, -0.2), (0, 0, 0), False
top = data.edit_bones["spine4"]
top.bbone_handle_type_start = top.bbone_handle_type_end = "ABSOLUTE"
top.bbone_custom_handle_start, top.bbone_custom_handle_end = data.edit_bones["spine3"], data.edit_bones["chest_ctl"]
bpy.ops.object.mode_set(mode="OBJECT")
"""
        for preset, more, segments, lost in (("spline_ik", SPLINE_IK.replace("MODE", "FIT_CURVE"), 1, ["twist"]),
                                             ("b_bone", handles, 4, [])):
            with self.subTest(preset):
                self.make(more=more, segments=segments)
                self.preset = preset
                report = self.night(*self.ALL, code=1 if lost else None)
                self.assertEqual([finding["sweep"] for finding in of(report, "BB049")], lost)

    def test_b_bones_in_a_row_are_one_chain_of_segments(self):
        self.make(segments=4, flip='"+ (0.5235987755982988 if var > 0.7 else 0)"')
        report = self.night(*self.ALL, code=1)
        found = self.flips(report, "twist")
        self.assertTrue(found)
        for finding in found:
            self.assertAlmostEqual(finding["control_deg"], math.degrees(0.7), delta=60e-4)
        self.assertTrue([note for note in report["characters"][0]["notes"] if "segments" in note])

    def test_an_export_whose_drivers_are_disabled_is_refused_by_name(self):
        path = self.make(flip='"+ jump(var)"', more="""
text = bpy.data.texts.new("functions.py")
text.write("import bpy\\nbpy.app.driver_namespace['jump'] = lambda v: 2.0 if v > 0.7 else 0.0\\n")
text.use_module = True
""")
        mapping = self.write("export.json", json.dumps({**self.MAPPING, "spine": [f"spine{k}" for k in range(5)]}))
        clip = self.folder / "hero.clip"
        for words, code in (([], 3), (["--enable-autoexec"], 0)):
            told = subprocess.run(["blender", "--background", *words, str(path), "--python",
                                   str(SOURCE / "scenes/bridges/backbend_blender.py"), "--", str(mapping), str(clip)],
                                  capture_output=True, text=True, env=harness.bare_environment(self.folder),
                                  timeout=harness.PATIENCE_S)
            self.assertEqual(told.returncode, code, told.stdout + told.stderr)
            self.assertEqual(clip.is_file(), code == 0)
            if code:
                self.assertIn("start Blender with --enable-autoexec", told.stderr)
                self.assertIn("jump(var)", told.stderr)

    def linked(self, how, library):
        """The rig of another file, in a scene of its own."""
        made = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
                               str(self.write("link.py", LINK)), "--", how, str(library), str(self.folder / "hero.blend")],
                              capture_output=True, text=True, env=harness.bare_environment(self.folder), timeout=harness.PATIENCE_S)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)

    def test_linked_instanced_and_overridden_characters_are_asked_as_their_own_file_is(self):
        path = self.make(flip='"+ (0.5235987755982988 if var > 0.7 else 0)"', more="""
own = bpy.data.collections.new("Collection")
bpy.context.scene.collection.children.link(own)
own.objects.link(rig)
bpy.context.scene.collection.objects.unlink(rig)
""")
        library = path.rename(self.folder / "library.blend")
        for how in ("linked", "instanced", "overridden"):
            with self.subTest(how):
                self.linked(how, library)
                report = self.night(("twist", 60), code=1)
                found = self.flips(report, "twist")
                self.assertEqual(len(found), 1)
                self.assertAlmostEqual(found[0]["control_deg"], math.degrees(0.7), delta=60e-4)
                self.assertAlmostEqual(found[0]["value"], 30, delta=0.3)


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Rolls(CommandTest):
    """A B-Bone whose end handle passes half a turn, in a clip of every 2 degrees."""

    def test_it_is_found_however_finely_the_bone_is_cut(self):
        for segments in (6, 8, 10, 16, 32):
            with self.subTest(segments):
                clip = self.folder / "rig.clip"
                rig = bridges_test.B_BONE.replace("bbone_segments = 5", f"bbone_segments = {segments}")
                script = self.write("make.py", rig + bridges_test.EXPORT.format(
                    folder=str(bridges_test.BRIDGES), spine=["hips", "spine"], path=str(clip), stress=True))
                told = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "9", "--python",
                                       str(script)], capture_output=True, text=True, timeout=harness.PATIENCE_S)
                self.assertEqual(told.returncode, 0, told.stdout + told.stderr)
                self.assert_runs("check", "--baked", clip, "--quick", "-o", "run", code=1)
                found = of(json.loads((self.folder / "run/report.json").read_text()), "BB001")
                self.assertTrue(found)
                for finding in found:
                    self.assertLessEqual(abs(abs(finding["control_deg"]) - 180), 2, finding)


if __name__ == "__main__":
    unittest.main()
