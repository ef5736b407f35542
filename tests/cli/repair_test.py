"""backbend repair: faults of the weights that go, files that differ in weights alone, and what is refused."""

import json
import os
import shutil
import struct
import subprocess
import unittest
import xml.etree.ElementTree

from harness import BAD_INPUT, CANNOT_WRITE, SOURCE, USAGE, CommandTest, blender_environment, human


def chunks(glb):
    """The JSON and where the binary chunk begins."""
    size, = struct.unpack_from("<I", glb, 12)
    return json.loads(glb[20:20 + size]), 20 + size + 8


def elements(glb, name):
    """Start and size of each vertex's bytes in an attribute of the first primitive."""
    document, start = chunks(glb)
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"][name]]
    view = document["bufferViews"][accessor["bufferView"]]
    size = 4 * {5121: 1, 5123: 2, 5126: 4}[accessor["componentType"]]
    first = start + view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return [(first + i * view.get("byteStride", size), size) for i in range(accessor["count"])]


def with_lost_vertices(glb, count):
    """The file with so many vertices, spread over the body, wholly on a hand that did not have them; and which."""
    document, _ = chunks(glb)
    out = bytearray(glb)
    names = [document["nodes"][node]["name"] for node in document["skins"][0]["joints"]]
    hand = next(i for i, name in enumerate(names) if "hand" in name.lower())
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    form = {5121: "<4B", 5123: "<4H"}[document["accessors"][attributes["JOINTS_0"]]["componentType"]]
    joints, weights = elements(glb, "JOINTS_0"), elements(glb, "WEIGHTS_0")
    assert weights[0][1] == 16, "our own writer stores weights as floats"
    changed, step = [], len(joints) // (count + 1)
    for vertex in range(step, len(joints), step):
        at = joints[vertex][0]
        if len(changed) == count or hand in struct.unpack_from(form, glb, at):
            continue
        struct.pack_into(form, out, at, hand, 0, 0, 0)
        struct.pack_into("<4f", out, weights[vertex][0], 1.0, 0.0, 0.0, 0.0)
        changed.append(vertex)
    return bytes(out), changed


