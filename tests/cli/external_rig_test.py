"""A rig of the user's own, asked while it is judged: `--rig command:...` over docs/rig_protocol.md."""

import json
import math
import os
import random
import re
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

import glb
import harness
from harness import BAD_INPUT, CommandTest, SOURCE, USAGE

BRIDGES = SOURCE / "scenes/bridges"
EXAMPLE = BRIDGES / "example_rig.py"

# A server that can be told to misbehave: argument 1 says how, 2 is the skeleton; 3, where given, a file that says
# whether it has been started before.
BAD_SERVER = """
import json, os, struct, sys, time
sys.path.insert(0, {bridges!r})
import backbend_rig, example_rig
how, skeleton = sys.argv[1:3]
rig = example_rig.Rig(json.load(open(skeleton)), {{}})
channels = [(name, "rotation", 0.0) for name in example_rig.CHANNELS]
joints = rig.declared()
asked = 0
started_before = len(sys.argv) > 3 and os.path.exists(sys.argv[3])
if len(sys.argv) > 3:
    open(sys.argv[3], "w").close()
out = sys.stdout.buffer

def hello(**other):
    words = {{"schema": "backbend.rig/1",
             "channels": [{{"name": name, "kind": kind, "rest": rest}} for name, kind, rest in channels],
             "joints": [{{"name": name, "parent": parent, "rest": rest}} for name, parent, rest in joints]}}
    if rig.mesh:
        words["points"] = [v for point in rig.mesh["points"] for v in point]
    words.update(other)
    out.write(json.dumps(words).encode() + b"\\n")
    out.flush()

if how == "exits":
    print("no licence", file=sys.stderr)
    sys.exit(7)
if how == "mute":
    time.sleep(600)
if how == "chatter":
    out.write(b"Loading plug-ins\\n{{not json\\n")
if how == "endless":
    while True:
        out.write(b"x" * 65536)
hello(**{{"version": {{"schema": "backbend.rig/2"}}, "twice": {{"channels": [{{"name": "a"}}, {{"name": "a"}}]}},
         "restless": {{"joints": [{{"name": "hips"}}]}},
         "infinite": {{"metres_per_unit": "big"}}, "orphan": {{"joints": [{{"name": "hips", "parent": 3, "rest": [0.0] * 16}}]}},
         "says": {{"error": "hero.ma: a plug-in is missing"}}}}.get(how, {{}}))
for line in iter(sys.stdin.buffer.readline, b""):
    request = json.loads(line)
    count = request["ask"]
    values = struct.unpack(f"<{{4 * count}}d", sys.stdin.buffer.read(32 * count))
    matrices = [v for k in range(count) for matrix in rig.pose(values[4 * k:4 * k + 4]) for v in matrix]
    points = [v for k in range(count if request.get("points") else 0) for v in rig.pose_with_points(values[4 * k:4 * k + 4])[1]]
    asked += 1
    if points and how == "nanpoint":
        points[7] = float("nan")
    if points and how == "nopoints":
        points = points[:-3]
    if points and how == "movedpoints":
        points = [v + 0.1 for v in points]
    if asked > 2 and not started_before:
        if how == "dies":
            print("Traceback: lost the scene", file=sys.stderr)
            os.kill(os.getpid(), 9)
        if how == "hangs":
            time.sleep(600)
        if how == "noise":
            out.write(b"Warning: cycle in the graph\\n")
        if how == "nan":
            matrices[16 + 12] = float("nan")
        if how == "short":
            matrices = matrices[:-1]
        if how == "count":
            count += 1
        if how == "refuses":
            out.write(b'{{"error": "hero.ma: cannot evaluate"}}\\n')
            out.flush()
            continue
    out.write(json.dumps({{"answer": count}}).encode() + b"\\n" + struct.pack(f"<{{len(matrices)}}d", *matrices)
              + struct.pack(f"<{{len(points)}}f", *points))
    out.flush()
    if points and how == "nopoints":
        sys.exit(0)
    if how == "short" and asked > 2 and not started_before:
        sys.exit(0)
"""


# A server of which the second that is started is another: argument 1 says how, 2 is a file that the first one makes, 3 the skeleton.
TWIN_SERVER = """
import json, sys
sys.path.insert(0, {bridges!r})
import backbend_rig, example_rig
how, first, skeleton = sys.argv[1:4]
try:
    open(first, "x").close()
    how = ""
except FileExistsError:
    pass
rig = example_rig.Rig(json.load(open(skeleton)), {{"flip": [("extension", 20.0, 30.0)]}} if how == "poses" else {{}})
joints = rig.declared()
if how == "joints":
    joints.append(("extra", 0, joints[0][2]))
backbend_rig.serve([(name, "rotation", 0.0) for name in example_rig.CHANNELS], joints, rig.pose)
"""


def skeleton_of(path, spine):
    """What example_rig.py takes: names, parents and places of a GLB's nodes."""
    data = path.read_bytes()
    document = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])
    nodes, joints = document["nodes"], []

    def add(index, parent, place):
        node = nodes[index]
        here = [a + b for a, b in zip(place, node.get("translation", [0, 0, 0]))]
        assert "rotation" not in node and "scale" not in node and "matrix" not in node
        joints.append({"name": node.get("name", f"#{index}"), "parent": parent, "position": here})
        me = len(joints) - 1
        for child in node.get("children", []):
            add(child, me, here)

    for root in document["scenes"][0]["nodes"]:
        add(root, -1, [0.0, 0.0, 0.0])
    return {"joints": joints, "spine": spine}


def mesh_of(path):
    """The mesh that example_rig.py takes: a GLB's first primitive, its joints as numbers of skeleton_of()'s."""
    document, binary = glb.decode(path.read_bytes())
    names = [joint["name"] for joint in skeleton_of(path, [])["joints"]]

    def read(number):
        accessor = document["accessors"][number]
        view = document["bufferViews"][accessor["bufferView"]]
        kind, width = {5126: "f", 5121: "B", 5123: "H"}[accessor["componentType"]], {"VEC3": 3, "VEC4": 4, "SCALAR": 1}[accessor["type"]]
        values = struct.unpack_from(f"<{width * accessor['count']}{kind}", binary, view["byteOffset"])
        return [list(values[k:k + width]) for k in range(0, len(values), width)]

    primitive = document["meshes"][0]["primitives"][0]
    joint = [names.index(document["nodes"][node]["name"]) for node in document["skins"][0]["joints"]]
    corners = [value for row in read(primitive["indices"]) for value in row]
    return {"points": read(primitive["attributes"]["POSITION"]),
            "triangles": [corners[k:k + 3] for k in range(0, len(corners), 3)],
            "weights": [[[joint[j], w] for j, w in zip(js, ws) if w > 0] for js, ws in
                        zip(read(primitive["attributes"]["JOINTS_0"]), read(primitive["attributes"]["WEIGHTS_0"]))]}


