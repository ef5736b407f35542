"""Builds the spine `even` in Maya on the joints of a character. Written by backbend export even.

With the scene open and at rest, in the script editor or a shelf button:

    exec(open("hero_even.py").read())      # build()
    remove()                               # takes everything away again; so does one undo

Nodes: multiplyDivide, composeMatrix, multMatrix, decomposeMatrix. No expressions, no plug-in but
Maya's own matrixNodes. Not run in Maya so far: backbend's tests evaluate the nodes as Maya's
documentation describes them. See docs/export.md of backbend.
"""

import json
import math
import re

from maya import cmds

GRAPH = json.loads("@GRAPH@")

RECORD = "backbend_even"  # a network node that keeps what was made, for remove()
COLORS = {"lower": 6, "middle": 14, "top": 13}
FARTHEST = 0.005  # of the spine: a joint that stands elsewhere than in the character's file
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


class EvenError(Exception):
    """What a person can put right; one line."""


# --- Matrices as Maya has them: sixteen numbers row by row, row vectors, the place in the last row ---

def product(*matrices):
    out = IDENTITY
    for m in matrices:
        out = tuple(sum(out[4 * i + k] * m[4 * k + j] for k in range(4)) for i in range(4) for j in range(4))
    return out


def shift(x, y, z):
    return IDENTITY[:12] + (x, y, z, 1.0)


def turned(axes):
    """From three columns, or rows of the transposed: a turn."""
    return tuple(axes[0:3]) + (0.0,) + tuple(axes[3:6]) + (0.0,) + tuple(axes[6:9]) + (0.0, 0.0, 0.0, 0.0, 1.0)


def inverse(m):
    """Of a turn with a place, and one scale for all axes."""
    size = sum(v * v for v in m[0:3])
    out = tuple(m[4 * j + i] / size for i in range(3) for j in range(3))
    back = tuple(-sum(m[12 + k] * out[3 * k + j] for k in range(3)) for j in range(3))
    return out[0:3] + (0.0,) + out[3:6] + (0.0,) + out[6:9] + (0.0,) + back + (1.0,)


def place_of(m):
    return m[12:15]


def distance(a, b):
    return sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5


# --- Which joints --------------------------------------------------------------------------------

def joints_called(name):
    """Also in a namespace, and as importers spell what Maya's names cannot hold: `arm.L`."""
    short = name.rsplit(":", 1)[-1]
    spelled = {re.sub(r"\W", "_", short), re.sub(r"\W", lambda c: "FBXASC%03d" % ord(c.group()), short)}
    wanted = sorted(spelled | {"*:" + each for each in spelled})
    return sorted(set(cmds.ls(*wanted, long=True, type="joint") or []))


def joint_called(name):
    found = joints_called(name)
    if len(found) != 1:
        raise EvenError("%d joints are called '%s', a spine joint of %s" % (len(found), name, GRAPH["character"]))
    return found[0]


def world_of(node):
    return tuple(cmds.getAttr(node + ".worldMatrix[0]"))


class Frame:
    """From the character's space (Y up, one unit) to the scene's."""

    def __init__(self):
        self.hips = joint_called(GRAPH["hips"])
        self.joints = [joint_called(joint["name"]) for joint in GRAPH["joints"]]
        up_z = cmds.upAxis(query=True, axis=True) == "z"
        self.turn = turned((1, 0, 0, 0, 0, 1, 0, -1, 0)) if up_z else IDENTITY
        drawn = [GRAPH["origin"]] + [joint["place"] for joint in GRAPH["joints"]]
        heads = [place_of(world_of(node)) for node in [self.hips] + self.joints]
        here = sum(distance(a, b) for a, b in zip(heads, heads[1:]))
        self.scale = here / sum(distance(a, b) for a, b in zip(drawn, drawn[1:]))
        self.origin = heads[0]
        for name, point, head in zip([self.hips] + self.joints, drawn, heads):
            off = distance(self.place(point), head) / here if here else 1.0
            if not off <= FARTHEST:
                raise EvenError("'%s' does not stand as in %s: it is %.1f %% of the spine off; export the character "
                                "from this scene again" % (name, GRAPH["character"], 100 * off))

    def step(self, vector):
        x, y, z = vector
        return tuple(self.scale * v for v in place_of(product(shift(x, y, z), self.turn)))

    def place(self, point):
        moved = self.step([a - b for a, b in zip(point, GRAPH["origin"])])
        return tuple(a + b for a, b in zip(self.origin, moved))

    def axes(self, control):
        """A matrix whose rows are the control's axes: from its space to the scene's."""
        return product(turned(control["axes"]), self.turn)


