"""The Blender add-on: its operators, as a script calls them, on rigs with a known fault."""

import json
import math
import os
import shutil
import stat
import subprocess
import sys
import unittest

import glb
import harness
from blender_rig_test import Blender, hero
from external_rig_test import mesh_of
from harness import BACKBEND, CommandTest, PATIENCE_S, SOURCE, human

ADDON = SOURCE / "scenes/bridges/backbend_addon.py"
# chest_ctl turns five bones; one of them jumps by 30 degrees once the twist passes 0.7 rad.
FLIP = '"+ (0.5235987755982988 if var > 0.7 else 0)"'

# Before a test's own lines: what they say goes to a file, since Blender prints to both streams itself.
BEFORE = """
import bpy, json, math, sys
import backbend_addon as addon
RESULT = sys.argv[-1]
def say(**words):
    with open(RESULT, "w") as file:
        json.dump(words, file)
def call(operator, **options):
    try:
        return sorted(operator(**options)), ""
    except RuntimeError as error:  # what an operator reports as ERROR
        return ["ERROR"], str(error)
"""


# The human imported as an artist has it: meshes under an armature whose bones are the controls.
STRAYS = """
import addon_utils, builtins, numpy
for name in ("bool", "float", "int", "object"):
    if name not in vars(numpy):
        setattr(numpy, name, getattr(builtins, name))
addon_utils.enable("io_scene_gltf2")
bpy.data.batch_remove(list(bpy.data.objects))
bpy.ops.import_scene.gltf(filepath=sys.argv[-2])
rig = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
body = addon.bodies_of(rig)[0]
MORE
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-3])
"""


class AddonTest:
    """Blender with the add-on, and two scenes for it."""

    def setUp(self):
        if not shutil.which("blender"):
            self.skipTest("Blender is not installed")
        super().setUp()

    def environment(self, program, **more):
        # Blender takes its Python's modules from beside the first python3 of the PATH: the system's, not the test's.
        path = os.path.dirname(shutil.which("blender")) + os.pathsep + os.environ["PATH"]
        return {**harness.bare_environment(self.folder, BLENDER_USER_SCRIPTS=str(self.folder / "scripts"),
                                           BACKBEND_PROGRAM=str(program), **more), "PATH": path}

    def blender(self, scene, lines, program=BACKBEND, code=0, display=()):
        """Opens a scene with the add-on switched on, as an artist has it, and runs lines there; what they say.
        `display`: a command that gives Blender one, for a window."""
        addons = self.folder / "scripts/addons"
        addons.mkdir(parents=True, exist_ok=True)
        shutil.copy(ADDON, addons)
        result = self.folder / "result.json"
        result.unlink(missing_ok=True)
        told = subprocess.run([*display, "blender", *([] if display else ["--background"]), "--factory-startup",
                               "--addons", "backbend_addon", *([scene] if scene else []),
                               "--python-exit-code", "9", "--python", self.write("lines.py", BEFORE + lines), "--", result],
                              cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE_S,
                              env=self.environment(program))
        self.assertEqual(told.returncode, code, told.stdout + told.stderr)
        return json.loads(result.read_text())

    def make(self, flip='""', more=""):
        """A tube on five bones under one control, its mesh bound, hips and chest named in the sidecar."""
        return self.made_once(("tube", flip, more), ("hero.blend", "hero.backbend.toml"), lambda: self.make_tube(flip, more))

    def make_tube(self, flip, more):
        tube = self.write("tube.glb", glb.tube([f"spine{k}" for k in range(5)], unit=1.0 / 1.6, rings=17, sides=8))
        mesh = self.write("mesh.json", json.dumps(mesh_of(tube)))
        body = Blender.BODY.replace("MESH", repr(str(mesh))).replace("SHAPE", "0")
        hero(self.folder, flip, body + more)
        self.assert_runs("inspect", tube, "--hip", "spine0", "--chest", "spine4", "--save", "--quiet")
        (self.folder / "tube.backbend.toml").rename(self.folder / "hero.backbend.toml")

    def human_in_blender(self, more=""):
        """The bundled human with vertices of its belly bound to a hand, imported."""
        return self.made_once(("human", more), ("human.blend",), lambda: self.import_human(more))

    def import_human(self, more):
        strays = self.write("strays.glb", glb.with_strays(human(1500).read_bytes()))
        scene = self.folder / "human.blend"
        self.blender(None, f"sys.argv[-1:] = [{str(scene)!r}, {str(strays)!r}, RESULT]\n" + STRAYS.replace("MORE", more) + "\nsay()")
        self.assertTrue(scene.is_file())

    def program(self, text):
        path = self.write(f"program {len(list(self.folder.glob('program *')))}/backbend", f"#!{sys.executable}\n{text}")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return path


