"""backbend export even: the spine as a native rig for Blender, for Maya and as a graph, held to the solver."""

import json
import math
import os
import shutil
import subprocess
import sys
import unittest
from unittest import mock

import maya_scene
from blender_rig import BlenderRig
from even_native import Distance, graph_pose, inverse, largest_gain, random_poses, solver_poses, times
from glb import tube
import harness
from harness import BAD_INPUT, CANNOT_WRITE, USAGE, CommandTest, character, human
from maya_rig import MayaRig, maya_name

BLENDER = shutil.which("blender")
CHARACTERS = ["mh_male_13k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb"]
COLUMN_HINTS = ["--hip", "hips", "--chest", "chest"]
ANIMALS = ["alpaca.glb", "apatosaurus.glb"]

# What is promised of a native spine over poses to +-180 degrees of all channels.
MOST_TURN_DEG, MOST_PLACE_PERCENT, MOST_GAIN = 1e-4, 0.05, 1.001


class ExportTest:
    def export(self, program, glb, rig="even", *more):
        """Writes the file, and gives its path."""
        file = self.folder / f"even_{program}.{'json' if program == 'json' else 'py'}"
        self.assert_runs("export", rig, "--to", program, "--for", glb, "-o", file, *more)
        return file

    def column(self, joints):
        """A tube with so many joints above its hips."""
        names = ["hips", *(f"spine_{k}" for k in range(1, joints)), "chest", "neck", "head"]
        return self.write(f"column_{joints}.glb", tube(names, rings=4 * joints + 8))

    def graph(self, glb, rig="even", *more):
        return json.loads(self.export("json", glb, rig, *more).read_text())

    def assert_near(self, graph, spines, exact, turn_deg=MOST_TURN_DEG):
        distance = Distance(graph["length"])
        for spine, solved in zip(spines, exact, strict=True):
            distance.add(spine, solved)
        self.assertLessEqual(distance.turn_deg, turn_deg)
        self.assertLessEqual(distance.place_percent, MOST_PLACE_PERCENT)
        return distance


class TheGraph(ExportTest, CommandTest):
    def test_evaluated_as_documented_it_is_the_solvers_spine(self):
        poses = random_poses(60, 1)
        for rig in ("even", "even:weights=[[0, 0.5], [0.5, 1]],twist=anatomical,bones=4"):
            graph = self.graph(human(1500), rig)
            options = "" if rig == "even" else 'weights = [[0, 0.5], [0.5, 1]]\ntwist = "anatomical"\nbones = 4\n'
            # Both in double precision: what turns differ by is rounding.
            exact = solver_poses(graph, poses, self.folder, options)
            self.assert_near(graph, [graph_pose(graph, pose) for pose in poses], exact, 1e-9)

    def test_at_rest_every_joint_stands_where_the_file_has_it(self):
        graph = self.graph(human(1500))
        for joint, (turn, place) in zip(graph["joints"], graph_pose(graph, [0.0] * 9)):
            self.assertLess(math.dist(place, joint["rest"][12:15]), 1e-9 * graph["length"], joint["name"])
            self.assertLess(max(abs(turn[i][j] - (i == j)) for i in range(3) for j in range(3)), 1e-12)

    def test_the_distance_that_it_states_is_what_the_solver_is_off(self):
        graph = self.graph(human(1500))
        self.assertLessEqual(graph["distance"]["place_percent"], 0.03)
        self.assertLess(graph["distance"]["turn_deg"], 1e-9)
        poses = random_poses(200, 2)
        found = self.assert_near(graph, [graph_pose(graph, pose) for pose in poses],
                                 solver_poses(graph, poses, self.folder))
        # Others of the same kind, a tenth as many: neither far above nor nothing.
        self.assertLess(found.place_percent, 1.5 * graph["distance"]["place_percent"])
        self.assertGreater(found.place_percent, 0.1 * graph["distance"]["place_percent"])

    def test_no_joint_turns_faster_than_a_channel(self):
        graph = self.graph(human(1500))
        self.assertLessEqual(largest_gain(lambda poses: [graph_pose(graph, pose) for pose in poses],
                                          random_poses(90, 3)), 1 + 1e-9)

    def test_arms_go_with_the_joint_that_they_hang_from(self):
        for name in CHARACTERS:
            graph = self.graph(character(name))
            self.assertEqual(len(graph["followers"]), 2, name)
            self.assertEqual({each["leader"] for each in graph["followers"]}, {graph["joints"][-1]["name"]}, name)

    def test_a_spine_of_one_joint_and_one_of_twenty_are_exported(self):
        for joints in (1, 20):
            graph = self.graph(self.column(joints), "even", *COLUMN_HINTS)
            self.assertEqual(len(graph["joints"]), joints)
            poses = random_poses(24, joints)
            self.assert_near(graph, [graph_pose(graph, pose) for pose in poses],
                             solver_poses(graph, poses, self.folder), 1e-9)

    def test_animals_are_exported(self):
        for name in ANIMALS:
            graph = self.graph(character(name))
            self.assertGreaterEqual(len(graph["joints"]), 1)
            self.assertLessEqual(graph["distance"]["place_percent"], 0.03, name)

    def test_the_same_file_gives_the_same_bytes(self):
        first = self.export("json", human(1500)).read_bytes()
        again = self.export("json", human(1500), "even", "--threads", "1").read_bytes()
        self.assertEqual(first, again)

    def test_check_takes_the_rig_that_is_written(self):
        graph = self.graph(human(1500))
        result = self.backbend("check", human(1500), "--rig", graph["rig"], "--quick", "-o", "run")
        self.assertIn(result.returncode, (0, 1), result.stderr)
        report = json.loads((self.folder / "run/report.json").read_text())
        self.assertEqual([each["code"] for each in report["findings"] if each["code"] == "BB001"], [])


