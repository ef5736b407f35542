"""Lets backbend ask a Houdini rig for its poses: a recipe. It was not run in Houdini.

    backbend check hero.glb --rig command:"hython backbend_houdini.py hero.hip mapping.json"

The mapping names the network's output (a KineFX skeleton: points with `name` and `transform`), its rest, and the
parameters that stand for each channel; see docs/bridges/houdini.md. Everything that thinks is in backbend_scene.py.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True  # nothing is left beside this file, which may be installed
import backbend_rig  # noqa: E402  (beside this file)
import backbend_scene  # noqa: E402


class Host:
    """The open scene as backbend_scene.SceneServer asks for it. `hou` is Houdini's module, or anything that answers
    like it."""

    def __init__(self, mapping, hou):
        self.hou = hou
        self.program = "Houdini " + hou.applicationVersionString()
        self.scene = hou.hipFile.basename()
        self.up, self.metres_per_unit = "Y", float(mapping.get("metres_per_unit", 1.0))
        self.skeleton = self.node("skeleton", mapping.get("skeleton"))
        self.rest = self.node("rest", mapping["rest"]) if mapping.get("rest") else None
        self.body = self.node("mesh", mapping["mesh"]) if mapping.get("mesh") else None
        self.parameter_of = {}

    def node(self, key, path):
        if not isinstance(path, str) or self.hou.node(path) is None:
            raise ValueError(f"{key}: no node '{path}' in the scene" if path else f"{key}: missing")
        return self.hou.node(path)

    @staticmethod
    def standing(node):
        """{name: matrix} of a KineFX skeleton."""
        found = {}
        for point in node.geometry().points():
            t, p = point.attribValue("transform"), point.position()
            # Houdini's row vectors, row by row, are our columns.
            found[point.attribValue("name")] = [*t[0:3], 0.0, *t[3:6], 0.0, *t[6:9], 0.0, p[0], p[1], p[2], 1.0]
        return found

    def joints(self):
        above = {}
        for line in self.skeleton.geometry().prims():
            names = [vertex.point().attribValue("name") for vertex in line.vertices()]
            above.update(zip(names[1:], names))
        still = self.standing(self.rest or self.skeleton)
        ordered = []
        for name in still:
            chain = [name]
            while chain[-1] in above and chain[-1] not in ordered:
                if above[chain[-1]] in chain:
                    raise ValueError(f"the joint '{name}' is above itself")
                chain.append(above[chain[-1]])
            ordered += [each for each in reversed(chain) if each not in ordered]
        missing = [name for name in ordered if name not in still]
        if missing:
            raise ValueError(f"rest: no joint '{missing[0]}'")
        return [(name, ordered.index(above[name]) if name in above else -1, still[name]) for name in ordered]

    def channels(self, wanted):
        found = []
        for name in wanted:
            control, _, channel = name.rpartition(".")
            node = self.hou.node(control)
            parameter = node.parm(channel) if node is not None else None
            if parameter is None:
                continue  # what is not there is named by who asked for it
            if parameter.isLocked():
                raise ValueError(f"'{control}/{channel}' is locked")
            self.parameter_of[name] = parameter
            # r, or r and a number: `rx` of an object, `r0x` of a Rig Pose.
            turns = channel[:1] == "r" and channel[-1:] in "xyz" and (channel[1:-1].isdigit() or len(channel) == 2)
            found.append((name, "rotation" if turns else "scalar", True))
        return found

    def get(self, channel):
        return float(self.parameter_of[channel].eval())

    def set(self, channel, value):
        self.parameter_of[channel].set(value)

    def matrices(self, names):
        now = self.standing(self.skeleton)
        return [now[name] for name in names]

    def mesh(self):
        if self.body is None:
            return None
        # Houdini's faces go round the other way.
        faces = [[vertex.point().number() for vertex in reversed(face.vertices())] for face in self.body.geometry().prims()]
        return self.points(), backbend_scene.fans(faces)

    def points(self):
        return self.body.geometry().pointFloatAttribValues("P")


def open_scene(path, mapping):
    import hou

    hou.hipFile.load(path, suppress_save_prompt=True)  # no question is asked that nobody answers
    return Host(mapping, hou)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        raise SystemExit("usage: hython backbend_houdini.py SCENE MAPPING.json")
    # The streams are taken before the scene is opened: it prints.
    backbend_scene.serve(open_scene, sys.argv[1:], backbend_rig.own_streams())
