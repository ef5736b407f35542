"""backbend bake: animations that the Khronos validator and Blender take as they are."""

import json
import math
import shutil
import subprocess
import unittest

from glb import tube
from harness import CommandTest, SOURCE, human

NODE, BLENDER = shutil.which("node"), shutil.which("blender")
PACKAGES = SOURCE / "tests/web/node_modules"

VALIDATE = """
const validator = require(process.argv[1]);
const bytes = new Uint8Array(require("fs").readFileSync(process.argv[2]));
validator.validateBytes(bytes).then((report) => console.log(JSON.stringify(report)));
"""

# The mesh as Blender shows it in some frames, back in glTF's axes.
PLAY = """
import bpy, json, sys
import numpy
if not hasattr(numpy, "bool"):  # Debian 12's importer uses a name that its NumPy has dropped
    numpy.bool = bool
path, frames = sys.argv[-2], json.loads(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = 24
bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
body = next(thing for thing in bpy.data.objects if thing.type == "MESH" and thing.vertex_groups)
shown = []
for frame in frames:
    bpy.context.scene.frame_set(frame)
    posed = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = posed.to_mesh()
    points = [posed.matrix_world @ vertex.co for vertex in mesh.vertices]
    shown.append([[p.x, p.z, -p.y] for p in points])
    posed.to_mesh_clear()
print("SHOWN " + json.dumps(shown))
"""


class BakingForTheValidator(CommandTest):
    """The Khronos glTF validator, from npm (npm ci --prefix tests/web)."""

    def test_nothing_that_is_baked_has_an_error(self):
        if not NODE or not (PACKAGES / "gltf-validator").is_dir():
            self.skipTest("Node or gltf-validator (npm ci --prefix tests/web) is not installed")
        tubes = self.write("tube.glb", tube())
        for body, rig, sweep in ((tubes, "curve", "extension"), (tubes, "isner", "twist"), (human(), "even", "side")):
            with self.subTest(rig):
                self.assert_runs("bake", body, "--rig", rig, "--sweep", sweep, "-o", rig + ".glb")
                told = subprocess.run([NODE, "-e", VALIDATE, PACKAGES / "gltf-validator", self.folder / (rig + ".glb")],
                                      capture_output=True, text=True, timeout=120)
                self.assertEqual(told.returncode, 0, told.stderr)
                report = json.loads(told.stdout)
                self.assertEqual(report["issues"]["numErrors"], 0, report["issues"]["messages"])
                self.assertEqual(report["info"]["animationCount"], 1)


class EverySweep(CommandTest):
    def test_every_name_that_list_sweeps_prints_is_taken(self):
        body = self.write("tube.glb", tube())
        listed = [row["name"] for row in json.loads(self.assert_runs("list", "sweeps", "--json").stdout)]
        self.assertIn("stress grid", listed)
        for name in listed:
            with self.subTest(name):
                self.assert_runs("bake", body, "--sweep", name, "-o", "out.glb")
                self.assertGreater((self.folder / "out.glb").stat().st_size, 1000)


class PlayingInBlender(CommandTest):
    @unittest.skipUnless(BLENDER, "Blender is not installed")
    def test_blender_shows_every_vertex_where_we_put_it(self):
        body = self.write("tube.glb", tube())
        self.assert_runs("bake", body, "--rig", "curve", "--sweep", "extension", "-o", "baked.glb")
        frames = [0, 15, 30, 45, 60]  # two degrees of extension each
        script = self.write("play.py", PLAY)
        told = subprocess.run([BLENDER, "--background", "--factory-startup", "--python-exit-code", "9", "--python", script,
                               "--", self.folder / "baked.glb", json.dumps(frames)],
                              capture_output=True, text=True, timeout=300,
                              # Another Python first on the PATH would lead Blender's astray.
                              env={"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": str(self.folder)})
        if "No module named 'numpy'" in told.stdout + told.stderr:
            self.skipTest("Blender's glTF importer needs numpy")
        self.assertEqual(told.returncode, 0, told.stdout + told.stderr)
        line = next(line for line in told.stdout.splitlines() if line.startswith("SHOWN "))
        moved = 0.0
        for frame, shown in zip(frames, json.loads(line[6:])):
            obj = self.folder / f"pose{frame}.obj"
            self.assert_runs("render", body, "--rig", "curve", "--pose", f"extension={2 * frame}", "--res", "16x16",
                             "--spp", "1", "--mode", "clay", "-o", f"pose{frame}", "--export-obj", obj)
            ours = [[float(v) for v in row.split()[1:]] for row in obj.read_text().splitlines()
                    if row.startswith("v ")]
            self.assertEqual(len(shown), len(ours))
            worst = max(math.dist(a, b) for a, b in zip(shown, ours))
            self.assertLess(worst, 1e-5 * 1.6, f"frame {frame}")  # of the tube's height
            moved = max(moved, max(math.dist(a, b) for a, b in zip(shown, json.loads(line[6:])[0])))
        self.assertGreater(moved, 0.5)  # it plays