class WhatCannotBeExported(ExportTest, CommandTest):
    def export_refused(self, *words, code=BAD_INPUT, names=(), rig="even", glb=None, out="out.json", to="json"):
        return self.assert_refused("export", rig, "--to", to, "--for", glb or human(1500), "-o", out, *words, code=code,
                                   names=names)

    def test_another_rig_or_an_option_that_is_no_product(self):
        self.export_refused(rig="curve", names=["curve", "even"])
        self.export_refused(rig="even:reach=1", names=["reach"])
        self.export_refused(rig="even:limits=human", names=["limits"])
        self.export_refused(rig="even:stretchiness=1", names=["stretchiness"])
        self.export_refused(rig="even:joints=[0, 1]", names=["joints"])

    def test_a_character_that_is_not_there_or_has_no_spine(self):
        self.export_refused(glb="missing.glb", names=["missing.glb"])
        self.export_refused("--hip", "nothing", names=["nothing"])

    def test_a_name_of_another_kind_or_a_program_that_is_not_known(self):
        self.export_refused(code=USAGE, out="out.py", names=[".json"])
        self.export_refused(code=USAGE, out="out.json", to="blender", names=[".py"])
        self.export_refused(code=USAGE, to="houdini", names=["houdini"])

    def test_a_folder_in_the_outputs_place(self):
        (self.folder / "out.json").mkdir()
        self.export_refused(code=CANNOT_WRITE, names=["out.json"])

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_a_folder_that_may_not_be_written(self):
        (self.folder / "closed").mkdir(mode=0o500)
        self.export_refused(code=CANNOT_WRITE, out="closed/out.json", names=["closed"])

    def test_an_output_that_exists_is_replaced_whole(self):
        self.write("even_json.json", "old")
        self.assertEqual(self.graph(human(1500))["schema"], "backbend.even_graph/1")


