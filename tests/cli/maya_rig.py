"""The script for Maya, run in a scene that has the character's spine, and asked for poses."""

import re
import sys
from unittest import mock

import maya_scene


def maya_name(joint):
    return re.sub(r"\W", "_", joint)


class MayaRig:
    """Of a graph: its joints as a chain in centimetres, hips first, with their turn at rest in jointOrient;
    `oddities` go to MayaScene.add_joint(). One of two arms hangs from the chest, and one from nothing."""

    def __init__(self, graph, up="y", **oddities):
        to_scene = maya_scene.IDENTITY if up == "y" else maya_scene.rotation((90, 0, 0))
        self.graph, self.scene, parent = graph, maya_scene.MayaScene(up), None
        entries = [(graph["hips"], graph["hips_rest"])] + [(joint["name"], joint["rest"]) for joint in graph["joints"]]
        for name, rest in entries:
            world = maya_scene.product(tuple(rest), to_scene)  # a file's columns are Maya's rows
            world = maya_scene.moved_to(world, [100 * v for v in world[12:15]])
            parent = self.scene.add_joint(maya_name(name), parent, world, **oddities)
        for follower, above in zip(graph["followers"], (parent, None)):
            self.scene.add_joint(maya_name(follower["name"]), above, world)
        self.chest = maya_name(graph["joints"][-1]["name"])
        self.rest = {name: self.scene.world(maya_name(name)) for name, _ in entries}

    def run(self, script):
        """What the script defines."""
        names = {"__name__": "__main__", "print": lambda *_: None}
        with mock.patch.dict(sys.modules, self.scene.as_module()):
            exec(compile(script.read_text(), str(script), "exec"), names)
        return names

    def poses(self, poses):
        """[(turn from rest, place)] of the joints above the hips, metres, in the scene's axes."""
        out = []
        for pose in poses:
            self.scene.pose({f"even_{name}.rotate": tuple(pose[3 * k:3 * k + 3])
                             for k, name in enumerate(("lower", "middle", "top"))})
            out.append([self.moved(joint["name"]) for joint in self.graph["joints"]])
        return out

    def moved(self, joint):
        world = self.scene.world(maya_name(joint))
        moved = maya_scene.product(maya_scene.inverse(self.rest[joint]), world)
        return [[moved[4 * j + i] for j in range(3)] for i in range(3)], [v / 100 for v in world[12:15]]