# --- Nodes ---------------------------------------------------------------------------------------

class Nodes:
    """Makes nodes, and remembers them."""

    def __init__(self):
        self.made = []

    def add(self, kind, name):
        node = cmds.createNode(kind, name="even_" + name, skipSelect=True)
        self.made.append(node)
        return node

    def scaled(self, name, control, weights):
        """A control's three angles, each times its weight."""
        node = self.add("multiplyDivide", name + "_scaled")
        cmds.connectAttr(control + ".rotate", node + ".input1")
        cmds.setAttr(node + ".input2", *weights, type="double3")
        return self.turn(name, node + ".output")

    def turn(self, name, angles):
        """The matrix of three angles in the order x, y, z."""
        node = self.add("composeMatrix", name + "_turn")
        cmds.connectAttr(angles, node + ".inputRotate")
        return node + ".outputMatrix"

    def multiplied(self, name, factors):
        """A product, first factor first: matrices, or attributes that hold one."""
        node = self.add("multMatrix", name)
        for k, factor in enumerate(factors):
            slot = "%s.matrixIn[%d]" % (node, k)
            if isinstance(factor, tuple):
                cmds.setAttr(slot, *factor, type="matrix")
            else:
                cmds.connectAttr(factor, slot)
        return node + ".matrixSum"

    def taken_apart(self, name, matrix):
        node = self.add("decomposeMatrix", name)
        cmds.connectAttr(matrix, node + ".inputMatrix")
        return node

    def only_place(self, name, matrix):
        """The matrix without its turn."""
        apart = self.taken_apart(name + "_apart", matrix)
        node = self.add("composeMatrix", name + "_place")
        cmds.connectAttr(apart + ".outputTranslate", node + ".inputTranslate")
        return node + ".outputMatrix"