class RigTest:
    """A tube with a spine of four joints, and servers for it."""

    SPINE = ["hips", "spine", "chest", "neck"]

    def setUp(self):
        super().setUp()
        self.body = self.write("tube.glb", glb.tube())
        self.skeleton = self.write("skeleton.json", json.dumps(skeleton_of(self.body, self.SPINE)))

    def rig(self, *faults):
        words = [sys.executable, "-B", EXAMPLE, self.skeleton, *faults]
        return "command:" + " ".join(shlex.quote(str(word)) for word in words)

    def check(self, rig, *more, code=0, out="run", chest="neck"):
        """A check without pictures; its report."""
        result = self.backbend("check", self.body, "--rig", rig, "--chest", chest, "--envelope", "human", "--quick",
                               "-o", out, *more)
        if code is not None:
            self.assertEqual(result.returncode, code, f"{result.stdout}\n{result.stderr}")
        return json.loads((self.folder / out / "report.json").read_text())

    def swept(self, rig, mapping=None, code=5, out="run"):
        """A night of the standard sweeps alone; its report. A check asks for corners and the paths between them as well,
        some four thousand poses more, which take most of its time: for what single sweeps show. Without its corners the
        envelope is not measured whole, so what has no failure ends with 5."""
        options = {"system": "external", "program": "command", "command": rig[len("command:"):], **({"map": str(mapping)} if mapping else {})}
        sweeps = (("extension", 0, 120), ("flexion", 0, 90), ("side", -45, 45), ("twist", -90, 90))
        self.write("sweeps.toml", '[suite]\ncharacters = ["tube.glb"]\nmappings = ["chest"]\nenvelope = "human"\ncorners = false\n'
                   '[[rig]]\nname = "hero"\nsolver = { ' + ", ".join(f"{key} = {json.dumps(value)}" for key, value in options.items()) + " }\n" +
                   "".join(f'[[sweep]]\nchannel = "{channel}"\nfrom = {start}\nto = {end}\nstep = 2\n' for channel, start, end in sweeps))
        self.assert_runs("nightly", "sweeps.toml", "--chest", "neck", "--quick", "-o", out, code=code)
        return json.loads((self.folder / out / "report.json").read_text())

    def findings(self, report, code):
        return [finding for finding in report["findings"] if finding["code"] == code]

    def bad(self, how, *more):
        server = self.write("bad.py", BAD_SERVER.format(bridges=str(BRIDGES)))
        words = [sys.executable, "-B", server, how, self.skeleton, *more]
        return "command:" + " ".join(shlex.quote(str(word)) for word in words)


class Live(RigTest, CommandTest):
    def test_an_even_rig_is_judged_as_even_is(self):
        self.backbend("check", self.body, "--chest", "neck", "--envelope", "human", "--quick", "-o", "ours")
        ours = json.loads((self.folder / "ours/report.json").read_text())
        live = self.check(self.rig(), code=ours["exit_code"])
        self.assertEqual(self.findings(live, "BB001") + self.findings(live, "BB049") + self.findings(live, "BB044"), [])
        clean = {row["channel"]: row["clean_to_deg"] for row in live["rigs"][0]["headroom"]}
        for row in ours["rigs"][0]["headroom"]:
            self.assertGreaterEqual(clean[row["channel"]], row["clean_to_deg"] - 6.1)
        asked = [row for row in live["rigs"][0]["coverage"] if row["code"] == "BB049"][0]
        self.assertEqual((asked["planned"], asked["measured"]), (4, 4))

    def test_a_flip_is_bisected_through_the_running_program(self):
        report = self.check(self.rig("--flip", "twist=41.2345:30"), code=1)
        flips = [finding for finding in self.findings(report, "BB001") if finding["sweep"] == "twist"]
        self.assertEqual(len(flips), 1)
        self.assertAlmostEqual(flips[0]["control_deg"], 41.2345, delta=180 * 2 ** -19)
        self.assertAlmostEqual(flips[0]["value"], 30, delta=0.01)
        self.assertEqual(flips[0]["owner"].upper(), "RIG")
        self.assertIn("--rig", flips[0]["reproduce"])

    def test_the_line_that_shows_a_finding_again_works(self):
        report = self.check(self.rig("--flip", "twist=41.2345:30"), code=1)
        line = shlex.split(self.findings(report, "BB001")[0]["reproduce"])
        self.assertEqual(line[0], "backbend")
        made = self.assert_runs(*line[1:], "--res", "32x32", "--spp", "1", "--chest", "neck")
        self.assertIn(".exr", made.stdout)

    def test_a_corner_of_one_joint_is_found(self):
        report = self.swept(self.rig("--kink", "extension=40"), code=1)
        self.assertTrue(self.findings(report, "BB010") + self.findings(report, "BB001"))

    def test_any_number_of_servers_and_threads_gives_the_same_report(self):
        rig = self.rig("--flip", "side=20.5:10")
        reports = []
        for servers, threads in ((1, 1), (3, 2), (2, 4)):
            out = f"run{servers}"
            self.check(rig, "--servers", str(servers), "--threads", str(threads), out=out, code=1)
            reports.append((self.folder / out / "report.json").read_text().replace(out, "run"))
        self.assertEqual(reports[0], reports[1])
        self.assertEqual(reports[0], reports[2])

    def test_a_wide_box_is_searched_with_no_more_poses_than_the_standard_one(self):
        """A program takes milliseconds a pose: at 15 degrees the stress sweeps' box would be 832 paths."""
        searched = self.check(self.rig(), "--sweeps", "stress", code=None)["rigs"][0]["search"]
        self.assertLess(2000, searched["poses"])
        self.assertLessEqual(searched["poses"], 4000)
        self.assertIn("twist +-360", searched["box"])

    def test_it_is_compared_rendered_turned_and_baked(self):
        rig = self.rig()
        self.assert_runs("render", self.body, "--rig", rig, "--chest", "neck", "--pose", "extension=60", "--res", "32x32", "--spp", "1")
        self.assert_runs("turntable", self.body, "--rig", rig, "--chest", "neck", "--views", "2", "--res", "32x32", "--spp", "1", "-o", "t")
        self.assert_runs("bake", self.body, "--rig", rig, "--chest", "neck", "-o", "baked.glb")
        self.assertGreater((self.folder / "baked.glb").stat().st_size, 1000)
        self.backbend("compare", rig, "even", "--character", self.body, "--chest", "neck", "--quick", "--sweeps", "standard", "-o", "c")
        report = json.loads((self.folder / "c/report.json").read_text())
        self.assertEqual({rig["system"] for rig in report["rigs"]}, {"external", "even"})


