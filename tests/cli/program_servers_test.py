"""Servers for programs that are not here: Maya's and Houdini's, run whole by the real command, with stand-ins that
answer as the documentation of their commands says. What they cannot show is said on the servers' pages."""

import json
import math
import os
import shlex
import sys
import unittest

import glb
from external_rig_test import RigTest, mesh_of, skeleton_of
from harness import CommandTest, SOURCE

BRIDGES = SOURCE / "scenes/bridges"
sys.path.insert(0, str(BRIDGES))
import backbend_scene  # noqa: E402

# The rig behind both stand-ins: example_rig.py's, whose channels are the rotations of one control. A scene is a file
# of JSON: {"skeleton", "twisted": degrees of the control at rest, "flip": example_rig.py's}.
SCENE = """
import json, math, sys
sys.path.insert(0, {bridges!r})
import example_rig

class Opened:
    def __init__(self, path):
        self.words = json.load(open(path))
        self.rig = example_rig.Rig(self.words["skeleton"], {{"flip": self.words.get("flip", []), "kink": [], "lose": [], "reverse": [],
                                   "pop": self.words.get("pop", []), "bulge": [], "memory": False, "jelly": False}})
        self.value = {{"X": 0.0, "Y": self.words.get("twisted", 0.0), "Z": 0.0}}
        self.names = [joint["name"] for joint in self.rig.joints]
        self.parents = [joint["parent"] for joint in self.rig.joints]
        self.posed = None, None  # the control's turns, and the joints then: they are asked for one by one

    def degrees(self):
        # extension, flexion, side, twist of a control whose X points left and whose Y points up.
        return [-self.value["X"], 0.0, -self.value["Z"], self.value["Y"] - self.words.get("bound", 0.0)]

    def matrices(self):
        if self.posed[0] != self.degrees():
            self.posed = self.degrees(), self.rig.pose(self.degrees())
        return self.posed[1]

    def rest(self):
        return [matrix for _, _, matrix in self.rig.declared()]

    def points(self):
        return self.rig.pose_with_points(self.degrees())[1]
"""

