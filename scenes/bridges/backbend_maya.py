"""Exports a Maya rig's motion for backbend.

In Maya's script editor (Python), with this folder on the path:

    import backbend_maya
    backbend_maya.export("mapping.json", "hero.clip")

Everything that thinks is in backbend_clip.py; this file only asks Maya. docs/bridges/maya.md.
"""

import json

import backbend_clip

# Attributes of Maya for the channels of a mapping; any other word is an attribute's own name.
ATTRIBUTES = {"rx": "rotateX", "ry": "rotateY", "rz": "rotateZ",
              "x": "translateX", "y": "translateY", "z": "translateZ"}
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