class Solving(RigTest, CommandTest):
    def solve(self, *words):
        told = self.assert_runs("solve", *words, "--character", self.body, "--chest", "neck").stdout
        return [json.loads(line) for line in told.splitlines()]

    def test_its_poses_are_those_of_its_program(self):
        """The last joint of the example has the whole angle."""
        poses = self.solve(self.rig(), "--sweep", "extension=0:60:15")
        self.assertEqual([pose["control"] for pose in poses], [{"extension": e} for e in (0.0, 15.0, 30.0, 45.0, 60.0)])
        for pose in poses:
            self.assertEqual([joint["name"] for joint in pose["joints"]], self.SPINE)
            w, x, y, z = pose["joints"][-1]["turn"]
            extension = math.degrees(2 * math.atan2(-x, w))
            self.assertAlmostEqual(extension, pose["control"]["extension"], delta=1e-6)
        alone = self.solve(self.rig(), "--pose", "extension=45,twist=12", "--json")
        twisted = self.solve(self.rig(), "--pose", "extension=45", "--sweep", "twist=0:12:12")
        self.assertEqual([pose["joints"] for pose in twisted], [poses[3]["joints"], alone[0]["joints"]])

    def test_our_rigs_are_solved_on_a_character_as_well(self):
        body = self.solve("curve", "--sweep", "extension=0:40:20")
        own = self.solve("curve", "--sweep", "top.rx=0:40:20")
        self.assertEqual([len(body), len(own)], [3, 3])
        self.assertEqual(body[0]["joints"], own[0]["joints"])
        self.assertNotEqual(body[2]["joints"], own[2]["joints"])

    def test_what_cannot_be_solved_is_refused(self):
        on = ("--character", self.body, "--chest", "neck")
        self.assert_refused("solve", "curve", "--pose", "twist=10", code=USAGE, names=["--pose", "--character"])
        self.assert_refused("solve", "curve", *on, "--at", "1", code=USAGE, names=["--at"])
        self.assert_refused("solve", "curve", *on, "--pose", "twits=10", code=BAD_INPUT, names=["twits", "twist"])
        self.assert_refused("solve", "curve", *on, "--sweep", "extension", code=BAD_INPUT, names=["from:to:step"])
        self.assert_refused("solve", self.bad("exits"), *on, code=BAD_INPUT, names=["no licence"])

    def test_its_properties_are_tried(self):
        def rows(*faults, code):
            told = self.backbend("selftest", "--rig", self.rig(*faults), "--character", self.body, "--chest", "neck", "--json")
            self.assertEqual(told.returncode, code, told.stderr)
            return {row["property"]: row["holds"] for row in json.loads(told.stdout)["properties"] if row["layer"] == "solver"}

        self.assertEqual(set(rows(code=0).values()), {True})
        with_memory = rows("--memory", code=1)
        self.assertEqual([name for name, holds in with_memory.items() if not holds],
                         ["the same in any order and from a program that was started again"])


class Points(RigTest, CommandTest):
    """Rigs that give the points of their own mesh."""

    def setUp(self):
        super().setUp()
        self.body = self.write("tube.glb", glb.tube(rings=17, sides=8))
        self.mesh = mesh_of(self.body)
        self.serve(self.mesh)

    def serve(self, mesh):
        self.skeleton.write_text(json.dumps({**skeleton_of(self.body, self.SPINE), "mesh": mesh}))

    def notes(self, report, word):
        return [note for note in report["characters"][0]["notes"] if word in note]

    def test_points_that_are_linear_blending_change_nothing(self):
        own = self.check(self.rig(), out="own")
        note = self.notes(own, "LBS against your deformers")[0]
        self.assertIn("alike", note)
        self.assertLess(float(re.search(r"largest ([0-9.]+) mm", note).group(1)), 0.01)
        self.assertTrue(self.notes(own, "the mesh is its own, 136 points"))
        self.skeleton.write_text(json.dumps(skeleton_of(self.body, self.SPINE)))
        blended = self.check(self.rig(), out="blended", code=own["exit_code"])
        self.assertEqual([f["code"] for f in own["findings"]], [f["code"] for f in blended["findings"]])
        for a, b in zip(own["rigs"][0]["headroom"], blended["rigs"][0]["headroom"]):
            self.assertEqual(a, b)

    def test_a_corrective_that_pops_is_found_at_its_pose_with_its_size(self):
        report = self.check(self.rig("--pop", "extension=41.2345:0.06"), code=1)
        found = [finding for finding in self.findings(report, "BB037") if finding["sweep"] == "extension"]
        self.assertEqual(len(found), 1)
        self.assertAlmostEqual(found[0]["control_deg"], 41.2345, delta=120 * 2 ** -19)
        # Between two joints that turn apart, blending takes a little of it.
        self.assertRegex(found[0]["detail"], r"jumps by (59\.[0-9]|60) mm at extension 41\.23")
        self.assertAlmostEqual(found[0]["geometry"]["size_mm"], 60, delta=0.6)
        self.assertAlmostEqual(found[0]["value"], 100 * 0.06 / report["characters"][0]["spine_length"], delta=0.06)
        self.assertEqual((found[0]["owner"], found[0]["verdict"]), ("RIG", "fail"))
        self.assertEqual(self.findings(report, "BB001"), [])
        for finding in self.findings(report, "BB037"):  # alone, and on the way to the corners
            self.assertAlmostEqual(float(re.search(r"extension ([0-9.]+)", finding["pose"]).group(1)), 41.2345, delta=0.01)
        clean = {row["channel"]: row["clean_to_deg"] for row in report["rigs"][0]["headroom"]}
        self.assertLessEqual(clean["extension"], 41.2345)

    def test_a_corrective_that_comes_in_within_a_degree_is_named_from_where_to_where(self):
        found = [finding for finding in self.findings(self.swept(self.rig("--pop", "extension=41.3:0.06:1"), code=1), "BB037")
                 if finding["sweep"] == "extension"]
        self.assertEqual(len(found), 1)
        self.assertGreaterEqual(found[0]["geometry"]["before_deg"], 40.7)
        self.assertLessEqual(found[0]["geometry"]["after_deg"], 42.9)
        self.assertAlmostEqual(found[0]["geometry"]["size_mm"], 60, delta=1)
        self.assertRegex(found[0]["detail"], r"moves by (59|60)(\.[0-9])? mm from extension 4[01]")

    def test_a_limb_that_starts_to_move_is_no_contradiction_of_the_picture(self):
        """No joint of the spine moves at once, but one beside it does: BB070 would blame the program."""
        result = self.backbend("check", self.body, "--rig", self.rig("--nod", "side=20"), "--chest", "neck", "--envelope", "human",
                               "--res", "64x48", "--spp", "4", "-o", "run")
        report = json.loads((self.folder / "run/report.json").read_text())
        self.assertEqual(self.findings(report, "BB070"), [], result.stdout)
        series = next(sweep for rig in report["rigs"] for sweep in rig["sweeps"] if sweep["sweep"] == "side")["metric"]["motion_change"]
        self.assertGreater(max(series), 1.0)  # the picture has it

    def test_both_sides_of_a_jump_have_pictures(self):
        self.assert_runs("check", self.body, "--rig", self.rig("--pop", "extension=40:0.06"), "--chest", "neck", "--envelope", "human",
                         "--res", "160x120", "--spp", "4", "-o", "pictured", code=1)
        found = self.findings(json.loads((self.folder / "pictured/report.json").read_text()), "BB037")
        pictured = [finding for finding in found if finding["pictures"]["before"]]
        self.assertEqual(len(pictured), 1)
        self.assertEqual(pictured[0]["value"], max(finding["value"] for finding in found))
        for side in ("before", "after", "heat"):
            self.assertTrue((self.folder / "pictured" / pictured[0]["pictures"][side]).is_file())
        self.assertTrue(pictured[0]["image"]["visible"])

    def test_a_flip_of_the_chain_is_no_jump_of_the_surface(self):
        report = self.check(self.rig("--flip", "twist=41.2345:60", "--bulge", "extension=0.001"), code=1)
        self.assertTrue(self.findings(report, "BB001"))
        self.assertEqual(self.findings(report, "BB037"), [])

    def test_a_corrective_that_follows_the_bend_is_no_jump(self):
        report = self.check(self.rig("--bulge", "extension=0.001"), code=None)
        self.assertEqual(self.findings(report, "BB037"), [])
        note = self.notes(report, "LBS against your deformers")[0]
        # Between two joints that turn apart, blending takes a little of the 120 mm.
        self.assertAlmostEqual(float(re.search(r"largest ([0-9.]+) mm", note).group(1)), 115, delta=5)
        self.assertIn("extension 120", note)

    def test_what_deformers_do_and_joints_do_not_is_booked_to_the_deformers(self):
        report = self.swept(self.rig("--bulge", "extension=0.004"), code=1)
        own = [finding for finding in report["findings"] if "the rig's deformers make it" in finding["detail"]]
        self.assertTrue(own)
        for finding in own:
            self.assertEqual(finding["owner"], "RIG")

    def test_points_are_matched_by_place_where_their_order_is_another(self):
        order = list(range(len(self.mesh["points"])))
        random.Random(7).shuffle(order)
        new = {old: k for k, old in enumerate(order)}
        self.serve({"points": [self.mesh["points"][k] for k in order], "weights": [self.mesh["weights"][k] for k in order],
                    "triangles": [[new[v] for v in t] for t in self.mesh["triangles"]]})
        note = self.notes(self.swept(self.rig()), "LBS against your deformers")[0]
        self.assertLess(float(re.search(r"largest ([0-9.]+) mm", note).group(1)), 0.01)

    def finer(self):
        """The same tube with other vertices."""
        return mesh_of(self.write("finer.glb", glb.tube(rings=25, sides=10)))

    def test_a_rig_with_another_mesh_is_judged_on_that_mesh(self):
        own = self.swept(self.rig(), out="own")
        self.serve(self.finer())
        report = self.swept(self.rig(), out="finer")
        self.assertTrue(self.notes(report, "the mesh is the rig's own, 250 points"))
        self.assertEqual(report["characters"][0]["vertices"], 250)
        # The weights are read off the motion: two joints a vertex, as the tube has them.
        note = self.notes(report, "LBS against your deformers")[0]
        self.assertLess(float(re.search(r"largest ([0-9.]+) mm", note).group(1)), 1)
        self.assertFalse([finding for finding in report["findings"] if finding["code"].startswith("BB06")])
        for a, b in zip(own["rigs"][0]["headroom"], report["rigs"][0]["headroom"]):
            self.assertAlmostEqual(a["clean_to_deg"], b["clean_to_deg"], delta=12)

    def test_a_pop_of_another_mesh_is_found_and_shown_again(self):
        self.serve(self.finer())
        report = self.check(self.rig("--pop", "extension=41.2345:0.06"), code=1)
        found = [finding for finding in self.findings(report, "BB037") if finding["sweep"] == "extension"]
        self.assertEqual(len(found), 1)
        self.assertAlmostEqual(found[0]["control_deg"], 41.2345, delta=120 * 2 ** -19)
        line = shlex.split(found[0]["reproduce"])
        self.assert_runs(*line[1:], "--res", "32x32", "--spp", "1", "--chest", "neck", "--export-obj", "own.obj")
        self.assertEqual(sum(line.startswith("v ") for line in (self.folder / "own.obj").read_text().splitlines()), 250)

    def test_points_of_another_mesh_are_named_and_linear_blending_is_judged(self):
        self.serve({"points": [[0.1, 0.2, 5.0]], "triangles": [], "weights": [[[0, 1.0]]]})
        report = self.swept(self.rig())  # without triangles it has no surface
        self.assertTrue(self.notes(report, "are not the vertices of tube.glb"))
        self.assertEqual(self.notes(report, "LBS against your deformers"), [])

    def test_pictures_show_the_rigs_own_points(self):
        rig = self.rig("--pop", "extension=40:0.3")
        for angle in (39, 41):
            self.assert_runs("render", self.body, "--rig", rig, "--chest", "neck", "--pose", f"extension={angle}", "--export-obj",
                             f"{angle}.obj", "--res", "32x32", "--spp", "1")
        a, b = ([list(map(float, line.split()[1:4])) for line in (self.folder / f"{angle}.obj").read_text().splitlines()
                 if line.startswith("v ")] for angle in (39, 41))
        self.assertGreater(max(math.dist(p, q) for p, q in zip(a, b)), 0.25)

    def test_any_number_of_servers_and_threads_gives_the_same_report(self):
        rig = self.rig("--pop", "side=20.5:0.03")
        reports = []
        for servers, threads in ((1, 1), (2, 4)):
            out = f"run{servers}"
            self.check(rig, "--servers", str(servers), "--threads", str(threads), out=out, code=1)
            reports.append((self.folder / out / "report.json").read_text().replace(out, "run"))
        self.assertEqual(reports[0], reports[1])