class Judge(AddonTest, CommandTest):
    def test_a_flip_is_found_and_a_click_takes_the_control_there_with_its_heat(self):
        scene = self.make(FLIP)
        before = scene.read_bytes()
        said = self.blender(scene, """
rig = bpy.data.objects["rig"]
control = rig.pose.bones["chest_ctl"]
bpy.context.scene.backbend.envelope = "human"
control.rotation_euler[0] = 0.25  # a pose that the artist works on
ended, error = call(bpy.ops.backbend.judge)
kept = list(control.rotation_euler)
control.rotation_euler = (0, 0, 0)
lists = bpy.context.window_manager.backbend
findings = addon.SESSION.findings
flip = next(k for k, finding in enumerate(findings) if finding["code"] == "BB001" and finding["sweep"] == "twist")
call(bpy.ops.backbend.show_finding, index=flip)
shown = [math.degrees(angle) for angle in control.rotation_euler]
mesh = bpy.data.objects["body"].data
layer = mesh.color_attributes.get(addon.HEAT)
colours = {tuple(round(c, 3) for c in each.color) for each in layer.data} if layer else set()
active = mesh.color_attributes.active_color.name if layer else ""
call(bpy.ops.backbend.rest)
say(ended=ended, error=error, kept=kept, shown=shown, colours=len(colours), grey=(0.5, 0.5, 0.5, 1.0) in colours, active=active,
    rest=list(control.rotation_euler), left=mesh.color_attributes.get(addon.HEAT) is not None, rows=[row.name for row in lists.findings],
    owners=[row.owner for row in lists.findings], headroom={row.name: row.share for row in lists.headroom},
    texts=[row.text for row in lists.headroom], pose=findings[flip]["pose"], advice=addon.SESSION.advice.get("BB001", ""),
    page=(addon.SESSION.folder / "index.html").is_file(), mapping=addon.SESSION.mapping, path=bpy.data.filepath)
""")
        self.assertEqual((said["ended"], said["error"]), (["FINISHED"], ""))
        self.assertEqual(scene.read_bytes(), before)
        self.assertEqual(said["path"], str(scene))
        self.assertAlmostEqual(said["kept"][0], 0.25, places=6)
        # The jump is at 0.7 rad of the control's Y axis, and nothing else is turned.
        self.assertRegex(said["pose"], r"^twist -?40\.1")
        self.assertAlmostEqual(abs(said["shown"][1]), math.degrees(0.7), delta=0.01)
        self.assertEqual([said["shown"][0], said["shown"][2]], [0, 0])
        self.assertEqual(said["mapping"]["channels"]["twist"][0]["control"], "chest_ctl")
        self.assertGreater(said["colours"], 3)
        self.assertFalse(said["grey"])  # every vertex of the mesh has its own
        self.assertEqual(said["active"], "backbend heat")
        self.assertEqual((said["rest"], said["left"]), ([0, 0, 0], False))
        self.assertIn("BB001 flip", said["rows"])
        self.assertIn("RIG", said["owners"])
        self.assertLess(said["headroom"]["twist"], 1)
        self.assertRegex("; ".join(said["texts"]), r"twist: clean to (3\d|40), required \d+")
        self.assertGreater(len(said["advice"]), 20)
        self.assertTrue(said["page"])

    def test_a_control_keeps_its_rotation_mode(self):
        scene = self.make(FLIP)
        self.write("hero.map.json", json.dumps(Blender.MAPPING))
        said = self.blender(scene, """
bpy.context.scene.backbend.quick = True
control = bpy.data.objects["rig"].pose.bones["chest_ctl"]
call(bpy.ops.backbend.judge)
out = []
for mode in ("XYZ", "QUATERNION", "AXIS_ANGLE"):
    control.rotation_mode = mode
    addon.set_controls(bpy.data.objects["rig"], addon.control_values(addon.SESSION.mapping["channels"],
                       {"extension": 30.0, "twist": 50.0, "side": -20.0}), {})
    bpy.context.view_layer.update()
    out.append([control.rotation_mode, [round(v, 4) for row in control.matrix_basis for v in row]])
say(out=out, quick=addon.heat_file(addon.SESSION.findings[0]) is None)
""")
        modes, matrices = zip(*said["out"])
        self.assertEqual(modes, ("XYZ", "QUATERNION", "AXIS_ANGLE"))
        for matrix in matrices[1:]:
            for a, b in zip(matrix, matrices[0]):
                self.assertAlmostEqual(a, b, delta=2e-4)
        self.assertNotAlmostEqual(matrices[0][0], 1, delta=0.01)
        self.assertTrue(said["quick"])  # without pictures there is no heat, which is not an error

    def test_the_page_is_opened(self):
        scene = self.make()
        said = self.blender(scene, """
import webbrowser
opened = []
webbrowser.open = opened.append
without = call(bpy.ops.backbend.open_page)
bpy.context.scene.backbend.quick = True
call(bpy.ops.backbend.judge)
call(bpy.ops.backbend.open_page)
say(without=without, opened=opened)
""")
        self.assertIn("judge the rig first", said["without"][1])
        self.assertRegex(said["opened"][0], r"^file:///.*/index\.html$")