class Repairing(CommandTest):
    def lost(self, count=8):
        glb, changed = with_lost_vertices(human(4000).read_bytes(), count)
        return self.write("lost.glb", glb), changed

    def test_stray_vertices_go_and_no_other_byte_changes(self):
        path, changed = self.lost()
        done = self.assert_runs("repair", path, "-o", "fixed.glb", "--no-picture")
        self.assertIn("BB062 stray vertices", done.stdout)
        self.assertIn("wrote fixed.glb", done.stderr)
        before, after = path.read_bytes(), (self.folder / "fixed.glb").read_bytes()
        self.assertEqual(len(before), len(after))
        allowed = set()
        for name in ("JOINTS_0", "WEIGHTS_0"):
            for vertex in changed:
                at, size = elements(before, name)[vertex]
                allowed |= set(range(at, at + size))
        differing = {i for i, (a, b) in enumerate(zip(before, after)) if a != b}
        self.assertTrue(differing)
        # Neighbours of a stray may be strays by the same count: none here stands beside another.
        self.assertLessEqual(differing, allowed)
        told = json.loads(self.assert_runs("check", "fixed.glb", "--quick", "--json", "-o", "run").stdout)
        self.assertNotIn("BB062", {finding["code"] for finding in told["findings"]})
        again = self.assert_runs("repair", "fixed.glb", "-o", "again.glb")
        self.assertIn("nothing to repair", again.stdout)
        self.assertFalse((self.folder / "again.glb").exists())

    def test_a_dry_run_writes_nothing_and_tells_the_same(self):
        path, changed = self.lost()
        dry = self.assert_runs("repair", path, "-o", "fixed.glb", "--weights", "w.xml", "--dry-run", "--json")
        self.assertEqual([each.name for each in self.folder.iterdir()], ["lost.glb"])
        wet = self.assert_runs("repair", path, "-o", "fixed.glb", "--no-picture", "--json")
        self.assertEqual(dry.stdout, wet.stdout)
        told = json.loads(wet.stdout)
        self.assertEqual(told["schema"], "backbend.repair/1")
        self.assertEqual({each["code"]: each["failures_after"] for each in told["checks"]}["BB062"], 0)
        self.assertEqual(told["touched"], len(changed))
        for step in told["steps"]:
            self.assertEqual(step["done"], step["why_not"] == "", step)
        self.assertTrue(any(step["done"] for step in told["steps"]))

    def test_pictures_of_before_and_after_stand_beside_the_file(self):
        path, _ = self.lost()
        told = self.assert_runs("repair", path, "-o", "fixed.glb")
        self.assertIn("wrote fixed_repair.png", told.stderr)
        picture = (self.folder / "fixed_repair.png").read_bytes()
        self.assertEqual(picture[:8], b"\x89PNG\r\n\x1a\n")
        # Three cells of the body side by side: before, after, what was changed.
        self.assertGreater(struct.unpack(">I", picture[16:20])[0], 3 * 400)
        self.assert_runs("repair", path, "-o", "plain.glb", "--no-picture")
        self.assertFalse((self.folder / "plain_repair.png").exists())
        self.assertEqual((self.folder / "plain.glb").read_bytes(), (self.folder / "fixed.glb").read_bytes())
        self.assert_runs("repair", path, "--weights", "w.json")
        self.assertEqual(sorted(each.name for each in self.folder.glob("*.png")), ["fixed_repair.png"])

    def test_an_output_that_exists_is_replaced(self):
        path, _ = self.lost()
        self.write("fixed.glb", "old")
        self.assert_runs("repair", path, "-o", "fixed.glb", "--no-picture")
        self.assertEqual((self.folder / "fixed.glb").read_bytes()[:4], b"glTF")

    def test_maya_and_json_hold_all_vertices_and_the_same_weights(self):
        path, changed = self.lost()
        self.assert_runs("repair", path, "--weights", "w.xml")
        self.assert_runs("repair", path, "--weights", "w.json")
        told = json.loads((self.folder / "w.json").read_text())
        mesh, = told["objDDic"]
        self.assertEqual(mesh["changed"], changed)
        root = xml.etree.ElementTree.parse(self.folder / "w.xml").getroot()
        self.assertEqual(root.tag, "deformerWeight")
        self.assertEqual(len(root.find("shape")), mesh["vertexCount"])
        for weights in root.findall("weights"):
            self.assertEqual({point.get("index"): float(point.get("value")) for point in weights},
                             mesh["weights"][weights.get("source")])
        self.assertEqual(len(root.findall("weights")), len(mesh["weights"]))

    def test_what_cannot_be_done_is_one_line(self):
        path, _ = self.lost()
        self.assert_refused("repair", path, code=USAGE, names=["--dry-run"])
        self.assert_refused("repair", path, "-o", path, code=USAGE, names=["the character itself"])
        self.assert_refused("repair", path, "-o", "out.fbx", code=USAGE, names=[".glb"])
        self.assert_refused("repair", path, "--weights", "w.txt", code=USAGE, names=[".xml"])
        self.assert_refused("repair", "none.glb", "--dry-run", code=BAD_INPUT, names=["none.glb"])
        self.assert_refused("repair", SOURCE / "scenes/characters/human.toml", "--dry-run", code=BAD_INPUT,
                            names=["backbend body"])
        self.write("walk.bvh", "HIERARCHY")
        self.assert_refused("repair", "walk.bvh", "--dry-run", code=BAD_INPUT, names=["glTF"])
        bare = json.loads(json.dumps({"asset": {"version": "2.0"}, "nodes": [{}], "scenes": [{"nodes": [0]}]}))
        self.write("bare.gltf", json.dumps(bare))
        self.assert_refused("repair", "bare.gltf", "--dry-run", code=BAD_INPUT, names=["bare.gltf"])

    def test_an_output_that_is_read_only_is_not_replaced(self):
        path, _ = self.lost()
        path.chmod(0o444)  # may be read
        for words in (["repair", path, "-o", "fixed.glb"], ["repair", path, "--weights", "w.py"],
                      ["export", "even", "--to", "json", "--for", path, "-o", "even.json"],
                      ["tune", "curve", "--for", path, "-o", "rig.toml"]):
            output = self.write(words[-1], "not checked out")
            output.chmod(0o444)
            result = self.backbend(*words)
            self.assertEqual(result.returncode, CANNOT_WRITE, result.stderr)
            self.assertIn(f"{words[-1]}: cannot be written: it is read-only", result.stderr)
            self.assertEqual(output.read_text(), "not checked out")
        self.assert_runs("repair", path, "-o", "other.glb", "--no-picture")

    def test_a_file_in_the_place_of_the_outputs_folder_is_told_before_any_work(self):
        path, _ = self.lost()
        self.write("taken", "a file")
        result = self.backbend("repair", path, "-o", "taken/fixed.glb")
        self.assertEqual(result.returncode, CANNOT_WRITE, result.stderr)
        self.assertEqual(result.stdout, "")

    def test_a_gltf_and_its_buffer_become_one_glb(self):
        path, _ = self.lost()
        glb = path.read_bytes()
        document, start = chunks(glb)
        self.write("parts/body.bin", glb[start:start + document["buffers"][0]["byteLength"]])
        document["buffers"][0]["uri"] = "body.bin"
        source = self.write("parts/lost.gltf", json.dumps(document))
        self.assert_runs("repair", source, "-o", "fixed.glb", "--no-picture")
        self.assert_runs("repair", path, "-o", "same.glb", "--no-picture")
        told = [self.assert_runs("inspect", name, "--json").stdout.replace(name, "")
                for name in ("fixed.glb", "same.glb")]
        self.assertEqual(json.loads(told[0])["weights"], json.loads(told[1])["weights"])