# maya.cmds, as far as backbend_maya.py asks: every joint in a group of its own, one control with a curve for a shape.
MAYA = SCENE + """
import functools
scene = None
print("maya.cmds prints when it is imported")

def file(path=None, open=False, force=False, prompt=True, query=False, sceneName=False):
    global scene
    if query and sceneName:
        return "/studio/secret/hero.ma"
    assert open and force and not prompt  # nobody is there to answer
    if not path.endswith(".ma"):
        raise RuntimeError("Unrecognized file.\\n")
    scene = Opened(path)

def about(version): return "2025"
def upAxis(query, axis): return "y"
def undoInfo(state): assert state is False
def currentUnit(query=False, linear=False, angle=None):
    if query and linear: return "cm"
    assert angle == "deg"

def path_of(joint):
    parent = scene.parents[joint]
    return (path_of(parent) if parent >= 0 else "") + "|" + "grp_" + scene.names[joint] + "|" + scene.names[joint]

@functools.lru_cache(maxsize=None)
def PATHS(): return [path_of(k) for k in range(len(scene.names))]
CONTROL = "|controls|hero:chest_ctl"
FREE = ["rotateX", "rotateY", "rotateZ", "stretch"]

def ls(name=None, type=None, long=False):
    if type == "joint": return list(reversed(PATHS()))
    if type == "nurbsCurve": return [CONTROL + "|chest_ctlShape"]
    if type == "skinCluster": return ["skin1", "skin2"] if scene.rig.mesh else []
    return [path for path in PATHS() if path.endswith("|" + name)]

def listRelatives(root, allDescendents, type, fullPath):
    above = ls(root, long=True)[0]
    return [path for path in PATHS() if path.startswith(above + "|")] or None

def objExists(name):
    node, _, attribute = name.partition(".")
    if node in (CONTROL, "hero:chest_ctl"): return attribute in ["", "visibility", "translateX", *FREE]
    return node in ("bodyShape",) or any(path.endswith("|" + node) for path in PATHS())

def listAttr(path, keyable, scalar): return ["translateX", "rotateX", "rotateY", "rotateZ", "stretch"]

def getAttr(plug, settable=False):
    attribute = plug.rpartition(".")[2]
    if settable: return attribute in FREE
    if attribute.startswith("bindPreMatrix["):
        bound = scene.rest()[int(attribute[14:-1]) - 5]
        turn, place = bound, bound[12:15]
        inverse = [bound[0], bound[4], bound[8], 0, bound[1], bound[5], bound[9], 0, bound[2], bound[6], bound[10], 0]
        return inverse + [-sum(inverse[4 * k + r] * place[k] for k in range(3)) for r in range(3)] + [1]
    if attribute == "stretch": return 0.5
    return scene.value[attribute[-1]]

def setAttr(plug, value): scene.value[plug[-1]] = value

def listConnections(plug, type, plugs):
    if not scene.words.get("bound_skin", True): return None
    joint = PATHS().index(plug.rpartition(".")[0])
    return [f"skin1.matrix[{{joint + 5}}]", "skin1.paintTrans"]

def xform(name, query, worldSpace, matrix=False, translation=False):
    if matrix: return scene.matrices()[PATHS().index(name)]
    assert name == "bodyShape.vtx[*]" and translation
    return scene.points()

def skinCluster(name, query, geometry): return ["bodyShape"] if name == "skin1" else ["lineShape"]
def objectType(shape): return "mesh" if shape == "bodyShape" else "nurbsCurve"
def polyInfo(shape, faceToVertex):
    return [f"FACE {{k:6d}}: " + "".join(f"{{v:7d}}" for v in face) + " \\n" for k, face in enumerate(scene.rig.mesh["triangles"])]
def polyEvaluate(shape, vertex): return len(scene.rig.mesh["points"])
"""

MAYAPY = """#!/bin/sh
PYTHONPATH={folder} exec {python} -B "$@"
"""

# hou, as far as backbend_houdini.py asks.
HOU = SCENE + """
scene = None
print("hou prints when it is imported")

def applicationVersionString(): return "20.5"

class hipFile:
    @staticmethod
    def load(path, suppress_save_prompt=False):
        global scene
        assert suppress_save_prompt
        scene = Opened(path)
    @staticmethod
    def basename(): return "hero.hip"

class Point:
    def __init__(self, number, name=None, matrix=None): self.n, self.name, self.matrix = number, name, matrix
    def number(self): return self.n
    def position(self): return self.matrix[12:15]
    def attribValue(self, key):
        m = self.matrix
        return {{"name": self.name, "transform": (*m[0:3], *m[4:7], *m[8:11])}}[key]

class Vertex:
    def __init__(self, point): self.its = point
    def point(self): return self.its

class Prim:
    def __init__(self, points): self.its = points
    def vertices(self): return tuple(Vertex(point) for point in self.its)

class Skeleton:
    def __init__(self, matrices): self.its = matrices
    def geometry(self): return self
    def points(self):  # children before their parents
        return tuple(reversed([Point(k, name, m) for k, (name, m) in enumerate(zip(scene.names, self.its()))]))
    def prims(self):
        by = {{point.n: point for point in self.points()}}
        return tuple(Prim([by[p], by[k]]) for k, p in enumerate(scene.parents) if p >= 0)

class Mesh:
    def geometry(self): return self
    def prims(self): return tuple(Prim([Point(v) for v in reversed(face)]) for face in scene.rig.mesh["triangles"])
    def pointFloatAttribValues(self, name): return tuple(scene.points())

class Parm:
    def __init__(self, axis): self.axis = axis
    def isLocked(self): return False
    def eval(self): return scene.value[self.axis]
    def set(self, value): scene.value[self.axis] = value

class Control:
    def parm(self, name): return Parm(name[-1].upper()) if name in ("r0x", "r0y", "r0z") else None

def node(path):
    return {{"/obj/hero/OUT": Skeleton(lambda: scene.matrices()), "/obj/hero/REST": Skeleton(lambda: scene.rest()),
            "/obj/hero/BODY": Mesh(), "/obj/hero/pose": Control()}}.get(path)
"""