class InMaya(ExportTest, CommandTest):
    def built(self, glb=None, up="y", **oddities):
        """(graph, rig, what the script defines)."""
        glb = glb or human(1500)
        graph, script = self.graph(glb), self.export("maya", glb)
        rig = MayaRig(graph, up, **oddities)
        return graph, rig, rig.run(script)

    def assert_same(self, a, b, within=1e-9):
        self.assertLess(max(abs(x - y) for x, y in zip(a, b, strict=True)), within)

    def test_the_nodes_give_the_solvers_spine(self):
        odd = {"rotate_order": 4, "rotate_axis": (20.0, -30.0, 50.0)}
        for glb, oddities in ((human(1500), {}), (human(1500), odd), *((character(name), odd) for name in CHARACTERS)):
            graph, rig, _ = self.built(glb, **oddities)
            self.assertEqual(set(rig.scene.kind.values()) - {"joint", "transform", "network"},
                             {"multiplyDivide", "composeMatrix", "multMatrix", "decomposeMatrix"})
            poses = random_poses(12, 4)
            self.assert_near(graph, rig.poses(poses), solver_poses(graph, poses, self.folder), 1e-6)
            self.assertLessEqual(largest_gain(rig.poses, poses[:9]), MOST_GAIN)

    def test_a_scene_with_z_up_and_hips_that_move_carry_it(self):
        graph, rig, _ = self.built(up="z")
        pose, hips = random_poses(2, 5)[1], graph["hips"]
        (spine,) = rig.poses([pose])
        # Z up: the solver's turns, seen with other axes.
        (solved,) = solver_poses(graph, [pose], self.folder)
        axes = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
        for (turn, _), (exact, _) in zip(spine, solved):
            seen = times(axes, times(exact, inverse(axes)))
            self.assert_same(sum(turn, []), sum(seen, []))
        names = {name: maya_name(name) for name in rig.rest}
        before = {name: rig.scene.world(joint) for name, joint in names.items()}
        rig.scene.pose({f"{names[hips]}.rotate": (30.0, -50.0, 70.0), f"{names[hips]}.translate": (5.0, 6.0, 7.0)})
        motion = maya_scene.product(maya_scene.inverse(before[hips]), rig.scene.world(names[hips]))
        for name, joint in names.items():
            self.assert_same(maya_scene.product(before[name], motion), rig.scene.world(joint))

    def test_both_arms_go_with_the_chest(self):
        graph, rig, _ = self.built()
        joints = [rig.chest, *(maya_name(each["name"]) for each in graph["followers"])]
        self.assertEqual(len(joints), 3)
        rest = [rig.scene.world(joint) for joint in joints]
        rig.poses([[0.0] * 6 + [40.0, -50.0, 60.0]])
        chest, *arms = [maya_scene.product(maya_scene.inverse(before), rig.scene.world(joint))
                        for before, joint in zip(rest, joints)]
        self.assertGreater(math.dist(chest, maya_scene.IDENTITY), 1)
        for arm in arms:
            self.assert_same(arm, chest)

    def test_controls_stand_on_the_spine_and_are_limited(self):
        graph, rig, _ = self.built()
        found = {path.rsplit("|", 1)[-1]: [limits[f"rotation{axis}"] for axis in "XYZ"]
                 for path, limits in rig.scene.limits.items()}
        self.assertEqual(found, {f"even_{name}": [(-180.0, 180.0)] * 3 for name in ("lower", "middle", "top")})
        (spine,) = rig.poses(random_poses(2, 6)[1:])
        turn = spine[-1][0]
        axes = graph["controls"][2]["axes"]  # turned as the chest is: what the animator sees on Top
        turned = [sum(turn[i][k] * axes[3 * row + k] for k in range(3)) for row in range(3) for i in range(3)]
        top = rig.scene.world("even_top")
        self.assert_same(turned, [top[4 * row + i] for row in range(3) for i in range(3)])

    def test_remove_leaves_the_scene_as_it_was(self):
        graph, script = self.graph(human(1500)), self.export("maya", human(1500))
        rig = MayaRig(graph)
        before = {path: rig.scene.world(path) for path in rig.scene.kind}
        names = rig.run(script)
        rig.poses(random_poses(2, 7)[1:])
        with mock.patch.dict(sys.modules, rig.scene.as_module()):
            names["remove"]()
        self.assertEqual(set(rig.scene.kind), set(before))
        for path, world in before.items():
            self.assert_same(world, rig.scene.world(path))

    def test_what_cannot_be_built_is_said_in_one_line_and_changes_nothing(self):
        graph, script = self.graph(human(1500)), self.export("maya", human(1500))

        def drive(rig):
            driver = rig.scene.createNode("multiplyDivide", name="driver", skipSelect=True)
            rig.scene.connectAttr(driver + ".output", rig.chest + ".rotate")

        changes = (
            (lambda rig: rig.scene.pose({f"{rig.chest}.translate": (50.0, 0.0, 0.0)}), "does not stand"),
            (drive, "driven already"),
            (lambda rig: rig.scene.delete(rig.chest), "0 joints are called"),
            (lambda rig: rig.scene.createNode("network", name="backbend_even", skipSelect=True), "has the spine already"))
        for change, words in changes:
            rig = MayaRig(graph)
            change(rig)
            before = set(rig.scene.kind)
            with self.assertRaisesRegex(Exception, words) as raised:
                rig.run(script)
            self.assertNotIn("\n", str(raised.exception))
            self.assertEqual(set(rig.scene.kind), before)


IMPORT = """
import sys
import numpy
numpy.bool, numpy.float, numpy.int, numpy.object = bool, float, int, object
import addon_utils, bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("io_scene_gltf2")
source, target, *turned = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.import_scene.gltf(filepath=source)
if turned:  # an armature that stands elsewhere and is twice as large
    (rig,) = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    rig.location, rig.rotation_mode, rig.scale = (1, 2, 3), "XYZ", (2, 2, 2)
bpy.ops.wm.save_as_mainfile(filepath=target)
"""

