"""Builds the spine `even` in Blender on the joints of a character. Written by backbend export even.

    blender hero.blend --background --python THIS -- -o hero_even.blend [--armature NAME]
    blender hero_even.blend --background --python THIS -- --remove -o hero.blend

or open it in Blender's text editor and run it: it builds on the active armature, and F3, "Remove
backbend even" takes everything away again. Bones, drivers and constraints only: drivers are simple
expressions, which Blender evaluates with scripts disabled. See docs/export.md of backbend.
"""

import json
import math
import os
import sys

import bpy
from mathutils import Matrix, Vector

GRAPH = json.loads("@GRAPH@")

RECORD = "backbend_even"  # a property of the armature: what was made, for remove()
CONSTRAINT = "backbend even"
COLORS = {"lower": "THEME04", "middle": "THEME09", "top": "THEME01"}
# Bones turn about Y along the spine: a control's rx, ry, rz (along, forward, left) are the bone's
# y, z, x, and its order X, then Y, then Z is theirs.
ORDER, AXIS = "YZX", (1, 2, 0)
FARTHEST = 0.005  # of the spine: a joint that stands elsewhere than in the character's file


class EvenError(Exception):
    """What a person can put right; one line."""


def numbered(kind, number):
    return "EVEN-%s.%03d" % (kind, number)


# --- Which bones ---------------------------------------------------------------------------------

def bone_called(armature, joint):
    """The bone of a joint of the character: the same name, with DEF-, or without a namespace."""
    names = armature.data.bones.keys()
    for wanted in (joint, "DEF-" + joint):
        if wanted in names:
            return wanted
    short = joint.rsplit(":", 1)[-1].lower()
    alike = [name for name in names if name.rsplit(":", 1)[-1].lower() == short]
    return alike[0] if len(alike) == 1 else None


def spine_names():
    return [GRAPH["hips"]] + [joint["name"] for joint in GRAPH["joints"]]


def missing_joints(armature):
    return [name for name in spine_names() if bone_called(armature, name) is None]


def find_armature(name=None):
    armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    if name is not None:
        chosen = [thing for thing in armatures if thing.name == name]
        if not chosen:
            raise EvenError("no armature is called '%s'" % name)
    else:
        active = bpy.context.view_layer.objects.active
        chosen = [active] if active in armatures and not missing_joints(active) else [
            thing for thing in armatures if not missing_joints(thing)]
        if not chosen and len(armatures) == 1:
            chosen = armatures
        if not chosen:
            raise EvenError("none of %d armatures has the joints %s" % (len(armatures), ", ".join(spine_names())))
        if len(chosen) > 1:
            raise EvenError("%d armatures have these joints: name one with --armature" % len(chosen))
    missing = missing_joints(chosen[0])
    if missing:
        raise EvenError("'%s' lacks the bones '%s' of the spine of %s" % (
            chosen[0].name, "', '".join(missing), GRAPH["character"]))
    return chosen[0]


class Frame:
    """From the character's space (Y up) to the armature's, whatever its object's place and size."""

    def __init__(self, armature):
        to_armature = armature.matrix_world.to_3x3().normalized().inverted()
        self.turn = to_armature @ Matrix(((1, 0, 0), (0, 0, -1), (0, 1, 0)))  # Blender has Z up
        joints = [{"name": GRAPH["hips"], "place": GRAPH["origin"]}] + GRAPH["joints"]
        heads = [armature.data.bones[bone_called(armature, joint["name"])].head_local for joint in joints]
        self.origin, self.from_origin = heads[0].copy(), Vector(GRAPH["origin"])
        drawn = sum((Vector(b["place"]) - Vector(a["place"])).length for a, b in zip(joints, joints[1:]))
        here = sum((b - a).length for a, b in zip(heads, heads[1:]))
        self.scale = here / drawn
        for joint, head in zip(joints, heads):
            off = (self.place(joint["place"]) - head).length / here if here else math.inf
            if not off <= FARTHEST:
                raise EvenError("'%s' does not stand as in %s: '%s' is %.1f %% of the spine off; export the character "
                                "from this file again" % (armature.name, GRAPH["character"], joint["name"], 100 * off))

    def place(self, point):
        return self.origin + self.scale * (self.turn @ (Vector(point) - self.from_origin))

    def axes(self, control):
        """Axes of a bone that turns as the control does, in columns."""
        n = control["axes"]
        along, forward, left = (self.turn @ Vector(n[k:k + 3]) for k in (0, 3, 6))
        return Matrix((left, along, forward)).transposed()