class Programs:
    def setUp(self):
        super().setUp()
        self.body = self.write("tube.glb", glb.tube(rings=17, sides=8))
        self.scene()

    def scene(self, mesh=True, **words):
        skeleton = skeleton_of(self.body, self.SPINE)
        if mesh:
            skeleton["mesh"] = mesh_of(self.body)
        if self.UNIT != 1:
            for joint in skeleton["joints"]:
                joint["position"] = [self.UNIT * v for v in joint["position"]]
            if mesh:
                skeleton["mesh"]["points"] = [[self.UNIT * v for v in point] for point in skeleton["mesh"]["points"]]
        self.write(self.FILE, json.dumps({"skeleton": skeleton, **words}))

    def notes(self, report, word):
        return [note for note in report["characters"][0]["notes"] if word in note]


class Maya(Programs, RigTest, CommandTest):
    FILE, UNIT = "hero.ma", 100
    MAPPING = {"channels": {"extension": [{"control": "hero:chest_ctl", "channel": "rx", "per_degree": -1}],
                            "side": [{"control": "hero:chest_ctl", "channel": "rz", "per_degree": -1}],
                            "twist": [{"control": "hero:chest_ctl", "channel": "ry"}]}}

    def setUp(self):
        super().setUp()
        self.write("fake/maya/__init__.py", "")
        self.write("fake/maya/standalone.py", "def initialize(name): print('Maya starts')\ndef uninitialize(): pass\n")
        self.write("fake/maya/cmds.py", MAYA.format(bridges=str(BRIDGES)))
        self.write("bin/mayapy", MAYAPY.format(folder=shlex.quote(str(self.folder / "fake")),
                                               python=shlex.quote(sys.executable))).chmod(0o755)
        self.mapping = self.write("map.json", json.dumps(self.MAPPING))

    def backbend(self, *arguments, **options):
        path = str(self.folder / "bin") + os.pathsep + os.environ["PATH"]
        return super().backbend(*arguments, environment={"PATH": path}, **options)

    def judged(self, *more, **options):
        return self.check("maya:hero.ma", "--map", self.mapping, *more, **options)

    def test_a_flip_is_bisected_through_the_server(self):
        self.scene(flip=[["twist", 41.2345, 30]])
        report = self.judged("--servers", "2", code=1)
        flips = [finding for finding in self.findings(report, "BB001") if finding["sweep"] == "twist"]
        self.assertEqual(len(flips), 1)
        self.assertAlmostEqual(flips[0]["control_deg"], 41.2345, delta=180 * 2 ** -19)
        self.assertAlmostEqual(flips[0]["value"], 30, delta=0.01)
        self.assertEqual(self.findings(report, "BB049") + self.findings(report, "BB044"), [])
        # Centimetres became metres, and the mesh that the skin deforms is the rig's own.
        self.assertTrue(self.notes(report, "the mesh is its own, 136 points"))
        self.assertLess(report["characters"][0]["spine_length"], 2)

    def test_a_shape_that_pops_is_found(self):
        self.scene(pop=[["extension", 41.2345, 6.0, 0.0]])
        found = [finding for finding in self.findings(self.judged(code=1), "BB037") if finding["sweep"] == "extension"]
        self.assertEqual(len(found), 1)
        self.assertAlmostEqual(found[0]["control_deg"], 41.2345, delta=120 * 2 ** -19)

    def test_the_mapping_is_found_by_turning_the_controls_that_have_a_curve(self):
        told = json.loads(self.assert_runs("inspect", self.body, "--chest", "neck", "--rig", "maya:hero.ma", "--json").stdout)
        self.assertEqual({channel: [(each["control"], each["channel"], each["per_degree"]) for each in targets]
                          for channel, targets in told["channels"].items()},
                         {channel: [(each["control"], each["channel"], each.get("per_degree", 1)) for each in targets]
                          for channel, targets in self.MAPPING["channels"].items()})

    def test_a_scene_that_does_not_stand_as_it_was_bound_is_refused(self):
        self.scene(twisted=40.0)
        self.assert_refused("check", self.body, "--rig", "maya:hero.ma", "--map", self.mapping, "--chest", "neck", "--quick",
                            "--quiet", "--json", names=["rest", "degrees"])

    def test_joints_without_a_skin_stand_at_rest_as_the_scene_is(self):
        self.scene(bound_skin=False, mesh=False)
        self.assertEqual(self.findings(self.judged(code=None), "BB001"), [])

    def test_what_is_not_there_is_named(self):
        def refused(mapping, *names, rig="maya:hero.ma"):
            self.mapping.write_text(json.dumps(mapping))
            self.assert_refused("check", self.body, "--rig", rig, "--map", self.mapping, "--chest", "neck", "--quick",
                                "--quiet", "--json", names=names)

        twist = self.MAPPING["channels"]["twist"][0]
        refused({"channels": {"twist": [{**twist, "channel": "tx"}]}}, "hero.ma", "hero:chest_ctl.tx")
        refused({"channels": {"twist": [{**twist, "channel": "x"}]}}, "translateX", "locked or driven")
        refused({**self.MAPPING, "root": "pelvis"}, "root", "pelvis")
        refused({**self.MAPPING, "mesh": "cape"}, "mesh", "cape")
        self.write("hero.txt", "no scene")
        refused(self.MAPPING, "hero.txt", "Unrecognized file", rig="maya:hero.txt")
        refused(self.MAPPING, "none.ma", "no such file", rig="maya:none.ma")
        (self.folder / "bin/mayapy").unlink()
        refused(self.MAPPING, "mayapy", "cannot be started")


