"""Lets backbend ask a Maya rig for its poses, or exports its motion.

    backbend check hero.glb --rig maya:hero.ma --map mapping.json

starts this file by itself, in mayapy with --serve, and speaks docs/rig_protocol.md with it. In Maya's script editor
(Python), with this folder on the path:

    import backbend_maya
    backbend_maya.export("mapping.json", "hero.clip")

Everything that thinks is in backbend_scene.py and backbend_clip.py; this file only asks Maya. docs/bridges/maya.md.
"""

import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
if __name__ == "__main__":
    sys.dont_write_bytecode = True  # nothing is left beside this file, which may be installed
import backbend_clip  # noqa: E402  (beside this file)
import backbend_rig  # noqa: E402
import backbend_scene  # noqa: E402

# Attributes of Maya for the channels of a mapping; any other word is an attribute's own name.
ATTRIBUTES = {"rx": "rotateX", "ry": "rotateY", "rz": "rotateZ",
              "x": "translateX", "y": "translateY", "z": "translateZ"}
CHANNELS = {attribute: channel for channel, attribute in ATTRIBUTES.items()}
METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048, "yd": 0.9144}


class Scene:
    """Joints, controls and a mesh of the open scene, as backbend_clip.record() drives them.

    `cmds` is maya.cmds, or anything that answers like it.
    """

    def __init__(self, mapping, cmds):
        self.cmds = cmds
        self.mesh = mapping.get("mesh")
        self.start = {}
        root = mapping.get("root") or mapping["spine"][0]
        if not cmds.objExists(root):
            raise ValueError(f"root: no joint '{root}' in the scene")
        below = cmds.listRelatives(root, allDescendents=True, type="joint", fullPath=True) or []
        top = cmds.ls(root, long=True)[0]
        # Sorted by path, parents stand before their children.
        self.paths = sorted([top] + below)
        self.names = [path.split("|")[-1] for path in self.paths]
        for name in mapping["spine"]:
            if name not in self.names:
                raise ValueError(f"spine: '{name}' is not below '{root}'")

    def parents(self):
        place = {path: k for k, path in enumerate(self.paths)}
        found = []
        for path in self.paths:
            above = path.rpartition("|")[0]
            while above and above not in place:
                above = above.rpartition("|")[0]
            found.append(place.get(above, -1))
        return found

    def matrices(self):
        # Maya writes matrices row by row for row vectors: the same sixteen numbers as column by
        # column for column vectors.
        return [self.cmds.xform(path, query=True, matrix=True, worldSpace=True) for path in self.paths]

    def points(self):
        if not self.mesh:
            return []
        return self.cmds.xform(self.mesh + ".vtx[*]", query=True, translation=True, worldSpace=True)

    def set_control(self, control, channel, value):
        attribute = f"{control}.{ATTRIBUTES.get(channel, channel)}"
        if not self.cmds.objExists(attribute):
            raise ValueError(f"no attribute '{attribute}' in the scene")
        if attribute not in self.start:
            self.start[attribute] = self.cmds.getAttr(attribute)
        self.cmds.setAttr(attribute, self.start[attribute] + value)

    def read_pose(self):
        return self.matrices(), self.points()


def export_with(cmds, mapping, path, stress=False, say=print):
    """As export(), with a mapping that is read already and any `cmds`."""
    backbend_clip.check_mapping(mapping)
    scene = Scene(mapping, cmds)
    rest, points = scene.matrices(), scene.points()
    writer = backbend_clip.ClipWriter(
        list(zip(scene.names, scene.parents(), rest)), points=len(points) // 3,
        up=cmds.upAxis(query=True, axis=True).upper(),
        metres_per_unit=METRES[cmds.currentUnit(query=True, linear=True)],
        program="Maya " + str(cmds.about(version=True)), scene=cmds.file(query=True, sceneName=True) or "",
        spine=mapping["spine"], arms=mapping.get("arms"))
    try:
        backbend_clip.record(mapping, stress, scene.set_control, scene.read_pose, writer, say)
    finally:
        for attribute, value in scene.start.items():  # an artist's scene is left as it was
            cmds.setAttr(attribute, value)
    writer.save(path)


def export(mapping_file, path, stress=False):
    """Drives the standard (or stress) sweeps of the open scene, which stands at rest, and writes
    the clip. Angles of the scene must be shown in degrees, Maya's default."""
    from maya import cmds
    with open(mapping_file, encoding="utf-8") as file:
        export_with(cmds, json.load(file), path, stress)


def kind_of(channel):
    """As docs/rig_protocol.md has it."""
    return "rotation" if channel in ("rx", "ry", "rz") else "translation" if channel in ("x", "y", "z") else "scalar"