class Proof(RigTest, CommandTest):
    def test_planted_steps_are_all_found_at_their_angle_and_size_and_none_elsewhere(self):
        chance = random.Random(20261124)
        planted, words = {}, []
        ends = {"extension": 120, "flexion": 90, "side": 45, "twist": 90}
        for channel, end in ends.items():
            places = [3 + (end - 6) * (k + 0.8 * chance.random()) / 10 for k in range(10)]
            planted[channel] = [(at, math.exp(chance.uniform(math.log(1.2), math.log(180)))) for at in places]
            for at, size in planted[channel]:
                words += ["--flip", f"{channel}={at!r}:{size!r}"]
        command = self.rig(*words)[len("command:"):]
        self.write("night.toml", f"""
[suite]
name = "proof"
title = "Proof"
characters = ["tube.glb"]
mappings = ["chest"]
envelope = "sweep"
corners = false
[[rig]]
name = "hero"
solver = {{ system = "external", program = "command", command = {json.dumps(command)}, servers = 2 }}
""" + "".join(f'[[sweep]]\nchannel = "{channel}"\nto = {end}\nstep = 2\n' for channel, end in ends.items()))
        self.assert_runs("nightly", "night.toml", "--chest", "neck", "--quick", "-o", "night", code=1)
        flips = self.findings(json.loads((self.folder / "night/report.json").read_text()), "BB001")
        for channel, end in ends.items():
            found = sorted((finding["control_deg"], finding["value"]) for finding in flips if finding["sweep"] == channel)
            self.assertEqual(len(found), len(planted[channel]), channel)
            for (at, size), (angle, value) in zip(planted[channel], found):
                self.assertAlmostEqual(angle, at, delta=1e-4 * end)
                self.assertAlmostEqual(value, size, delta=0.01 * size)