KEY = """
import bpy
rig = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"][0]
rig.animation_data_create().action = bpy.data.actions.new("bends")
bone = rig.pose.bones["even_top"]
for frame, degrees in ((1, 0.0), (20, -1.0)):
    bone.rotation_euler = (degrees, 0.0, 0.0)
    bone.keyframe_insert("rotation_euler", frame=frame)
bpy.ops.wm.save_mainfile()
"""

TELL = """
import bpy, json, sys
rig = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"][0]
def at(frame):
    bpy.context.scene.frame_set(frame)
    return [[round(value, 5) for value in row] for row in rig.pose.bones[sys.argv[-1]].matrix]
print("TOLD" + json.dumps({"rest": at(1), "posed": at(20),
                           "channels": sorted((c.data_path, c.array_index) for c in rig.animation_data.action.fcurves)}))
"""

STATE = """
import bpy, json, sys
rig = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"][0]
print("STATE" + json.dumps({
    "bones": sorted(rig.data.bones.keys()), "meshes": sorted(bpy.data.meshes.keys()),
    "objects": sorted(bpy.data.objects.keys()), "properties": [key for key in rig.keys() if "backbend" in key],
    "drivers": len(rig.animation_data.drivers) if rig.animation_data else 0,
    "groups": rig.pose.bone_groups.keys() if hasattr(rig.pose, "bone_groups") else [],
    "simple": all(curve.driver.is_simple_expression for curve in rig.animation_data.drivers) if rig.animation_data else True,
    "constraints": sum(len(bone.constraints) for bone in rig.pose.bones),
    "rest": [[list(row) for row in bone.matrix_local] for bone in rig.data.bones if not bone.name.lower().startswith("even")]}))
"""