class Repair(AddonTest, CommandTest):
    REPAIR = """
rig = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
body = addon.bodies_of(rig)[0]
def weights():
    names = [group.name for group in body.vertex_groups]
    return [{names[each.group]: round(each.weight, 5) for each in vertex.groups if each.weight > 0} for vertex in body.data.vertices]
before = weights()
body.vertex_groups.new(name="cloth").add([0, 1, 2], 0.5, "REPLACE")
ended, error = call(bpy.ops.backbend.repair)
after = weights()
changed = [k for k in range(len(before)) if before[k] != {n: w for n, w in after[k].items() if n != "cloth"}]
hands = lambda of: sum(1 for each in of if each.get("hand_L", 0) > 0.9)
say(ended=ended, error=error, said=addon.SESSION.said, changed=len(changed), total=len(before), cloth=sum(1 for each in after if "cloth" in each),
    gone=hands(before) - hands(after), sums=max(abs(sum(w for n, w in each.items() if n != "cloth") - 1) for each in after))
"""

    def test_stray_weights_are_repaired_in_the_vertex_groups(self):
        said = self.blender(self.human_in_blender(), self.REPAIR)
        self.assertEqual((said["ended"], said["error"]), (["FINISHED"], ""))
        self.assertRegex(said["said"], r"^weights of \d+ vertices repaired; failures left: 0$")
        self.assertGreaterEqual(said["gone"], 1)  # those of the belly that were bound to the hand
        self.assertLess(said["changed"], said["total"] / 20)
        self.assertEqual(said["cloth"], 3)  # a group that is not a joint's is left alone
        self.assertLess(said["sums"], 1e-3)

    def test_an_armature_that_is_scaled_and_turned_has_the_same_places(self):
        scene = self.human_in_blender("rig.scale = (0.01, 0.01, 0.01)\nrig.rotation_euler[2] = 0.7\nrig.location = (3, 4, 5)")
        said = self.blender(scene, self.REPAIR)
        self.assertEqual((said["ended"], said["error"]), (["FINISHED"], ""))
        self.assertGreaterEqual(said["gone"], 1)

    def test_a_locked_group_stops_it_before_anything_is_set(self):
        scene = self.human_in_blender('body.vertex_groups["hand_L"].lock_weight = True')
        said = self.blender(scene, self.REPAIR)
        self.assertEqual(said["ended"], ["ERROR"])
        self.assertIn("'hand_L' is locked", said["error"])
        self.assertEqual(said["changed"], 0)