# --- Bones, in edit mode -------------------------------------------------------------------------

class Bones:
    def __init__(self, armature, frame):
        self.armature, self.frame = armature, frame
        self.edit = armature.data.edit_bones
        self.lower, self.middle, self.top = GRAPH["controls"]
        self.size = 2.0 * GRAPH["length"] * frame.scale  # short bones lose digits of their direction
        self.made = []
        # Goes with the hips by a constraint: below a bone that Blender keeps with few digits (it does where
        # one points to -Y) its own axes would lose theirs.
        self.root = self.add("EVEN-lower", GRAPH["origin"], self.lower, None)

    def add(self, name, place, control, parent):
        return self.add_bone(name, self.frame.place(place), self.frame.axes(control), parent)

    def add_bone(self, name, head, axes, parent):
        bone = self.edit.new(name)
        bone.head = head
        bone.tail = bone.head + self.size * axes.col[1]
        bone.align_roll(axes.col[2])
        bone.use_deform = False
        bone.parent = parent
        self.made.append(bone.name)
        return bone

    def pair(self, kind, number, place):
        """A place on the spine: Middle's share, and Top's on it."""
        low = self.add(numbered(kind + "M", number), place, self.middle, self.root)
        return self.add(numbered(kind + "T", number), place, self.top, low)

    def build(self):
        at = Vector(GRAPH["origin"])
        for k, sample in enumerate(GRAPH["samples"]):
            top = self.pair("s", k, at)
            at = at + Vector(sample["step"])
            self.add(numbered("sP", k), at, self.top, top)
        for k, joint in enumerate(GRAPH["joints"]):
            top = self.pair("j", k, joint["place"])
            rest = self.armature.data.bones[bone_called(self.armature, joint["name"])].matrix_local
            axes = rest.to_3x3()  # kept with few digits, too: the turn nearest to it
            self.add_bone(numbered("j", k), rest.translation, 0.5 * (axes + axes.inverted().transposed()), top)
        self.add("even_lower", self.lower["place"], self.lower, self.edit[bone_called(self.armature, GRAPH["hips"])])
        for control in (self.middle, self.top):
            ride = self.add("EVEN-" + control["name"], control["place"], self.middle, self.root)
            self.add("even_" + control["name"], control["place"], control, ride)
        return self.made


# --- Drivers, constraints, controls --------------------------------------------------------------

def drive(armature, name, control, weights):
    """Turns a bone by a control's channels, each times its weight."""
    bone = armature.pose.bones[name]
    bone.rotation_mode = ORDER
    limit = math.radians(GRAPH["limit_deg"])
    for weight, axis in zip(weights, AXIS):
        if weight == 0.0:
            continue
        driver = bone.driver_add("rotation_euler", axis).driver
        variable = driver.variables.new()
        variable.name = "c"
        variable.targets[0].id = armature
        variable.targets[0].data_path = 'pose.bones["even_%s"].rotation_euler[%d]' % (control, axis)
        driver.expression = "clamp(c, %.17g, %.17g) * %.17g" % (-limit, limit, weight)
        if not driver.is_simple_expression:
            raise EvenError("Blender %s does not take '%s' for a simple expression" % (
                bpy.app.version_string, driver.expression))


def stand_at(armature, name, samples):
    """Moves a bone to where the first so many steps lead."""
    if samples == 0:
        return
    copy = armature.pose.bones[name].constraints.new("COPY_LOCATION")
    copy.target, copy.subtarget = armature, numbered("sP", samples - 1)
    copy.target_space = copy.owner_space = "POSE"


def go_with(armature, name, leader):
    """Carries a bone that hangs from nothing as its parent would."""
    carry = armature.pose.bones[name].constraints.new("ARMATURE")
    carry.name = CONSTRAINT
    target = carry.targets.new()
    target.target, target.subtarget, target.weight = armature, leader, 1.0
    return carry.name


def connect(armature):
    drive(armature, "EVEN-lower", "lower", (1, 1, 1))
    go_with(armature, "EVEN-lower", bone_called(armature, GRAPH["hips"]))
    drive(armature, "EVEN-top", "middle", (1, 1, 1))
    for kind, entries in (("s", GRAPH["samples"]), ("j", GRAPH["joints"])):
        for k, entry in enumerate(entries):
            drive(armature, numbered(kind + "M", k), "middle", entry["middle"])
            drive(armature, numbered(kind + "T", k), "top", entry["top"])
            stand_at(armature, numbered(kind + "M", k), k if kind == "s" else entry["samples"])
    for control in GRAPH["controls"][1:]:
        stand_at(armature, "EVEN-" + control["name"], control["samples"])