@unittest.skipUnless(BLENDER, "Blender is not installed")
class InBlender(ExportTest, CommandTest):
    def blender(self, *words, code=0):
        told = subprocess.run([BLENDER, *map(str, words)], cwd=self.folder, capture_output=True, text=True, timeout=600,
                              env=harness.blender_environment(self.folder))
        self.assertEqual(told.returncode, code, told.stdout + told.stderr)
        self.assertNotIn("Dependency cycle", told.stdout + told.stderr)
        return told

    def import_character(self, glb, *turned):
        return self.made_once(("imported", glb.read_bytes(), *turned), ("hero.blend",), lambda: self.import_anew(glb, *turned))

    def import_anew(self, glb, *turned):
        blend = self.folder / "hero.blend"
        script = self.write("import.py", IMPORT)
        self.blender("--background", "--factory-startup", "--python-exit-code", "9", "--python", script, "--", glb,
                     blend, *turned)

    def build(self, blend, script, *more, out="hero_even.blend", code=0):
        told = self.blender(blend, "--background", "--factory-startup", "--disable-autoexec", "--python", script, "--",
                            "-o", out, *more, code=code)
        return self.folder / out, told

    def state(self, blend):
        script = self.write("state.py", STATE)
        told = self.blender(blend, "--background", "--factory-startup", "--python", script)
        return json.loads(next(line[5:] for line in told.stdout.splitlines() if line.startswith("STATE")))

    def rig(self, blend, graph):
        rig = BlenderRig(BLENDER, blend, [joint["name"] for joint in graph["joints"]], self.folder / "map.json")
        self.addCleanup(rig.close)
        return rig

    def test_the_built_rig_is_the_solvers_spine_with_scripts_disabled(self):
        for name in CHARACTERS:
            with self.subTest(name):
                glb = character(name)
                graph = self.graph(glb)
                built, _ = self.build(self.import_character(glb), self.export("blender", glb))
                rig = self.rig(built, graph)
                poses = random_poses(100, 8)
                self.assert_near(graph, rig.poses(poses), solver_poses(graph, poses, self.folder))
                self.assertLessEqual(largest_gain(rig.poses, poses), MOST_GAIN)

    def test_judged_live_the_built_rig_passes(self):
        glb = self.write("hero.glb", human(1500).read_bytes())
        built, _ = self.build(self.import_character(glb), self.export("blender", glb))
        # As docs/export.md has it.
        turns = {"extension": ("rx", -1), "side": ("rz", -1), "twist": ("ry", 1)}
        channels = {name: [{"control": "even_top", "channel": channel, "per_degree": sign}]
                    for name, (channel, sign) in turns.items()}
        mapping = self.write("map.json", json.dumps({"channels": channels}))
        self.assert_runs("check", glb, "--rig", f"blender:{built}", "--map", mapping, "--quick", "-o", "run", timeout_s=600)
        report = json.loads((self.folder / "run/report.json").read_text())
        (rig,) = report["rigs"]
        self.assertEqual(rig["verdict"], "pass")
        self.assertEqual(rig["search"]["with_jumps"], 0)
        # Beside it stand our own, of which `even` is what it is.
        beside = {each["system"]: {h["channel"]: h["clean_to_deg"] for h in each["headroom"]} for each in rig["beside"]}
        self.assertEqual(list(beside), ["even", "matrix_blend", "spline_ik"])
        self.assertEqual({h["channel"]: h["clean_to_deg"] for h in rig["headroom"]}, beside["even"])

    def test_spines_of_one_and_twenty_joints_and_armatures_that_lie_elsewhere(self):
        for joints in (1, 20):
            glb = self.column(joints)
            graph = self.graph(glb, "even", *COLUMN_HINTS)
            script = self.export("blender", glb, "even", *COLUMN_HINTS)
            blend = self.import_character(glb, "turned")
            rig = self.rig(self.build(blend, script)[0], graph)
            poses = random_poses(16, joints)
            distance = Distance(graph["length"])
            for spine, exact in zip(rig.poses(poses), solver_poses(graph, poses, self.folder)):
                distance.add([(turn, self.from_turned(place)) for turn, place in spine], exact)
            self.assertLessEqual(distance.turn_deg, MOST_TURN_DEG)
            self.assertLessEqual(distance.place_percent, MOST_PLACE_PERCENT)

    @staticmethod
    def from_turned(place):
        """Back from where IMPORT put the armature: Blender's (1, 2, 3) is (1, 3, -2) with Y up."""
        return [(v - shift) / 2 for v, shift in zip(place, (1, 3, -2))]

    def test_remove_leaves_the_file_as_it_was(self):
        glb = character("quaternius_female_24k.glb")
        blend, script = self.import_character(glb), self.export("blender", glb)
        before = self.state(blend)
        built, _ = self.build(blend, script)
        between = self.state(built)
        self.assertTrue(between["simple"])
        self.assertGreater(between["drivers"], 100)
        self.assertEqual(between["rest"], before["rest"])
        self.assertIn("even_top", between["bones"])
        removed, _ = self.build(built, script, "--remove", out="removed.blend")
        self.assertEqual(self.state(removed), before)

    def test_keys_on_the_controls_outlive_remove_and_move_the_spine_that_is_built_again(self):
        glb = character("quaternius_female_24k.glb")
        script = self.export("blender", glb)
        built, _ = self.build(self.import_character(glb), script)
        key, tell = self.write("key.py", KEY), self.write("tell.py", TELL)
        self.blender(built, "--background", "--factory-startup", "--python-exit-code", "9", "--python", key)

        def told(blend):
            out = self.blender(blend, "--background", "--factory-startup", "--python-exit-code", "9", "--python", tell,
                               "--", self.graph(glb)["joints"][-1]["name"]).stdout
            return json.loads(next(line[4:] for line in out.splitlines() if line.startswith("TOLD")))

        keyed = told(built)
        self.assertNotEqual(keyed["rest"], keyed["posed"])
        removed, said = self.build(built, script, "--remove", out="removed.blend")
        self.assertIn("keys on the controls stay in the action 'bends': 3 channels", said.stdout)
        self.assertEqual(told(removed)["channels"], keyed["channels"])
        again, _ = self.build(removed, script, out="again.blend")
        self.assertEqual(told(again), keyed)

    def test_what_cannot_be_built_is_said_in_one_line_and_nothing_is_saved(self):
        glb = character("quaternius_female_24k.glb")
        blend, script = self.import_character(glb), self.export("blender", glb)
        built, _ = self.build(blend, script)
        other = script.rename(self.folder / "right.py"), self.export("blender", character("mh_female_cmu_13k.glb"))
        for file, with_script, words, more in (
                (built, other[0], "has the spine already", ()),
                (blend, other[0], "0 armatures have a spine", ("--remove",)),
                (blend, other[0], "no armature is called 'x'", ("--armature", "x")),
                (blend, other[1], "lacks the bones 'Hips'", ())):
            _, told = self.build(file, with_script, *more, out="no.blend", code=BAD_INPUT)
            lines = [line for line in told.stderr.splitlines() if line.startswith("backbend: ")]
            self.assertEqual(len(lines), 1, told.stderr)
            self.assertIn(words, lines[0])
            self.assertFalse((self.folder / "no.blend").exists())