class Suites(RigTest, CommandTest):
    def test_a_suite_names_a_rig_of_ones_own(self):
        command = self.rig()[len("command:"):]
        self.write("night.toml", f"""
[suite]
name = "own"
title = "Own"
characters = ["tube.glb"]
mappings = ["chest"]
[[rig]]
name = "hero"
solver = {{ system = "external", program = "command", command = {json.dumps(command)}, servers = 2 }}
[[sweep]]
channel = "extension"
to = 30
step = 10
""")
        self.backbend("nightly", "night.toml", "--chest", "neck", "--quick", "-o", "night")
        report = json.loads((self.folder / "night/report.json").read_text())
        self.assertEqual([rig["rig"] for rig in report["rigs"]], ["hero"])
        text = (self.folder / "night.toml").read_text()
        for change, word in ((", command =", ", commando ="), ("servers = 2", "servers = 0.5"),
                             ('"command"', '"comand"')):
            self.assertIn(change, text)
            self.write("wrong.toml", text.replace(change, word, 1))
            self.assert_refused("nightly", "wrong.toml", names=["wrong.toml:9", "external"])


    def night_of(self, commands, characters=("tube.glb",)):
        """A night of rigs by name: the commands that serve them."""
        rigs = "".join(f'[[rig]]\nname = "{name}"\nsolver = {{ system = "external", program = "command", '
                       f'command = {json.dumps(command[len("command:"):])} }}\n' for name, command in commands.items())
        self.write("night.toml", f"""
[suite]
name = "own"
title = "Own"
characters = {json.dumps(list(characters))}
mappings = ["chest"]
{rigs}
[[sweep]]
channel = "extension"
to = 30
step = 10
""")

    def test_a_rig_that_dies_is_not_measured_and_the_others_are_judged(self):
        good = self.rig("--flip", "extension=20.5:30")
        self.night_of({"good": good})
        self.assert_runs("nightly", "night.toml", "--chest", "neck", "--quick", "-o", "alone", code=1)
        alone = json.loads((self.folder / "alone/report.json").read_text())
        self.night_of({"dying": self.bad("dies"), "good": good})
        result = self.assert_runs("nightly", "night.toml", "--chest", "neck", "--quick", "-o", "night", code=1)
        self.assertIn("signal 9", result.stderr)
        report = json.loads((self.folder / "night/report.json").read_text())
        self.assertEqual({rig["rig"]: rig["verdict"] for rig in report["rigs"]}, {"good": "fail", "dying": "not_measured"})
        self.assertEqual(report["rigs"][0], alone["rigs"][0])
        named = self.findings(report, "BB052")
        self.assertEqual([(finding["rig"], finding["verdict"], finding["owner"]) for finding in named],
                         [("dying", "not_measured", "RIG")])
        for words in ("started again once", "signal 9", "lost the scene"):
            self.assertIn(words, named[0]["detail"])

    def test_what_is_not_measured_sets_the_exit_code_and_is_said_of_each_character(self):
        self.write("other.glb", glb.tube())
        self.night_of({"dying": self.bad("dies")}, ["tube.glb", "other.glb"])
        self.assert_runs("nightly", "night.toml", "--chest", "neck", "--quick", "-o", "night", code=5)
        report = json.loads((self.folder / "night/report.json").read_text())
        self.assertEqual([finding["character"] for finding in self.findings(report, "BB052")], ["tube", "other"])
        self.assertEqual({rig["verdict"] for rig in report["rigs"]}, {"not_measured"})
        self.night_of({"absent": self.bad("exits"), "good": self.rig()})
        self.assert_runs("nightly", "night.toml", "--chest", "neck", "--quick", "-o", "absent", code=BAD_INPUT)
        report = json.loads((self.folder / "absent/report.json").read_text())
        self.assertEqual({rig["rig"] for rig in report["rigs"]}, {"absent", "good"})

    def test_a_night_with_a_dead_rig_is_not_carried_over(self):
        self.night_of({"dying": self.bad("dies"), "good": self.rig()})
        for _ in range(2):
            self.backbend("nightly", "night.toml", "--chest", "neck", "--quick", "--history", "nights.jsonl", "-o", "night")
            report = json.loads((self.folder / "night/report.json").read_text())
            self.assertEqual([finding["rig"] for finding in self.findings(report, "BB052")], ["dying"])
            self.assertFalse([key for key in report["provenance"] if key.startswith("carried tube")])


# Controls as animators know them: argument 1 says which rig, 2 is the skeleton.
FK_SERVER = """
import json, math, sys
sys.path.insert(0, {bridges!r})
import backbend_rig, example_rig
kind, skeleton = sys.argv[1:3]
skeleton = json.load(open(skeleton))
rig = example_rig.Rig(skeleton, {{}})
spine = [[joint["name"] for joint in skeleton["joints"]].index(name) for name in skeleton["spine"]]
# Name: the joints that it turns, and by what share of its own turn.
controls = {{"hips_ctl": [(spine[0], 1.0)]}}
if kind in ("fk", "both"):
    controls.update({{f"spine_C0_fk{{k}}_ctl": [(joint, 1.0)] for k, joint in enumerate(spine[1:])}})
if kind in ("ik", "both"):
    controls["spine_C0_ik1_ctl"] = [(joint, 1.0 / len(spine[1:])) for joint in spine[1:]]
if kind == "weak":  # its turn gets lost: no joint has all of it
    controls["spine_C0_ik1_ctl"] = [(joint, 0.7 / len(spine[1:])) for joint in spine[1:]]
if kind == "none":
    controls["hand_ctl"] = []
# Name: the axis that it turns the whole spine about, and by how many degrees for one unit.
properties = {{"torso_ctl.bend": (0, -45.0), "torso_ctl.roll_deg": (1, 1.0), "torso_ctl.squash": (0, 0.0)}} if kind == "properties" else {{}}
channels = [(f"{{name}}.{{axis}}", "rotation", 0.0) for name in controls for axis in ("rx", "ry", "rz")]
channels += [(name, "scalar", 0.0, True, (-2.0, 2.0) if name.endswith("bend") else None) for name in properties]
channels.append(("mechanism.rx", "rotation", 0.0, False))

def pose(values):
    own = {{joint: example_rig.rotation((0, 0, 0)) for joint in spine}}
    for k, (name, joints) in enumerate(controls.items()):
        for joint, share in joints:
            turn = [math.radians(share * value) for value in values[3 * k:3 * k + 3]]
            own[joint] = example_rig.times(own[joint], example_rig.rotation(turn))
    for (axis, per_unit), value in zip(properties.values(), values[3 * len(controls):]):
        for joint in spine[1:]:
            turn = [0.0, 0.0, 0.0]
            turn[axis] = math.radians(per_unit * value / len(spine[1:]))
            own[joint] = example_rig.times(own[joint], example_rig.rotation(turn))
    if values[-1]:
        own[spine[1]] = example_rig.times(own[spine[1]], example_rig.rotation((math.radians(values[-1]), 0, 0)))
    turns, places = [], []
    for k, joint in enumerate(rig.joints):
        turn, place = own.get(k, example_rig.rotation((0, 0, 0))), tuple(rig.place[k])
        if joint["parent"] >= 0:
            up = joint["parent"]
            offset = example_rig.turned(turns[up], [a - b for a, b in zip(place, rig.place[up])])
            turn, place = example_rig.times(turns[up], turn), tuple(a + b for a, b in zip(places[up], offset))
        turns.append(turn)
        places.append(place)
    return [rig.matrix(turn, place) for turn, place in zip(turns, places)]

backbend_rig.serve(channels, rig.declared(), pose)
"""