class Spine:
    def __init__(self, frame, controls, nodes):
        self.frame, self.nodes, self.controls = frame, nodes, controls
        lower, middle, top = (frame.axes(control) for control in GRAPH["controls"])
        self.into_top, self.top_to_middle, self.from_middle = inverse(top), product(top, inverse(middle)), middle
        lower_turn = nodes.turn("lower", controls["lower"] + ".rotate")
        # Below the hips as they stand now: from the spine's origin to the world.
        rest = product(shift(*frame.origin), inverse(world_of(frame.hips)))
        self.carried = nodes.multiplied(
            "carried", [inverse(lower), lower_turn, lower, rest, frame.hips + ".worldMatrix[0]"])
        self.sums = self.add_up()

    def bent(self, name, entry):
        """Factors of a place's turn: Top's share, then Middle's."""
        top = self.nodes.scaled(name + "_top", self.controls["top"], entry["top"])
        middle = self.nodes.scaled(name + "_middle", self.controls["middle"], entry["middle"])
        return [self.into_top, top, self.top_to_middle, middle, self.from_middle]

    def add_up(self):
        """Where the first 0, 1, 2, ... steps lead from the spine's origin: matrices that only move."""
        sums = [IDENTITY]
        for k, sample in enumerate(GRAPH["samples"]):
            name = "sample%03d" % k
            moved = self.nodes.multiplied(name, [shift(*self.frame.step(sample["step"]))] + self.bent(name, sample))
            step = self.nodes.only_place(name, moved)
            sums.append(self.nodes.multiplied(name + "_sum", [sums[-1], step]))
        return sums

    def drive(self, number, entry, joint):
        """Puts a joint on the spine, through its own parent, orient and rotate axis."""
        name, nodes = "joint%02d" % number, self.nodes
        world = world_of(joint)
        rest = world[:12] + tuple(a - b for a, b in zip(world[12:15], self.frame.place(entry["place"]))) + (1.0,)
        local = nodes.multiplied(name + "_local", [rest] + self.bent(name, entry) + [
            self.sums[entry["samples"]], self.carried, joint + ".parentInverseMatrix[0]"])
        place = nodes.taken_apart(name + "_placed", local)
        turn = nodes.taken_apart(name + "_turned", nodes.multiplied(
            name + "_rotate", [inverse(turn_of(joint, "rotateAxis")), local, inverse(turn_of(joint, "jointOrient"))]))
        cmds.setAttr(turn + ".inputRotateOrder", cmds.getAttr(joint + ".rotateOrder"))
        cmds.connectAttr(place + ".outputTranslate", joint + ".translate")
        cmds.connectAttr(turn + ".outputRotate", joint + ".rotate")

    def carry_control(self, control, ride):
        """Stands a control's group on the spine; `ride`: what turns it besides its rest axes."""
        nodes, name = self.nodes, control["name"]
        placed = nodes.multiplied(name + "_ride", [self.frame.axes(control)] + ride + [
            self.sums[control["samples"]], self.carried])
        apart = nodes.taken_apart(name + "_ridden", placed)
        cmds.connectAttr(apart + ".outputTranslate", self.controls[name + "_group"] + ".translate")
        cmds.connectAttr(apart + ".outputRotate", self.controls[name + "_group"] + ".rotate")

    def carry_controls(self):
        """Lower's group goes with the hips alone, for Lower turns the rest; Top's with Middle, too."""
        lower, middle, top = GRAPH["controls"]
        rest = product(self.frame.axes(lower), shift(*self.frame.origin), inverse(world_of(self.frame.hips)))
        apart = self.nodes.taken_apart("lower_ridden", self.nodes.multiplied(
            "lower_ride", [rest, self.frame.hips + ".worldMatrix[0]"]))
        cmds.connectAttr(apart + ".outputTranslate", self.controls["lower_group"] + ".translate")
        cmds.connectAttr(apart + ".outputRotate", self.controls["lower_group"] + ".rotate")
        self.carry_control(middle, [])
        turn = self.nodes.turn("middle", self.controls["middle"] + ".rotate")
        self.carry_control(top, [inverse(self.from_middle), turn, self.from_middle])


def turn_of(joint, attribute):
    """The constant matrix of three angles of a joint, in the order x, y, z."""
    angles = cmds.getAttr("%s.%s" % (joint, attribute))[0]
    return rotation(*angles)


def rotation(x, y, z):
    """Degrees; X first, for row vectors."""
    (a, b), (c, d), (e, f) = ((math.cos(math.radians(v)), math.sin(math.radians(v))) for v in (x, y, z))
    about_x = turned((1, 0, 0, 0, a, b, 0, -b, a))
    about_y = turned((c, 0, -d, 0, 1, 0, d, 0, c))
    about_z = turned((e, f, 0, -f, e, 0, 0, 0, 1))
    return product(about_x, about_y, about_z)


# --- Controls ------------------------------------------------------------------------------------

def make_controls(frame, nodes):
    """Outlines across the spine with an arrow forward, under groups that stand on it."""
    out = {}
    for control in GRAPH["controls"]:
        half, name = control["half_size"] * frame.scale, control["name"]
        corners = [(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1), (0, 1), (0, 1.5), (-0.2, 1.2), (0, 1.5), (0.2, 1.2)]
        group = nodes.add("transform", name + "_group")
        curve = cmds.curve(name="even_" + name, degree=1, point=[(0, half * y, half * z) for z, y in corners])
        curve = cmds.parent(curve, group, relative=True)[0]
        nodes.made.append(curve)
        for attribute in ("tx", "ty", "tz", "sx", "sy", "sz"):
            cmds.setAttr("%s.%s" % (curve, attribute), lock=True, keyable=False)
        limit = GRAPH["limit_deg"]
        for axis in ("X", "Y", "Z"):
            cmds.transformLimits(curve, **{"rotation" + axis: (-limit, limit), "enableRotation" + axis: (True, True)})
        cmds.setAttr(curve + ".overrideEnabled", True)
        cmds.setAttr(curve + ".overrideColor", COLORS[name])
        out[name], out[name + "_group"] = curve, group
    return out