class Houdini(Programs, RigTest, CommandTest):
    FILE, UNIT = "hero.hip", 1
    MAPPING = {"skeleton": "/obj/hero/OUT", "rest": "/obj/hero/REST", "mesh": "/obj/hero/BODY",
               "channels": {"extension": [{"control": "/obj/hero/pose", "channel": "r0x", "per_degree": -1}],
                            "side": [{"control": "/obj/hero/pose", "channel": "r0z", "per_degree": -1}],
                            "twist": [{"control": "/obj/hero/pose", "channel": "r0y"}]}}

    def setUp(self):
        super().setUp()
        self.write("hou.py", HOU.format(bridges=str(BRIDGES)))
        self.mapping = self.write("map.json", json.dumps(self.MAPPING))

    def rig(self):
        words = ["env", f"PYTHONPATH={self.folder}", sys.executable, "-B", BRIDGES / "backbend_houdini.py",
                 self.folder / "hero.hip", self.mapping]
        return "command:" + " ".join(shlex.quote(str(word)) for word in words)

    def test_a_flip_is_bisected_through_the_server(self):
        self.scene(flip=[["twist", 41.2345, 30]])
        report = self.check(self.rig(), "--map", self.mapping, code=1)
        flips = [finding for finding in self.findings(report, "BB001") if finding["sweep"] == "twist"]
        self.assertEqual(len(flips), 1)
        self.assertAlmostEqual(flips[0]["control_deg"], 41.2345, delta=180 * 2 ** -19)
        self.assertEqual(self.findings(report, "BB049") + self.findings(report, "BB044"), [])
        self.assertTrue(self.notes(report, "the mesh is its own, 136 points"))

    def test_a_scene_that_does_not_stand_as_its_rest_is_refused(self):
        self.scene(twisted=40.0)
        self.assert_refused("check", self.body, "--rig", self.rig(), "--map", self.mapping, "--chest", "neck", "--quick",
                            "--quiet", "--json", names=["rest", "degrees"])

    def test_what_is_not_there_is_named(self):
        twist = self.MAPPING["channels"]["twist"][0]
        for mapping, names in (({**self.MAPPING, "skeleton": "/obj/none"}, ["skeleton", "/obj/none"]),
                               ({**self.MAPPING, "skeleton": None}, ["skeleton", "missing"]),
                               ({**self.MAPPING, "channels": {"twist": [{**twist, "channel": "r9y"}]}}, ["r9y"])):
            self.mapping.write_text(json.dumps(mapping))
            self.assert_refused("check", self.body, "--rig", self.rig(), "--map", self.mapping, "--chest", "neck", "--quick",
                                "--quiet", "--json", names=names)