class Proposals(RigTest, CommandTest):
    """`inspect --rig` finds the mapping by moving the controls."""

    def fk(self, kind):
        server = self.write("fk.py", FK_SERVER.format(bridges=str(BRIDGES)))
        return "command:" + " ".join(shlex.quote(str(word)) for word in (sys.executable, "-B", server, kind, self.skeleton))

    def proposed(self, kind):
        told = self.assert_runs("inspect", self.body, "--chest", "neck", "--rig", self.fk(kind), "--json").stdout
        return {channel: [(each["control"], each["channel"], each["per_degree"]) for each in targets]
                for channel, targets in json.loads(told)["channels"].items()}

    def test_one_control_that_bends_the_spine_is_taken_with_its_axes_and_signs(self):
        for kind in ("ik", "both"):
            self.assertEqual(self.proposed(kind), {"extension": [("spine_C0_ik1_ctl", "rx", -1.0)], "side": [("spine_C0_ik1_ctl", "rz", -1.0)],
                                                   "twist": [("spine_C0_ik1_ctl", "ry", 1.0)]})

    def test_a_chain_of_controls_is_taken_whole(self):
        found = self.proposed("fk")
        for channel, axis, sign in (("extension", "rx", -1), ("side", "rz", -1), ("twist", "ry", 1)):
            self.assertEqual([(control, name) for control, name, _ in found[channel]],
                             [(f"spine_C0_fk{k}_ctl", axis) for k in range(3)])
            for _, _, share in found[channel]:
                self.assertAlmostEqual(share, sign / 3)

    def test_what_is_saved_is_what_check_takes(self):
        told = self.assert_runs("inspect", self.body, "--chest", "neck", "--rig", self.fk("fk"), "--save").stdout
        self.assertRegex(told, r"extension +spine_C0_fk0_ctl -X, .*shared equally: 100 % arrive at the chest")
        report = self.check(self.fk("fk"))
        self.assertEqual(self.findings(report, "BB049"), [])
        self.assertTrue(all(row["measured"] for row in report["rigs"][0]["headroom"]))

    def test_properties_stand_for_what_no_rotation_does_with_the_scale_that_was_measured(self):
        found = self.proposed("properties")
        self.assertEqual(sorted(found), ["extension", "twist"])
        for channel, name, scale in (("extension", "bend", 1 / 45), ("twist", "roll_deg", 1.0)):
            (control, own, per_degree), = found[channel]
            self.assertEqual((control, own), ("torso_ctl", name))
            self.assertAlmostEqual(per_degree, scale)

    def test_a_property_is_saved_in_the_sidecar_and_check_takes_it(self):
        told = self.assert_runs("inspect", self.body, "--chest", "neck", "--rig", self.fk("properties"), "--save").stdout
        self.assertRegex(told, r"twist +torso_ctl roll_deg 1 a degree: 100 % arrive at the chest")
        report = self.check(self.fk("properties"), code=None)
        self.assertEqual(self.findings(report, "BB049"), [])
        self.assertEqual({row["channel"] for row in report["rigs"][0]["headroom"] if row["measured"]}, {"extension", "flexion", "twist"})

    def test_a_control_that_is_held_above_the_chest_is_scaled(self):
        """Its three joints take a third each, and the chest that is judged is the second of them."""
        told = self.assert_runs("inspect", self.body, "--chest", "chest", "--rig", self.fk("ik"), "--save").stdout
        self.assertRegex(told, r"extension +spine_C0_ik1_ctl X -1.5 a degree: 100 % arrive at the chest")
        self.assertRegex(told, r"held above the chest, which gets 67 % of its turn about every axis")
        result = self.backbend("check", self.body, "--rig", self.fk("ik"), "--envelope", "human", "--quick", "-o", "run")
        report = json.loads((self.folder / "run/report.json").read_text())
        self.assertEqual(self.findings(report, "BB049") + self.findings(report, "BB040"), [], result.stdout)

    def test_a_control_of_which_a_part_is_lost_everywhere_is_not_scaled_and_fails(self):
        self.assertEqual(self.proposed("weak")["twist"], [("spine_C0_ik1_ctl", "ry", 1.0)])
        self.assert_runs("inspect", self.body, "--chest", "neck", "--rig", self.fk("weak"), "--save")
        self.assertTrue(self.findings(self.check(self.fk("weak"), code=1), "BB040"))

    def test_a_rig_without_such_a_control_and_other_words_are_refused(self):
        self.assert_refused("inspect", self.body, "--chest", "neck", "--rig", self.fk("none"), "--quiet", names=["none of its 2 controls"])
        self.assert_refused("inspect", self.body, "--rig", "even", code=USAGE, names=["--rig", "blender:FILE"])
        self.assert_refused("inspect", "--rig", self.fk("fk"), code=USAGE, names=["character"])
        self.assert_refused("inspect", code=USAGE, names=["character"])