def take_over(armature):
    """Puts the user's joints on the spine, and what hangs beside it on what it goes with."""
    made = []
    for k, joint in enumerate(GRAPH["joints"]):
        bone = armature.pose.bones[bone_called(armature, joint["name"])]
        copy = bone.constraints.new("COPY_TRANSFORMS")
        copy.name = CONSTRAINT
        copy.target, copy.subtarget = armature, numbered("j", k)
        copy.target_space = copy.owner_space = "POSE"
        made.append((bone.name, copy.name))
    for follower in GRAPH["followers"]:
        name, leader = (bone_called(armature, follower[key]) for key in ("name", "leader"))
        if name is None or leader is None or leader in [bone.name for bone in armature.data.bones[name].parent_recursive]:
            continue  # not here, or hangs from it
        if armature.data.bones[name].parent is None:
            made.append((name, go_with(armature, name, leader)))
        else:
            print("'%s' hangs from '%s' and not from '%s': left as it is" % (
                name, armature.data.bones[name].parent.name, leader))
    return made


def outline(control, scale):
    """A square across the bone with an arrow forward; the bone's X is left, Z forward."""
    half = control["half_size"] * scale
    corners = [(half, half), (-half, half), (-half, -half), (half, -half),
               (0, 1.5 * half), (-0.2 * half, 1.2 * half), (0.2 * half, 1.2 * half), (0, half)]
    mesh = bpy.data.meshes.new("even_%s_shape" % control["name"])
    mesh.from_pydata([(x, 0, z) for x, z in corners],
                     [(0, 1), (1, 2), (2, 3), (3, 0), (7, 4), (4, 5), (4, 6)], [])
    return bpy.data.objects.new(mesh.name, mesh)


def dress(armature, frame):
    """Shapes, colours and locks of the controls."""
    shapes = []
    for control in GRAPH["controls"]:
        bone = armature.pose.bones["even_" + control["name"]]
        bone.rotation_mode = ORDER
        bone.lock_location = bone.lock_scale = (True, True, True)
        bone.custom_shape = outline(control, frame.scale)
        bone.use_custom_shape_bone_size = False
        shapes.append(bone.custom_shape.name)
        color = COLORS[control["name"]]
        if hasattr(bone, "color"):
            bone.color.palette = color
        else:
            group = armature.pose.bone_groups.new(name="even_" + control["name"])
            group.color_set = color
            bone.bone_group = group
    return shapes


# --- Both commands -------------------------------------------------------------------------------

class EditMode:
    """The armature in edit mode, and all as it was afterwards."""

    def __init__(self, armature):
        self.armature = armature

    def __enter__(self):
        if self.armature.library is not None or self.armature.data.library is not None:
            raise EvenError("'%s' is linked from another file: open that one" % self.armature.name)
        layer = bpy.context.view_layer
        if self.armature.name not in layer.objects:
            raise EvenError("'%s' is not in the current view layer" % self.armature.name)
        self.active, self.mode = layer.objects.active, bpy.context.mode
        if self.active is not None and self.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        self.hidden = self.armature.hide_get(), self.armature.hide_viewport
        self.armature.hide_viewport = False
        self.armature.hide_set(False)
        layer.objects.active = self.armature
        self.mirror, self.armature.data.use_mirror_x = self.armature.data.use_mirror_x, False
        bpy.ops.object.mode_set(mode="EDIT")

    def __exit__(self, *_):
        bpy.ops.object.mode_set(mode="OBJECT")
        self.armature.data.use_mirror_x = self.mirror
        self.armature.hide_set(self.hidden[0])
        self.armature.hide_viewport = self.hidden[1]
        bpy.context.view_layer.objects.active = self.active
        if self.active == self.armature and self.mode == "POSE":
            bpy.ops.object.mode_set(mode="POSE")


def build(armature):
    """The spine on the armature's joints. Raises EvenError, and changes nothing then."""
    if RECORD in armature:
        raise EvenError("'%s' has the spine already: remove it first" % armature.name)
    frame = Frame(armature)
    taken = [name for name in armature.data.bones.keys() if name.startswith(("EVEN-", "even_"))]
    if taken:
        raise EvenError("'%s' has a bone '%s', a name that the spine takes: rename it" % (armature.name, taken[0]))
    with EditMode(armature):
        made = Bones(armature, frame).build()
    record = {"bones": made, "constraints": [], "shapes": []}
    armature[RECORD] = json.dumps(record)
    try:
        connect(armature)
    except EvenError:
        remove(armature)
        raise
    record["shapes"] = dress(armature, frame)
    record["constraints"] = take_over(armature)
    armature[RECORD] = json.dumps(record)
    for name in made:
        if name.startswith("EVEN-"):
            armature.data.bones[name].hide = True
    bpy.context.view_layer.update()
    return record