class Host:
    """The open scene as backbend_scene.SceneServer asks for it. `cmds` is maya.cmds, or anything that answers like it."""

    def __init__(self, mapping, cmds):
        self.cmds, self.mapping = cmds, mapping
        cmds.currentUnit(angle="deg")
        cmds.undoInfo(state=False)  # thousands of poses would be kept
        self.program = "Maya " + str(cmds.about(version=True))
        self.scene = cmds.file(query=True, sceneName=True) or ""
        self.up = cmds.upAxis(query=True, axis=True).upper()
        self.metres_per_unit = METRES[cmds.currentUnit(query=True, linear=True)]
        root = mapping.get("root")
        if root and not cmds.objExists(root):
            raise ValueError(f"root: no joint '{root}' in the scene")
        found = (cmds.ls(root, long=True) + (cmds.listRelatives(root, allDescendents=True, type="joint", fullPath=True)
                                             or [])) if root else cmds.ls(type="joint", long=True)
        # Sorted by path, parents stand before their children.
        paths = sorted(set(found))
        self.path_of = dict(zip(backbend_scene.unique_names(paths), paths))
        self.attribute_of = {}
        self.shapes = self.find_shapes()

    def joints(self):
        place = {path: k for k, path in enumerate(self.path_of.values())}
        return [(name, backbend_scene.nearest_above(path, place), self.rest_of(path))
                for name, path in self.path_of.items()]

    def rest_of(self, path):
        """Where a skin was bound to the joint; where none is, where it stands."""
        for plug in self.cmds.listConnections(path + ".worldMatrix[0]", type="skinCluster", plugs=True) or []:
            skin, _, index = plug.partition(".matrix[")
            if index:
                return backbend_scene.inverse(self.cmds.getAttr(f"{skin}.bindPreMatrix[{index}"))
        return self.matrix(path)

    def matrix(self, path):
        # Maya writes matrices row by row for row vectors: the same sixteen numbers as column by
        # column for column vectors.
        return self.cmds.xform(path, query=True, matrix=True, worldSpace=True)

    def matrices(self, names):
        return [self.matrix(self.path_of[name]) for name in names]

    def channels(self, wanted):
        """Of the transforms that have a curve as their shape, what may be keyed and is free; of others, what is wanted."""
        found = []
        curves = self.cmds.ls(type="nurbsCurve", long=True) or []
        shaped = sorted({path.rpartition("|")[0] for path in curves})
        for control, path in zip(backbend_scene.unique_names(shaped), shaped):
            for attribute in self.cmds.listAttr(path, keyable=True, scalar=True) or []:
                if self.cmds.getAttr(f"{path}.{attribute}", settable=True):
                    found.append(self.add(control, path, attribute, True))
        known = {name for name, _, _ in found}
        for name in wanted:
            control, _, channel = name.rpartition(".")
            attribute = ATTRIBUTES.get(channel, channel)
            if name in known or not self.cmds.objExists(f"{control}.{attribute}"):
                continue  # what is not there is named by who asked for it
            if not self.cmds.getAttr(f"{control}.{attribute}", settable=True):
                raise ValueError(f"'{control}.{attribute}' is locked or driven, so that it cannot be set")
            found.append(self.add(control, control, attribute, True))
        return found

    def add(self, control, path, attribute, is_control):
        channel = CHANNELS.get(attribute, attribute)
        name = backbend_scene.channel_name(control, channel)
        self.attribute_of[name] = f"{path}.{attribute}"
        return name, kind_of(channel), is_control

    def get(self, channel):
        return float(self.cmds.getAttr(self.attribute_of[channel]))

    def set(self, channel, value):
        self.cmds.setAttr(self.attribute_of[channel], value)

    def find_shapes(self):
        """The meshes that skins deform, or those that the mapping names; none where it says false."""
        wanted = self.mapping.get("mesh")
        if wanted is False:
            return []
        if wanted:
            names = [wanted] if isinstance(wanted, str) else list(wanted)
            for name in names:
                if not self.cmds.objExists(name):
                    raise ValueError(f"mesh: no '{name}' in the scene")
            return names
        shapes = {shape for skin in self.cmds.ls(type="skinCluster") or []
                  for shape in self.cmds.skinCluster(skin, query=True, geometry=True) or []}
        return sorted(shape for shape in shapes if self.cmds.objectType(shape) == "mesh")

    def mesh(self):
        if not self.shapes:
            return None
        triangles, first = [], 0
        for shape in self.shapes:
            faces = [[first + int(vertex) for vertex in line.split(":")[1].split()]
                     for line in self.cmds.polyInfo(shape, faceToVertex=True)]
            triangles += backbend_scene.fans(faces)
            first += self.cmds.polyEvaluate(shape, vertex=True)
        return self.points(), triangles

    def points(self):
        return [v for shape in self.shapes
                for v in self.cmds.xform(shape + ".vtx[*]", query=True, translation=True, worldSpace=True)]


def open_scene(path, mapping):
    import maya.standalone

    maya.standalone.initialize(name="python")
    from maya import cmds
    cmds.file(path, open=True, force=True, prompt=False)  # no question is asked that nobody answers
    return Host(mapping, cmds)


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] != "--serve":
        raise SystemExit("usage: mayapy backbend_maya.py --serve SCENE [MAPPING.json]")
    # The streams are taken before Maya starts: it prints.
    backbend_scene.serve(open_scene, sys.argv[2:], backbend_rig.own_streams())