class Mappings(RigTest, CommandTest):
    def test_a_twist_that_is_lost_fails_by_name(self):
        found = self.findings(self.check(self.rig("--lose", "twist"), code=1), "BB049")
        self.assertEqual([finding["sweep"] for finding in found], ["twist"])
        self.assertIn("nothing of it arrives", found[0]["detail"])
        self.assertEqual(found[0]["verdict"], "fail")

    def test_a_wrong_sign_fails_by_name(self):
        for wrong in (["extension", "side"], ["flexion", "twist"]):
            faults = [word for channel in wrong for word in ("--reverse", channel)]
            found = self.findings(self.swept(self.rig(*faults), code=1), "BB049")
            self.assertEqual(sorted(finding["sweep"] for finding in found), wrong)
            for finding in found:
                self.assertIn("other way round", finding["detail"])
                self.assertAlmostEqual(finding["value"], -1, delta=0.01)

    def test_a_wrong_axis_fails_by_name_and_its_channel_has_no_headroom(self):
        mapping = self.write("map.json", json.dumps({"channels": {
            "extension": [{"channel": "side"}], "side": [{"channel": "side"}], "twist": [{"channel": "twist"}]}}))
        report = self.swept(self.rig(), mapping, code=1)
        found = self.findings(report, "BB049")
        self.assertEqual(sorted(finding["sweep"] for finding in found), ["extension", "flexion"])
        self.assertIn("axis is wrong", found[0]["detail"])
        measured = {row["channel"]: row["measured"] for row in report["rigs"][0]["headroom"]}
        self.assertEqual(measured, {"extension": False, "flexion": False, "side": True, "twist": True})

    def test_an_axis_that_turns_with_another_and_a_scale_that_is_too_large_fail_by_name(self):
        side = [{"channel": "side"}, {"channel": "twist", "per_degree": 1.5}]
        mapping = self.write("map.json", json.dumps({"channels": {
            "extension": [{"channel": "extension", "per_degree": 3}], "side": side, "twist": [{"channel": "twist"}]}}))
        report = self.swept(self.rig(), mapping, code=1)
        cause = {finding["sweep"]: finding["detail"] for finding in self.findings(report, "BB049")}
        self.assertEqual(sorted(cause), ["extension", "flexion", "side"])
        self.assertIn("per_degree is too large", cause["flexion"])
        self.assertIn("45 deg about other axes", cause["side"])

    def test_an_axis_that_turns_another_a_little_with_it_is_no_fault(self):
        side = [{"channel": "side"}, {"channel": "twist", "per_degree": 0.5}]
        mapping = self.write("map.json", json.dumps({"channels": {
            "extension": [{"channel": "extension"}], "side": side, "twist": [{"channel": "twist"}]}}))
        self.assertEqual(self.findings(self.swept(self.rig(), mapping), "BB049"), [])

    def test_a_channel_that_the_chest_follows_only_so_far_fails_from_there_and_has_headroom_to_there(self):
        report = self.swept(self.rig("--stop", "flexion=34"), code=1)
        found = self.findings(report, "BB049")
        self.assertEqual([finding["sweep"] for finding in found], ["flexion"])
        self.assertIn("from 34 to 90, 0 arrive", found[0]["detail"])
        self.assertEqual(found[0]["owner"], "RIG")
        clean = {row["channel"]: row["clean_to_deg"] for row in report["rigs"][0]["headroom"]}
        self.assertEqual(clean["flexion"], 34)
        self.assertGreaterEqual(clean["extension"], 60)

    def test_a_channel_that_the_chest_follows_over_its_envelope_only_passes(self):
        found = self.findings(self.check(self.rig("--stop", "extension=80")), "BB049")
        self.assertEqual([finding["verdict"] for finding in found], ["stress"])

    def test_a_channel_that_turns_back_fails(self):
        mapping = self.write("map.json", json.dumps({"channels": {
            "extension": [{"channel": "extension"}], "flexion": [{"channel": "flexion", "per_degree": 2},
                                                                 {"channel": "extension", "per_degree": 1}],
            "side": [{"channel": "side"}], "twist": [{"channel": "twist"}]}}))
        report = self.swept(self.rig("--stop", "flexion=90"), mapping, code=1)
        self.assertIn("it turns back", [f["detail"] for f in self.findings(report, "BB049") if f["sweep"] == "flexion"][0])

    def test_scale_sign_and_several_controls_are_taken_from_the_mapping(self):
        mapping = self.write("map.json", json.dumps({"channels": {
            "extension": [{"channel": "flexion", "per_degree": -0.25}, {"channel": "extension", "per_degree": 0.75}],
            "side": [{"channel": "side"}], "twist": [{"channel": "twist"}]}}))
        report = self.swept(self.rig("--flip", "extension=30.123:20"), mapping, code=1)
        flips = [finding for finding in self.findings(report, "BB001") if finding["sweep"] == "extension"]
        self.assertAlmostEqual(flips[0]["control_deg"], 30.123 / 0.75, delta=0.001)

    def test_a_channel_that_nothing_stands_for_is_not_measured(self):
        mapping = self.write("map.json", json.dumps({"channels": {
            "extension": [{"channel": "extension"}], "twist": [{"channel": "twist"}]}}))
        report = self.check(self.rig(), "--map", mapping, code=5)
        measured = {row["channel"]: row["measured"] for row in report["rigs"][0]["headroom"]}
        self.assertFalse(measured["side"])
        self.assertTrue(measured["flexion"])

    def test_mappings_that_cannot_be_are_refused(self):
        for text, words in (("[]", ["channels"]), ('{"channels": {"twst": []}}', ["twst", "twist"]),
                            ('{"channels": {"twist": [{}]}}', ["channels/twist/0", "channel"]),
                            ('{"channels": {"twist": [{"channel": "twis"}]}}', ["'twis'", "twist"]),
                            ('{"channels": {"twist": [{"channel": "twist", "per_degree": 0}]}}', ["per_degree"])):
            mapping = self.write("map.json", text)
            self.assert_refused("check", self.body, "--rig", self.rig(), "--chest", "neck", "--map", mapping, "--quiet",
                                "--json", names=["map.json", *words])
        self.assert_refused("check", self.body, "--map", mapping, code=USAGE, names=["--map"])


class Hanging(RigTest, CommandTest):
    """Joints beyond the chain that the rig moves itself."""

    SPINE = ["hips", "spine", "chest"]

    def check(self, rig, **more):
        return super().check(rig, chest="chest", **more)

    def test_a_flip_of_the_neck_or_the_head_is_found_at_its_pose_and_named(self):
        for joint in ("neck", "head"):
            report = self.check(self.rig("--flip", f"flexion=50.25:40:{joint}"), code=1)
            flips = [finding for finding in self.findings(report, "BB001") if finding["sweep"] == "flexion"]
            self.assertEqual([finding["place"]["joint"] for finding in flips], [joint])
            self.assertAlmostEqual(flips[0]["control_deg"], 50.25, delta=0.001)
            self.assertAlmostEqual(flips[0]["value"], 40, delta=0.001)
            clean = {row["channel"]: row["clean_to_deg"] for row in report["rigs"][0]["headroom"]}
            self.assertEqual(clean["flexion"], 50)

    def test_what_hangs_there_may_turn_as_fast_as_it_likes(self):
        self.assertEqual(self.findings(self.check(self.rig("--nod", "flexion=20")), "BB001"), [])


class Memory(RigTest, CommandTest):
    def test_a_rig_with_a_memory_is_a_finding_that_names_the_pose(self):
        found = self.findings(self.check(self.rig("--memory"), code=1), "BB044")
        asked_again = [finding for finding in found if "asked for again" in finding["detail"]]
        self.assertEqual(len(asked_again), 1)
        self.assertNotEqual(asked_again[0]["pose"], "")

    def test_a_mesh_with_a_memory_is_a_finding_that_names_the_point(self):
        self.skeleton.write_text(json.dumps({**skeleton_of(self.body, self.SPINE), "mesh": mesh_of(self.body)}))
        found = self.findings(self.check(self.rig("--jelly"), code=1), "BB044")
        self.assertTrue([finding for finding in found if re.search("point [0-9]+ of its mesh differs by", finding["detail"])])