class Core(unittest.TestCase):
    """What is in neither program."""

    def test_a_matrix_and_its_inverse_are_one(self):
        c, s = math.cos(0.7), math.sin(0.7)
        m = [2 * c, 2 * s, 0, 0, -3 * s, 3 * c, 0, 0, 0, 0, 0.5, 0, 4, -5, 6, 1]
        n = backbend_scene.inverse(m)
        product = [sum(m[4 * k + r] * n[4 * c + k] for k in range(4)) for c in range(4) for r in range(4)]
        for k, value in enumerate(product):
            self.assertAlmostEqual(value, float(k % 5 == 0))
        with self.assertRaises(ValueError):
            backbend_scene.inverse([0.0] * 16)

    def test_names_are_short_where_they_are_one_thing(self):
        self.assertEqual(backbend_scene.unique_names(["|a|hip", "|b|knee", "|c|knee"]), ["hip", "|b|knee", "|c|knee"])

    def test_parents_are_found_through_groups(self):
        place = {"|hips": 0, "|hips|grp|spine": 1}
        self.assertEqual(backbend_scene.nearest_above("|hips|grp|spine|g|h|chest", place), 1)
        self.assertEqual(backbend_scene.nearest_above("|hips", place), -1)

    def test_faces_of_any_size_become_triangles(self):
        self.assertEqual(backbend_scene.fans([[0, 1, 2], [4, 5, 6, 7]]), [0, 1, 2, 4, 5, 6, 4, 6, 7])

    def test_a_value_that_stays_is_not_set_again(self):
        class Host:
            program = scene = ""

            def __init__(self):
                self.was_set = []

            def joints(self):
                return [("hips", -1, [0.0] * 16)]

            def channels(self, wanted):
                return [(name, "rotation", True) for name in wanted]

            def get(self, channel):
                return 5.0

            def set(self, channel, value):
                self.was_set.append((channel, value))

            def matrices(self, names):
                return [[0.0] * 16]

            def mesh(self):
                return None

        host = Host()
        server = backbend_scene.SceneServer(host, {"channels": {"twist": [{"control": "a", "channel": "rx"},
                                                                         {"control": "b", "channel": "rx"}]}})
        server.select(["a.rx", "b.rx"], ["hips"])
        server.pose([5.0, 7.0])
        server.pose([6.0, 7.0])
        server.pose([6.0, 5.0])
        self.assertEqual(host.was_set, [("b.rx", 7.0), ("a.rx", 6.0), ("b.rx", 5.0)])
        self.assertEqual(server.declared_channels(), [("a.rx", "rotation", 5.0, True), ("b.rx", "rotation", 5.0, True)])

    def test_mistakes_of_a_mapping_are_named(self):
        for mapping, words in (({"channels": []}, "channels"), ({"channels": {"twist": {}}}, "channels/twist"),
                               ({"channels": {"twist": [{"control": "a"}]}}, "channels/twist/0/channel"),
                               ({"channels": {"twist": [{"control": 3, "channel": "rx"}]}}, "channels/twist/0/control")):
            with self.assertRaises(ValueError) as caught:
                backbend_scene.targets_of(mapping)
            self.assertIn(words, str(caught.exception))


if __name__ == "__main__":
    unittest.main()
