"""What Blender makes of a frame: every matte is cut out exactly, and a camera set up from the
frame's attributes sees the silhouette that the frame shows."""

import json
import math
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from exr import Exr
from harness import SOURCE, run_backbend

WIDTH, HEIGHT = 256, 192

# Reads what is asked for from a JSON file: mattes to cut out of a frame by Blender's own Cryptomatte
# node, then a mesh to look at through a given camera, one ray through the centre of every pixel.
BLENDER = """
import bpy, json, mathutils, sys
job = json.load(open(sys.argv[-1]))
scene = bpy.context.scene
render = scene.render
render.resolution_x, render.resolution_y, render.resolution_percentage = job["size"][0], job["size"][1], 100

scene.use_nodes = True
tree = scene.node_tree
tree.nodes.clear()
image = bpy.data.images.load(job["frame"])
out = tree.nodes.new("CompositorNodeOutputFile")
out.base_path = job["folder"]
out.format.file_format, out.format.color_depth, out.format.exr_codec = "OPEN_EXR", "32", "ZIP"
out.format.color_mode = "RGB"
out.file_slots.clear()
first = None
for layer, name in job["mattes"]:
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source = "IMAGE"
    node.image = image
    node.layer_name = layer
    node.matte_id = name
    out.file_slots.new(f"{layer}.{name}.")
    tree.links.new(node.outputs["Matte"], out.inputs[-1])
    first = first or node
tree.links.new(first.outputs["Matte"], tree.nodes.new("CompositorNodeComposite").inputs["Image"])
bpy.ops.render.render()

scene.use_nodes = False
bpy.ops.preferences.addon_enable(module="cycles")
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
bpy.ops.wm.obj_import(filepath=job["mesh"], forward_axis="Y", up_axis="Z")
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.data.sensor_fit = "HORIZONTAL"
camera.data.angle = job["angle"]
camera.data.clip_start, camera.data.clip_end = 1e-3, 1e4
camera.matrix_world = mathutils.Matrix(job["camera"])
scene.collection.objects.link(camera)
scene.camera = camera
render.engine = "CYCLES"
scene.cycles.device, scene.cycles.samples, scene.cycles.max_bounces = "CPU", 1, 0
scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
render.film_transparent = True
settings = render.image_settings
settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
render.filepath = job["silhouette"]
bpy.ops.render.render(write_still=True)
"""


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def blender_camera(frame):
    """(world matrix, horizontal angle) from worldToCamera, which looks along +z and multiplies row
    vectors; Blender's cameras look along -z and its matrices multiply columns."""
    to_camera = frame.matrix("worldToCamera")
    # Rows of the rotation are the world's axes seen by the camera: transposed, the camera's axes.
    axes = [[to_camera[world][axis] * (-1 if axis == 2 else 1) for axis in range(3)] for world in range(3)]
    eye = [-sum(to_camera[3][axis] * to_camera[world][axis] for axis in range(3)) for world in range(3)]
    world = [axes[i] + [eye[i]] for i in range(3)] + [[0, 0, 0, 1]]
    # A point at camera x = z lands at 1/2 + 1/2 / tan: worldToNDC = worldToCamera * projection.
    from_camera = [[to_camera[j][i] for j in range(3)] + [0] for i in range(3)] + [eye + [1]]
    projection = product(from_camera, frame.matrix("worldToNDC"))
    return world, 2 * math.atan(0.5 / projection[0][0])


@unittest.skipUnless(shutil.which("blender"), "blender is not on this machine")
class Blender(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend blender ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        result = run_backbend(["render", SOURCE / "scenes/characters/human.toml", "--rig", "curve", "--pose",
                               "extension=70,side=15", "--view", "three_quarter", "--res", f"{WIDTH}x{HEIGHT}",
                               "--spp", "8", "--name", "frame", "--export-obj", "frame.obj", "-o", "."], cls.folder)
        if result.returncode != 0:
            raise AssertionError(result.stderr)
        cls.frame = Exr(cls.folder / "frame.exr")
        cls.names = [(layer, name) for layer in ("CryptoAsset", "CryptoObject")
                     for name in cls.frame.manifest(layer)]
        camera, angle = blender_camera(cls.frame)
        job = {"size": [WIDTH, HEIGHT], "frame": str(cls.folder / "frame.exr"), "mattes": cls.names,
               "folder": str(cls.folder), "mesh": str(cls.folder / "frame.obj"), "camera": camera, "angle": angle,
               "silhouette": str(cls.folder / "silhouette.exr")}
        (cls.folder / "job.json").write_text(json.dumps(job))
        subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python-expr",
                        BLENDER, "--", cls.folder / "job.json"], check=True, capture_output=True, timeout=600)

    def test_every_matte_is_cut_out_exactly(self):
        self.assertIn(("CryptoObject", "torso"), self.names)  # its hash is no number without the turned bit
        seen = 0
        for layer, name in self.names:
            (path,) = self.folder.glob(f"{layer}.{name}.*.exr")
            cut_out, ours = Exr(path).channels["R"], self.frame.matte(layer, name)
            self.assertEqual(cut_out, ours, name)
            seen += max(ours) > 0
        self.assertGreaterEqual(seen, 6)  # the character, torso, head, both arms, a leg

    def test_the_regions_share_the_character_among_them(self):
        whole = self.frame.matte("CryptoAsset", "human")
        parts = [self.frame.matte("CryptoObject", name) for name in self.frame.manifest("CryptoObject")]
        for pixel, shares in enumerate(zip(*parts)):
            self.assertAlmostEqual(sum(shares), whole[pixel], delta=1e-6)

    def test_a_camera_set_up_from_the_attributes_sees_the_same_silhouette(self):
        blender = Exr(self.folder / "silhouette.exr")
        here = [z < 1e9 for z in self.frame.channels["Z"]]
        there = [a > 0.5 for a in blender.channels["A"]]
        both = sum(a and b for a, b in zip(here, there))
        either = sum(a or b for a, b in zip(here, there))
        self.assertGreater(both, 2000)
        self.assertGreaterEqual(both / either, 0.999)