class BadServers(RigTest, CommandTest):
    def assert_one_line(self, rig, *names, timeout=None):
        before = time.monotonic()
        text = rig
        if timeout:
            text = self.write("rig.toml", "[rig]\nsystem = \"external\"\nprogram = \"command\"\n"
                              f"command = {json.dumps(rig[len('command:'):])}\ntimeout = {timeout}\n")
        result = self.backbend("check", self.body, "--rig", text, "--chest", "neck", "--quick", "--quiet", "--json", "-o", "run")
        told = f"{result.stdout}\n{result.stderr}"
        self.assertEqual(result.returncode, BAD_INPUT, told)
        self.assertEqual(result.stdout, "", told)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, told)
        for name in names:
            self.assertIn(name, lines[0])
        self.assertFalse((self.folder / "run/report.json").exists())
        self.assertLess(time.monotonic() - before, 60 * harness.SLOWER)
        self.assertEqual(self.running_servers(), [])

    def running_servers(self):
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline", "rb") as file:
                    words = file.read().split(b"\0")
            except OSError:
                continue
            if str(self.skeleton).encode() in words and b"check" not in words:
                found.append(pid)
        return found

    def test_programs_that_are_no_server(self):
        self.assert_one_line("command:no_such_program here", "no_such_program", "cannot be started")
        self.assert_one_line(self.bad("exits"), "exit code 7", "no licence", "hello")
        self.assert_one_line("command:yes", "does not speak backbend.rig/1")
        self.assert_one_line(self.bad("endless"), "hello")
        self.assert_one_line(self.bad("mute"), "silent", "hello", timeout=0.2)

    def test_hellos_that_cannot_be(self):
        for how, words in (("version", ["backbend.rig/2", "backbend.rig/1"]), ("twice", ["channels/1/name", "twice"]),
                           ("restless", ["joints/0/rest", "missing"]), ("infinite", ["metres_per_unit"]),
                           ("orphan", ["joints/0/parent"]), ("says", ["hero.ma: a plug-in is missing"])):
            self.assert_one_line(self.bad(how), *words)

    def test_servers_that_fail_at_work_are_started_again_once_and_then_named(self):
        for how, words in (("dies", ["signal 9", "lost the scene"]), ("noise", ["Warning: cycle"]),
                           ("nan", ["not finite", "joint '"]),
                           ("short", ["rest of an answer"]), ("count", ["asked for"]),
                           ("refuses", ["cannot evaluate"])):
            self.assert_one_line(self.bad(how), "started again once", *words)
        self.assert_one_line(self.bad("hangs"), "silent", timeout=1)

    def test_points_that_cannot_be_are_named(self):
        self.skeleton.write_text(json.dumps({**skeleton_of(self.body, self.SPINE), "mesh": mesh_of(self.body)}))
        self.swept(self.bad("fine"))
        shutil.rmtree(self.folder / "run")
        for how, words in (("nanpoint", ["point 2", "not finite"]), ("nopoints", ["points of an answer"]),
                           ("movedpoints", ["does not stand at rest", "vertex"])):
            self.assert_one_line(self.bad(how), *words)

    def twins(self, how):
        server = self.write("twin.py", TWIN_SERVER.format(bridges=str(BRIDGES)))
        words = [sys.executable, "-B", server, how, self.folder / f"first {how}", self.skeleton]
        return "command:" + " ".join(shlex.quote(str(word)) for word in words)

    def test_two_servers_that_disagree_are_found(self):
        on = ("check", self.body, "--chest", "neck", "--envelope", "human", "--quick", "--quiet", "--servers", "2", "-o", "run", "--rig")
        told = self.backbend(*on, self.twins("joints"))
        self.assertEqual((told.returncode, told.stdout, len(told.stderr.splitlines())), (BAD_INPUT, "", 1), told.stderr)
        self.assertIn("two servers of it have different channels, joints or points", told.stderr)
        self.assertEqual(self.backbend(*on, self.twins("poses")).returncode, 1)
        found = self.findings(json.loads((self.folder / "run/report.json").read_text()), "BB044")
        self.assertEqual([finding["verdict"] for finding in found], ["fail"])

    def test_a_server_that_fails_once_changes_nothing(self):
        whole = self.swept(self.bad("fine"), out="whole")
        for how in ("dies", "nan", "short"):
            once = self.swept(self.bad(how, self.folder / f"started {how}"), out=how)
            for report in (whole, once):
                for rig in report["rigs"]:
                    rig.pop("options", None)  # the command
            self.assertEqual(whole["rigs"], once["rigs"])

    def test_what_a_program_prints_before_its_hello_is_passed_over(self):
        self.swept(self.bad("chatter"))

    def test_a_rig_of_other_joints_or_another_rest_is_refused(self):
        skeleton = json.loads(self.skeleton.read_text())
        for joint in skeleton["joints"]:
            joint["name"] = joint["name"].replace("chest", "ribs")
        skeleton["spine"] = [name.replace("chest", "ribs") for name in skeleton["spine"]]
        self.skeleton.write_text(json.dumps(skeleton))
        self.assert_one_line(self.rig(), "no joint 'chest'")
        skeleton = skeleton_of(self.body, self.SPINE)
        for joint in skeleton["joints"]:
            x, y, z = joint["position"]
            joint["position"] = [x, -z, y]
        self.skeleton.write_text(json.dumps(skeleton))
        self.assert_one_line(self.rig(), '"up": "Z"')
        skeleton = skeleton_of(self.body, self.SPINE)
        skeleton["joints"][2]["position"][2] += 0.3
        self.skeleton.write_text(json.dumps(skeleton))
        self.assert_one_line(self.rig(), "stands", "at rest")

    def test_a_rig_in_another_unit_is_taken_in_the_characters(self):
        skeleton = skeleton_of(self.body, self.SPINE)
        for joint in skeleton["joints"]:
            joint["position"] = [100.0 * v for v in joint["position"]]
        self.skeleton.write_text(json.dumps(skeleton))
        self.check(self.rig())

    def test_an_interrupt_ends_the_servers(self):
        rig = self.bad("hangs")
        with subprocess.Popen([str(harness.BACKBEND), "check", str(self.body), "--rig", rig, "--chest", "neck", "--quick",
                               "--servers", "2", "-o", "run"], cwd=self.folder, env=harness.bare_environment(self.folder),
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
            deadline = time.monotonic() + 30 * harness.SLOWER
            while len(self.running_servers()) < 2 and time.monotonic() < deadline:
                time.sleep(0.05)
            time.sleep(2)
            run.send_signal(signal.SIGINT)
            run.communicate(timeout=30 * harness.SLOWER)
            self.assertEqual(run.returncode, 130)
        self.assertEqual(self.running_servers(), [])


class Page(RigTest, CommandTest):
    def test_the_server_on_the_protocols_page_works(self):
        page = (SOURCE / "docs/rig_protocol.md").read_text()
        code = re.search(r"```python\n(.*?)```", page, re.S).group(1)
        self.assertLessEqual(len(code.splitlines()), 40)
        # The page's rig on a tube of its own joints.
        server = self.write("server.py", code)
        body = self.write("three.glb", glb.tube(["hips", "spine", "chest"]))
        joints = skeleton_of(body, [])["joints"]
        heights = [joint["position"][1] for joint in joints if joint["name"] in ("hips", "spine", "chest")]
        code = re.sub(r"JOINTS = .*", "JOINTS = " + repr([("hips", -1, heights[0]), ("spine", 0, heights[1]),
                                                         ("chest", 1, heights[2])]), code)
        code = code.replace("y + 0.2 *", f"y + {heights[1] - heights[0]!r} *").replace(
            "z + 0.2 *", f"z + {heights[1] - heights[0]!r} *").replace("y, z = 0.0, 0.0", "y, z = 0.0, 0.0").replace(
            "angle, y, z = [], 0.0, 0.0, 0.0", f"angle, y, z = [], 0.0, {heights[0]!r}, 0.0")
        self.write("server.py", code)
        rig = "command:" + " ".join(shlex.quote(str(word)) for word in (sys.executable, "-B", server))
        self.backbend("check", body, "--rig", rig, "--chest", "chest", "--quick", "-o", "run")
        report = json.loads((self.folder / "run/report.json").read_text())
        self.assertEqual(self.findings(report, "BB049"), [])
        measured = {row["channel"]: row["measured"] for row in report["rigs"][0]["headroom"]}
        self.assertTrue(measured["extension"] and measured["flexion"])


if __name__ == "__main__":
    unittest.main()