class Undo(AddonTest, CommandTest):
    """As from the panel, in a window: without one Blender keeps no history."""

    # Each step of the generator is run when what the one before began has ended, from Blender's own loop. `found()` is
    # what the test looks at; names are looked up anew, for undo replaces everything.
    STEPS = """
def steps():
    first = found()
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        begun = sorted(bpy.ops.backbend.OPERATOR("INVOKE_DEFAULT"))
    yield
    then, error, words = found(), addon.SESSION.error, addon.SESSION.said
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.ed.undo()
    yield
    back = found()
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.ed.redo()
    yield
    say(begun=begun, error=error, said=words, first=first, then=then, back=back, again=found())
def go_on(all_steps=steps()):
    if addon.SESSION.work is not None:
        return 0.1
    try:
        next(all_steps)
        return 0.1
    except StopIteration:
        bpy.ops.wm.quit_blender()
    except BaseException:
        import os, traceback
        traceback.print_exc()
        os._exit(9)
bpy.app.timers.register(go_on, first_interval=0.1, persistent=True)
"""

    def undone(self, operator, scene, found):
        if not shutil.which("xvfb-run"):
            self.skipTest("xvfb-run (Debian: xvfb) is not installed")
        said = self.blender(scene, found + self.STEPS.replace("OPERATOR", operator),
                            display=["xvfb-run", "-a", "-s", "-screen 0 1280x720x24"])
        self.assertEqual((said["begun"], said["error"]), (["RUNNING_MODAL"], ""))
        self.assertNotEqual(said["then"], said["first"], said["said"])
        self.assertEqual(said["back"], said["first"])
        self.assertEqual(said["again"], said["then"])
        return said

    def test_one_step_takes_repaired_weights_back(self):
        said = self.undone("repair", self.human_in_blender(), """
def found():
    rig = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
    body = addon.bodies_of(rig)[0]
    return [sorted((body.vertex_groups[each.group].name, round(each.weight, 5)) for each in vertex.groups) for vertex in body.data.vertices]
""")
        self.assertRegex(said["said"], r"^weights of \d+ vertices repaired")

    def test_one_step_takes_the_exported_rig_back(self):
        said = self.undone("export_even", self.make(), """
def found():
    rig = bpy.data.objects["rig"]
    return [sorted(thing.name for kind in (bpy.data.objects, bpy.data.collections, bpy.data.armatures, bpy.data.node_groups) for thing in kind),
            sorted(bone.name for bone in rig.data.bones),
            sorted((bone.name, constraint.type, constraint.name) for bone in rig.pose.bones for constraint in bone.constraints),
            sorted((curve.data_path, curve.array_index) for curve in rig.animation_data.drivers) if rig.animation_data else [],
            sorted(rig.keys())]
""")
        self.assertEqual(said["said"], "the rig `even` is in this file")