COMPARE = """
import addon_utils, bpy, numpy, sys
numpy.bool, numpy.float, numpy.int, numpy.object = bool, float, int, object
addon_utils.enable("io_scene_gltf2")

def weights(path, script=None):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    if script == "merged":
        body = next(o for o in bpy.data.objects if o.type == "MESH" and o.vertex_groups)
        bpy.context.view_layer.objects.active = body
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        body.data.vertices[len(body.data.vertices) - 1].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.delete(type="VERT")
        bpy.ops.object.mode_set(mode="OBJECT")
    if script:
        text = open(sys.argv[-1]).read()
        exec(compile(text, "script", "exec"), {})
    body = next(o for o in bpy.data.objects if o.type == "MESH" and o.vertex_groups)
    return [{body.vertex_groups[g.group].name: g.weight for g in v.groups if g.weight > 0}
            for v in body.data.vertices]

def apart(a, b):
    return max(abs(x.get(k, 0) - y.get(k, 0)) for x, y in zip(a, b) for k in set(x) | set(y))

before, after = sys.argv[-3], sys.argv[-2]
goal = weights(after)
print("RESULT", apart(weights(before), goal) > 0.5, apart(weights(before, "as it is"), goal) < 1e-5,
      apart(weights(before, "merged"), goal) < 1e-5)
"""


class InBlender(CommandTest):
    def test_the_file_opens_and_the_script_sets_the_same_weights(self):
        blender = shutil.which("blender")
        if blender is None:
            raise unittest.SkipTest("Blender is not on this machine")
        glb, _ = with_lost_vertices(human(4000).read_bytes(), 8)
        path = self.write("lost.glb", glb)
        self.assert_runs("repair", path, "-o", "fixed.glb", "--weights", "fixed.py", "--no-picture")
        self.write("compare.py", COMPARE)
        done = subprocess.run([blender, "--background", "--python", "compare.py", "--", str(path),
                               str(self.folder / "fixed.glb"), str(self.folder / "fixed.py")], cwd=self.folder,
                              env=blender_environment(self.folder), stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, timeout=300)
        self.assertIn("RESULT True True True", done.stdout, done.stdout + done.stderr)
        self.assertIn("by place", done.stdout)


class InTheValidator(CommandTest):
    def test_the_written_file_has_no_error(self):
        modules = SOURCE / "tests/web/node_modules"
        if shutil.which("node") is None or not (modules / "gltf-validator").is_dir():
            raise unittest.SkipTest("gltf-validator is not installed")
        glb, _ = with_lost_vertices(human(4000).read_bytes(), 8)
        self.assert_runs("repair", self.write("lost.glb", glb), "-o", "fixed.glb", "--no-picture")
        script = ("const v = require('gltf-validator'); const fs = require('fs');"
                  "v.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))"
                  ".then(r => console.log(r.issues.numErrors));")
        done = subprocess.run(["node", "-e", script, str(self.folder / "fixed.glb")], cwd=SOURCE / "tests/web",
                              env=dict(os.environ, NODE_PATH=str(modules)), capture_output=True, text=True, timeout=120)
        self.assertEqual(done.stdout.strip(), "0", done.stderr)


if __name__ == "__main__":
    unittest.main()