def remove(armature):
    """Takes away all that build() made. Raises EvenError."""
    if RECORD not in armature:
        raise EvenError("'%s' has no spine of backbend" % armature.name)
    record = json.loads(armature[RECORD])
    for bone, constraint in record["constraints"]:
        held = armature.pose.bones.get(bone)
        if held is not None and constraint in held.constraints:
            held.constraints.remove(held.constraints[constraint])
    for name in record["bones"]:
        if name in armature.pose.bones:
            for axis in range(3):
                armature.pose.bones[name].driver_remove("rotation_euler", axis)
    if hasattr(armature.pose, "bone_groups"):
        for control in GRAPH["controls"]:
            group = armature.pose.bone_groups.get("even_" + control["name"])
            if group is not None:
                armature.pose.bone_groups.remove(group)
    with EditMode(armature):
        for name in record["bones"]:
            bone = armature.data.edit_bones.get(name)
            if bone is not None:
                armature.data.edit_bones.remove(bone)
    for name in record["shapes"]:
        shape = bpy.data.objects.get(name)
        if shape is not None:
            mesh = shape.data
            bpy.data.objects.remove(shape)
            bpy.data.meshes.remove(mesh)
    del armature[RECORD]
    bpy.context.view_layer.update()
    return record


def keyed_controls(armature, bones):
    """Names of the actions with keys on these bones, with how many channels each. They are the animator's work and
    stay, and turn the controls again when the spine is built again."""
    data = armature.animation_data
    actions = [data.action] if data and data.action else []
    actions += [strip.action for track in (data.nla_tracks if data else ()) for strip in track.strips if strip.action]
    starts = tuple('pose.bones["%s"].' % name for name in bones)
    channels = {}
    for action in actions:
        count = sum(curve.data_path.startswith(starts) for curve in getattr(action, "fcurves", ()))
        if count > 0:
            channels[action.name] = count
    return channels


class RemoveBackbendEven(bpy.types.Operator):
    """Take away the spine that backbend built on this armature"""

    bl_idname = "object.remove_backbend_even"
    bl_label = "Remove backbend even"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and RECORD in context.object

    def execute(self, context):
        try:
            remove(context.object)
        except EvenError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def option(arguments, name):
    """The word behind an option; None where it is not there."""
    if name not in arguments:
        return None
    k = arguments.index(name)
    if k + 1 == len(arguments):
        raise EvenError("%s needs a value" % name)
    return arguments[k + 1]


def run(arguments):
    out, name = option(arguments, "-o"), option(arguments, "--armature")
    if bpy.app.background and out is None:
        raise EvenError("-o OUT.blend is missing: nothing would be kept")
    if "--remove" in arguments:
        built = [thing for thing in bpy.data.objects if RECORD in thing and name in (None, thing.name)]
        if len(built) != 1:
            raise EvenError("%d armatures have a spine of backbend%s" % (
                len(built), ": name one with --armature" if len(built) > 1 else ""))
        done, what = built[0], remove(built[0])
        print("removed the spine from '%s': %d bones, %d constraints" % (
            done.name, len(what["bones"]), len(what["constraints"])))
        for action, channels in keyed_controls(done, what["bones"]).items():
            print("keys on the controls stay in the action '%s': %d channels without a bone until the spine is built "
                  "again" % (action, channels))
    else:
        done = find_armature(name)
        what = build(done)
        print("built the spine even on '%s': controls even_lower, even_middle, even_top; %d bones behind them" % (
            done.name, len(what["bones"]) - 3))
    if out is not None:
        try:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(out))
        except RuntimeError as error:
            raise EvenError("%s: cannot be written: %s" % (out, " ".join(str(error).split())))


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    if not hasattr(bpy.types, "OBJECT_OT_remove_backbend_even"):
        bpy.utils.register_class(RemoveBackbendEven)
    try:
        run(arguments)
    except EvenError as error:
        if not bpy.app.background:
            raise
        print("backbend: %s: %s" % (os.path.basename(bpy.data.filepath) or "this file", error), file=sys.stderr)
        sys.exit(3)


if __name__ == "__main__":
    main()