class Trouble(AddonTest, CommandTest):
    def refused(self, operator, program, scene=None, before=""):
        return self.blender(scene or self.make(), before + f"""
ended, error = call(bpy.ops.backbend.{operator})
say(ended=ended, error=error, kept=addon.SESSION.error, work=addon.SESSION.work is None)
""", program)

    def test_a_backbend_that_is_missing_or_fails_is_one_line_in_the_panel(self):
        scene = self.make()
        for program, says in ((self.folder / "nowhere/backbend", "no such program; install backbend"),
                              (self.program("import sys; print('lost its way', file=sys.stderr); sys.exit(70)"),
                               "lost its way (exit code 70)"),
                              (self.program("import os; os.kill(os.getpid(), 11)"), "exit code -11"),
                              (self.program("print('not JSON')"), "something else than JSON")):
            with self.subTest(says):
                # Both in one Blender; the panel's line is taken away between them, so that each has to say its own.
                for said in self.blender(scene, """
told = {}
for name in ("judge", "repair"):
    ended, error = call(getattr(bpy.ops.backbend, name))
    told[name] = dict(ended=ended, error=error, kept=addon.SESSION.error, work=addon.SESSION.work is None)
    addon.SESSION.error = ""
say(**told)
""", program).values():
                    self.assertEqual(said["ended"], ["ERROR"])
                    self.assertIn(says, said["error"])
                    self.assertEqual(len(said["kept"].splitlines()), 1)
                    self.assertIn(said["kept"], said["error"])
                    self.assertTrue(said["work"])

    def test_a_driver_that_is_not_valid_is_named(self):
        said = self.refused("judge", BACKBEND, self.make('" + no_such_function(var)"'))
        self.assertIn("no_such_function", said["error"])

    def test_a_file_without_a_body_says_so(self):
        said = self.refused("judge", BACKBEND, before='bpy.data.objects.remove(bpy.data.objects["body"])\n'
                                                     'bpy.context.view_layer.objects.active = bpy.data.objects["rig"]\n')
        self.assertIn("deforms no mesh", said["error"])

    def test_a_finding_before_a_result_is_an_error(self):
        said = self.blender(self.make(), """
say(shown=call(bpy.ops.backbend.show_finding, index=3), rest=call(bpy.ops.backbend.rest))
""")
        self.assertIn("no such finding", said["shown"][1])
        self.assertIn("judge the rig first", said["rest"][1])

    def test_cancel_ends_what_is_going_on(self):
        program = self.program("import time; time.sleep(600)")
        said = self.blender(self.make(), """
import threading, time
def soon():
    while addon.SESSION.work is None or addon.SESSION.work.child is None or "backbend" not in " ".join(map(str, addon.SESSION.work.child.args)[:1]):
        time.sleep(0.1)
    addon.SESSION.work.cancel()
threading.Thread(target=soon, daemon=True).start()
begun = time.monotonic()
ended, error = call(bpy.ops.backbend.judge)
say(ended=ended, error=error, kept=addon.SESSION.error, seconds=time.monotonic() - begun)
""".replace('"backbend" not in " ".join(map(str, addon.SESSION.work.child.args)[:1])',
            'not str(addon.SESSION.work.child.args[0]).endswith("backbend")'), program)
        self.assertEqual((said["ended"], said["kept"]), (["CANCELLED"], "cancelled"))
        self.assertLess(said["seconds"], 100)

    def test_export_says_where_it_is_not_there(self):
        program = self.program("import sys; sys.exit(2)")
        said = self.refused("export_even", program)
        self.assertIn("has no `export even`", said["error"])

    def test_an_exported_script_is_run_and_one_that_fails_is_said(self):
        writes = "import sys\nif '-o' in sys.argv: open(sys.argv[sys.argv.index('-o') + 1], 'w').write({!r})"
        scene = self.make()
        said = self.blender(scene, """
call(bpy.ops.backbend.export_even)
say(made="even on rig" in bpy.data.objects)
""", self.program(writes.format("import bpy\ndef build(armature):\n    bpy.data.objects.new('even on ' + armature.name, None)\n")))
        self.assertTrue(said["made"])
        said = self.refused("export_even", self.program(writes.format("1 / 0\n")), scene)
        self.assertIn("ZeroDivisionError", said["kept"])


if __name__ == "__main__":
    unittest.main()
