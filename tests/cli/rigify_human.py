"""A human as Rigify makes one, Debian's own add-on, on the body of a shared character: for rigify_test.py.

    blender --background --factory-startup --python-exit-code 9 --python rigify_human.py -- BODY.glb HERO.blend
    blender --background --enable-autoexec HERO.blend --python-exit-code 9 --python rigify_human.py -- motion JOB.json

The first writes HERO.blend, which stands at rest, and beside it HERO.glb (all bones) and HERO_def.glb (those that
deform alone). The second plants what the job says and writes what it asks for: {"plant": PYTHON, "mapping": {...},
"channel": NAME, "values": [...], "out": STEM, "forms": [...], "save": FILE}, of the forms `clip`, `points`, `mdd`,
`pc2`, `baked` and `baked_def`.
"""

import json
import math
import pathlib
import struct
import sys

import addon_utils
import bpy
import numpy

for name, kind in (("bool", bool), ("float", float), ("int", int), ("object", object)):
    if not hasattr(numpy, name):
        setattr(numpy, name, kind)  # that release's exporter asks for names that numpy has dropped

# Bones of Rigify's basic human, and the joints of the body from which to which each goes.
MIDDLE = {"spine": ("root", "spine04"), "spine.001": ("spine04", "spine03"), "spine.002": ("spine03", "spine02"),
          "spine.003": ("spine02", "neck01"), "spine.004": ("neck01", "neck02"), "spine.005": ("neck02", "head"),
          "spine.006": ("head", None)}
SIDES = {"shoulder": ("clavicle", "upperarm01"), "upper_arm": ("upperarm01", "lowerarm01"),
         "forearm": ("lowerarm01", "wrist"), "hand": ("wrist", "finger3-1"), "thigh": ("upperleg01", "lowerleg01"),
         "shin": ("lowerleg01", "foot"), "foot": ("foot", "toe1-1"), "toe": ("toe1-1", None)}


def read_body(path):
    """(the mesh alone, {joint: its place})"""
    bpy.ops.import_scene.gltf(filepath=path)
    skeleton = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
    body = next(thing for thing in bpy.data.objects if thing.type == "MESH" and thing.find_armature() == skeleton)
    places = {bone.name: skeleton.matrix_world @ bone.head_local for bone in skeleton.data.bones}
    world = body.matrix_world.copy()
    body.modifiers.clear()
    body.vertex_groups.clear()
    body.parent, body.matrix_world, body.name = None, world, "body"
    for thing in [thing for thing in bpy.data.objects if thing != body]:
        bpy.data.objects.remove(thing)
    return body, places


def metarig(places):
    bpy.ops.object.armature_basic_human_metarig_add()
    meta = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bones = meta.data.edit_bones
    joints = dict(MIDDLE)
    for side in ("L", "R"):
        joints.update({f"{bone}.{side}": tuple(end and f"{end}.{side}" for end in ends) for bone, ends in SIDES.items()})
    for name, (first, last) in joints.items():
        along = bones[name].tail - bones[name].head
        bones[name].head = places[first]
        bones[name].tail = places[last] if last else places[first] + along
    for side in ("L", "R"):
        heel = bones[f"heel.02.{side}"]
        shift = bones[f"foot.{side}"].head - (heel.head + heel.tail) / 2
        heel.head, heel.tail = ((end.x + shift.x, end.y + shift.y, 0.0) for end in (heel.head.copy(), heel.tail.copy()))
        for name, near in ((f"pelvis.{side}", "spine"), (f"breast.{side}", "spine.003")):
            along = bones[name].tail - bones[name].head
            bones[name].head = bones[near].head
            bones[name].tail = bones[near].head + along
    bpy.ops.object.mode_set(mode="OBJECT")
    return meta


def generate(meta):
    bpy.context.view_layer.objects.active = meta
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.pose.rigify_generate()
    bpy.ops.object.mode_set(mode="OBJECT")
    rig = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE" and thing != meta)
    bpy.data.objects.remove(meta)
    return rig


def export(path, **settings):
    bpy.ops.export_scene.gltf(filepath=str(path), export_morph=False, **settings)


def make(body_file, out):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for name in ("rigify", "io_scene_gltf2"):
        addon_utils.enable(name, default_set=True)
    body, places = read_body(body_file)
    rig = generate(metarig(places))
    bpy.ops.object.select_all(action="DESELECT")
    body.select_set(True)
    rig.select_set(True)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    bpy.ops.wm.save_as_mainfile(filepath=out)
    for ending, deforming in (("", False), ("_def", True)):
        export(out.replace(".blend", ending + ".glb"), export_def_bones=deforming, export_animations=False)


def write_caches(stem, forms):
    """Of the clip with points, in Blender's own axes, as its exporters write them."""
    head, numbers = pathlib.Path(stem + "_points.clip").read_bytes().split(b"\n", 1)
    head = json.loads(head)
    frames, count = len(head["poses"]), head["points"]
    points = numbers[64 * len(head["joints"]) * frames:]
    if "pc2" in forms:
        pathlib.Path(stem + ".pc2").write_bytes(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, count, 0.0, 1.0, frames) + points)
    if "mdd" in forms:
        values = struct.unpack(f"<{3 * count * frames}f", points)
        pathlib.Path(stem + ".mdd").write_bytes(struct.pack(">ii", frames, count)
                                                + struct.pack(f">{frames}f", *(k / 24 for k in range(frames)))
                                                + struct.pack(f">{3 * count * frames}f", *values))


def bake(rig, job, stem):
    """The same poses as keys, and glTF of them."""
    for frame, value in enumerate(job["values"]):
        for target in job["mapping"]["channels"][job["channel"]]:
            bone, axis = rig.pose.bones[target["control"]], "xyz".index(target["channel"][1])
            bone.rotation_mode = "XYZ"
            bone.rotation_euler[axis] = math.radians(value * target.get("per_degree", 1.0))
            bone.keyframe_insert("rotation_euler", index=axis, frame=frame + 1)
    for curve in rig.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    bpy.context.scene.frame_end = len(job["values"])
    addon_utils.enable("io_scene_gltf2")
    for form in ("baked", "baked_def"):
        if form in job["forms"]:
            export(f"{stem}_{form}.glb", export_def_bones=form == "baked_def", export_animations=True,
                   export_frame_range=False, export_force_sampling=True)


def write_motion(job):
    rig, body = bpy.data.objects["rig"], bpy.data.objects["body"]
    exec(compile(job.get("plant", ""), "planted", "exec"), {"bpy": bpy, "math": math, "rig": rig, "body": body})
    if job.get("save"):
        bpy.ops.wm.save_as_mainfile(filepath=job["save"], copy=True)
    if not job.get("forms"):
        return
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes/bridges"))
    import backbend_blender
    import backbend_clip
    # One channel, at the values that are asked for.
    backbend_clip.paths = lambda mapping, stress=False: [(job["channel"], [{job["channel"]: v} for v in job["values"]])]
    stem, mapping = job["out"], job["mapping"]
    if "clip" in job["forms"]:
        backbend_blender.export({key: value for key, value in mapping.items() if key != "mesh"}, stem + ".clip")
    if set(job["forms"]) & {"points", "mdd", "pc2"}:
        backbend_blender.export({**mapping, "mesh": "body"}, stem + "_points.clip")
        write_caches(stem, job["forms"])
    if set(job["forms"]) & {"baked", "baked_def"}:
        bake(rig, job, stem)


words = sys.argv[sys.argv.index("--") + 1:]
if words[0] == "motion":
    write_motion(json.loads(pathlib.Path(words[1]).read_text()))
else:
    make(*words)