def find_followers():
    """(joint, leader) of what hangs from nothing here and goes with a spine joint; the rest is left as it is."""
    found = []
    for follower in GRAPH["followers"]:
        leader, alike = joint_called(follower["leader"]), joints_called(follower["name"])
        if len(alike) != 1:
            print("backbend: %d joints are called '%s': left as they are" % (len(alike), follower["name"]))
            continue
        parent = cmds.listRelatives(alike[0], parent=True, fullPath=True)
        if not parent:
            found.append((alike[0], leader))
        elif not alike[0].startswith(leader + "|"):
            print("backbend: '%s' hangs from '%s' and not from '%s': left as it is" % (alike[0], parent[0], leader))
    return found


def follow(nodes, followers):
    """Their own channels stay free."""
    for k, (joint, leader) in enumerate(followers):
        carried = nodes.multiplied("follower%02d" % k, [inverse(world_of(leader)), leader + ".worldMatrix[0]"])
        cmds.connectAttr(carried, joint + ".offsetParentMatrix")


# --- Both commands -------------------------------------------------------------------------------

def check_free(joints):
    """Raises EvenError where a joint is driven or locked already."""
    for joint in joints:
        for attribute in ("translate", "rotate"):
            for suffix in ("", "X", "Y", "Z"):
                plug = "%s.%s%s" % (joint, attribute, suffix)
                if cmds.listConnections(plug, source=True, destination=False):
                    raise EvenError("'%s' is driven already: disconnect it first" % plug)
                if cmds.getAttr(plug, lock=True):
                    raise EvenError("'%s' is locked: unlock it first" % plug)


def build():
    """The spine on the scene's joints. Raises EvenError, and changes nothing then."""
    if cmds.objExists(RECORD):
        raise EvenError("the scene has the spine already: remove() it first")
    frame = Frame()
    check_free(frame.joints)
    followers = find_followers()
    if not cmds.pluginInfo("matrixNodes", query=True, loaded=True):
        cmds.loadPlugin("matrixNodes", quiet=True)
    nodes = Nodes()
    rest = [(joint, cmds.getAttr(joint + ".translate")[0], cmds.getAttr(joint + ".rotate")[0])
            for joint in frame.joints]
    cmds.undoInfo(openChunk=True, chunkName="backbend even")
    try:
        spine = Spine(frame, make_controls(frame, nodes), nodes)
        for k, (entry, joint) in enumerate(zip(GRAPH["joints"], frame.joints)):
            spine.drive(k, entry, joint)
        spine.carry_controls()
        follow(nodes, followers)
        record = nodes.add("network", "record")
        record = cmds.rename(record, RECORD)
        nodes.made[-1] = record
        cmds.addAttr(record, longName="made", dataType="string")
        cmds.setAttr(record + ".made", json.dumps(
            {"nodes": nodes.made, "rest": rest, "followers": [joint for joint, _ in followers]}), type="string")
    finally:
        cmds.undoInfo(closeChunk=True)
    return nodes.made


def remove():
    """Takes away all that build() made, and puts the joints back to their rest. Raises EvenError."""
    if not cmds.objExists(RECORD):
        raise EvenError("the scene has no spine of backbend")
    record = json.loads(cmds.getAttr(RECORD + ".made"))
    cmds.undoInfo(openChunk=True, chunkName="remove backbend even")
    try:
        for node in record["nodes"]:
            if cmds.objExists(node):
                cmds.delete(node)
        for joint, translate, rotate in record["rest"]:
            cmds.setAttr(joint + ".translate", *translate, type="double3")
            cmds.setAttr(joint + ".rotate", *rotate, type="double3")
        for joint in record["followers"]:
            cmds.setAttr(joint + ".offsetParentMatrix", *IDENTITY, type="matrix")
    finally:
        cmds.undoInfo(closeChunk=True)


if __name__ == "__main__":
    build()
