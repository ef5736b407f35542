"""Spines that headless Blender makes, 1 m tall: scripts for its own Python, and what runs them."""

import subprocess

import harness

# An empty file with the armature `rig`, in edit mode, and what adds an upright bone to it.
ARMATURE = """
import math, sys
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
data = bpy.data.armatures.new("rig")
rig = bpy.data.objects.new("rig", data)
bpy.context.collection.objects.link(rig)
bpy.context.view_layer.objects.active = rig
bpy.ops.object.mode_set(mode="EDIT")

def bone(name, head, tail, parent=None, connect=False, deform=True, segments=1):
    new = data.edit_bones.new(name)
    new.head, new.tail = (0, 0, head), (0, 0, tail)
    new.use_deform, new.bbone_segments = deform, segments
    if parent:
        new.parent, new.use_connect = data.edit_bones[parent], connect
    return new

def drive(owner, path, index, source, expression):
    # `owner`'s value follows another of the rig's, called `var`.
    driver = owner.driver_add(path, index).driver
    variable = driver.variables.new()
    variable.targets[0].id = rig
    variable.targets[0].data_path = source
    driver.expression = expression
"""

BONES = [f"spine{k}" for k in range(5)]

# Five bones on each other.
SPINE = ARMATURE + """
for k in range(5):
    bone(f"spine{k}", 0.2 * k, 0.2 * k + 0.2, f"spine{k - 1}" if k else None, k > 0, segments=SEGMENTS)
"""

# Five bones that follow one control: `expression` gives the driver of bone k about an axis, of `var`, the control's turn
# about it.
DRIVEN = SPINE + """
bone("chest_ctl", 1.0, 1.2, deform=False)
bpy.ops.object.mode_set(mode="OBJECT")
BEFORE
rig.pose.bones["chest_ctl"].rotation_mode = "XYZ"
for k in range(1, 5):
    rig.pose.bones[f"spine{k}"].rotation_mode = "XYZ"
    for axis in range(3):
        drive(rig.pose.bones[f"spine{k}"], "rotation_euler", axis, f'pose.bones["chest_ctl"].rotation_euler[{axis}]',
              EXPRESSION)
AFTER
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[sys.argv.index("--") + 1])
"""


def driven(expression, before="", after="", segments=1):
    """A script that saves such a spine to the file after `--`. `expression` is Python that sees k and axis."""
    script = DRIVEN.replace("EXPRESSION", expression).replace("SEGMENTS", str(segments))
    return script.replace("BEFORE", before).replace("AFTER", after)


def spine(segments=1):
    return SPINE.replace("SEGMENTS", str(segments))


def blender(folder, *words):
    """Runs Blender in the background; an error of its script is one of ours."""
    # Its add-ons need numpy, which is the system's: another Python that comes first on the path would hide it.
    told = subprocess.run(["blender", "--background", *map(str, words)], cwd=folder, capture_output=True, text=True,
                          env=harness.blender_environment(folder), timeout=harness.PATIENCE_S)
    if told.returncode != 0:
        raise AssertionError(f"Blender: {told.stdout}{told.stderr}")


def run_script(folder, script, *words):
    """A script in a Blender with no settings of anyone's; `words` follow `--`."""
    path = folder / "make.py"
    path.write_text(script)
    blender(folder, "--factory-startup", "--python-exit-code", "9", "--python", path, "--", *words)
