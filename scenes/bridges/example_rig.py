"""A whole rig, served to backbend: what a server of one's own looks like.

    backbend check hero.glb --rig command:"python3 example_rig.py skeleton.json"

skeleton.json holds the character's joints and their places at rest: {"joints": [{"name", "parent", "position"}],
"spine": [names, hips first]}. Every channel is shared equally by the spine's joints; all other joints go with their
parents. With "mesh": {"points": [[x, y, z], ...], "triangles": [[a, b, c], ...], "weights": [[[joint, weight], ...],
...]} in it, the points are served, too.

Faults can be planted, for tests: `--flip CHANNEL=AT:SIZE[:JOINT]` turns the chest, or another joint, by SIZE degrees more from AT
on, `--stop CHANNEL=AT` lets nothing beyond AT arrive,
`--kink CHANNEL=SIZE` adds a corner at the middle joint while the channel is not 0, `--lose CHANNEL` keeps a channel
from the joints, `--reverse CHANNEL` turns it the other way round, `--nod CHANNEL=AT` turns what hangs from the chest back by
three degrees for each from AT on, as a limb does whose target stays behind, `--memory` lets a pose depend on the one before.
Of the mesh: `--pop CHANNEL=AT:SIZE[:WITHIN]` moves a patch on the front by SIZE (the skeleton's unit) from AT on, within
so many degrees; `--bulge CHANNEL=SIZE` moves it by SIZE for every degree;
`--jelly` lets it depend on the pose before.
"""

import json
import math
import sys

sys.dont_write_bytecode = True  # nothing is left beside this file, which may be installed
import backbend_rig  # noqa: E402  (beside this file)

CHANNELS = ("extension", "flexion", "side", "twist")
NO_FAULTS = {"flip": (), "kink": (), "lose": (), "reverse": (), "stop": (), "pop": (), "bulge": (), "nod": (), "memory": False, "jelly": False}
# Y is up, X the character's left: a positive angle about it bends forward.
AXES = {"extension": (-1.0, 0.0, 0.0), "flexion": (1.0, 0.0, 0.0), "side": (0.0, 0.0, -1.0), "twist": (0.0, 1.0, 0.0)}


def rotation(vector):
    """A rotation vector (radians) as nine numbers, row by row."""
    angle = math.sqrt(sum(v * v for v in vector))
    if angle == 0.0:
        return (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    x, y, z = (v / angle for v in vector)
    c, s = math.cos(angle), math.sin(angle)
    t = 1.0 - c
    return (t * x * x + c, t * x * y - s * z, t * x * z + s * y,
            t * x * y + s * z, t * y * y + c, t * y * z - s * x,
            t * x * z - s * y, t * y * z + s * x, t * z * z + c)


def times(a, b):
    return tuple(a[3 * r] * b[c] + a[3 * r + 1] * b[c + 3] + a[3 * r + 2] * b[c + 6]
                 for r in range(3) for c in range(3))


def turned(a, v):
    return tuple(a[3 * r] * v[0] + a[3 * r + 1] * v[1] + a[3 * r + 2] * v[2] for r in range(3))


class Rig:
    def __init__(self, skeleton, faults):
        self.joints = skeleton["joints"]
        self.spine = skeleton["spine"]
        self.faults = {**NO_FAULTS, **faults}
        self.before = None
        self.place = [joint["position"] for joint in self.joints]
        names = [joint["name"] for joint in self.joints]
        self.bends = [names.index(name) for name in self.spine[1:]]
        self.flips = [(name, at, size, names.index(joint[0]) if joint else self.bends[-1])
                      for name, at, size, *joint in self.faults["flip"]]
        self.mesh = skeleton.get("mesh")
        if self.mesh:
            # The patch: what stands farthest out in front of the middle of the spine, fading around it.
            middle = sum(self.place[names.index(name)][1] for name in self.spine) / len(self.spine)
            deep = max(point[2] for point in self.mesh["points"])
            self.patch = [max(0.0, 1.0 - math.dist(point, (point[0] / 2, middle, deep)) / (1.5 * deep))
                          for point in self.mesh["points"]]
            most = max(self.patch)
            self.patch = [share / most for share in self.patch]

    def matrix(self, turn, place):
        return [turn[0], turn[3], turn[6], 0.0, turn[1], turn[4], turn[7], 0.0, turn[2], turn[5], turn[8], 0.0,
                *place, 1.0]

    def declared(self):
        identity = rotation((0.0, 0.0, 0.0))
        return [(joint["name"], joint["parent"], self.matrix(identity, place))
                for joint, place in zip(self.joints, self.place)]

    def pose(self, values):
        degrees = dict(zip(CHANNELS, values))
        for name in self.faults["lose"]:
            degrees[name] = 0.0
        for name in self.faults["reverse"]:
            degrees[name] = -degrees[name]
        for name, at in self.faults["stop"]:
            degrees[name] = min(degrees[name], at)
        if self.faults["memory"]:
            last, self.before = self.before, dict(degrees)
            degrees = {name: value + 0.1 * (last or degrees)[name] for name, value in degrees.items()}
        vector = [sum(degrees[name] * AXES[name][axis] for name in CHANNELS) for axis in range(3)]
        turn = {joint: [math.radians(v) / len(self.bends) for v in vector] for joint in self.bends}
        for name, size in self.faults["kink"]:
            if degrees[name]:
                turn[self.bends[len(self.bends) // 2]][0] += math.radians(size)
        own = {joint: rotation(vector) for joint, vector in turn.items()}
        for name, at in self.faults["nod"]:
            back = [-3.0 * math.radians(max(0.0, degrees[name] - at)) * axis for axis in AXES[name]]
            own.update({k: rotation(back) for k, joint in enumerate(self.joints)
                        if joint["parent"] == self.bends[-1] and k not in own})
        for name, at, size, joint in self.flips:
            if degrees[name] >= at:
                own[joint] = times(own.get(joint, rotation((0.0, 0.0, 0.0))), rotation((0.0, math.radians(size), 0.0)))
        turns, places = [], []
        for k, joint in enumerate(self.joints):
            parent = joint["parent"]
            if parent < 0:
                turns.append(own.get(k, rotation((0.0, 0.0, 0.0))))
                places.append(tuple(self.place[k]))
                continue
            offset = [a - b for a, b in zip(self.place[k], self.place[parent])]
            places.append(tuple(a + b for a, b in zip(places[parent], turned(turns[parent], offset))))
            turns.append(times(turns[parent], own[k]) if k in own else turns[parent])
        self.turns, self.places, self.degrees = turns, places, degrees
        return [self.matrix(turn, place) for turn, place in zip(turns, places)]

    def pose_with_points(self, values):
        """The joints, and the mesh: blended, with a corrective shape on top."""
        matrices, out = self.pose(values), []
        rise = sum(size * min(1.0, (self.degrees[name] - at) / within if within else 1.0)
                   for name, at, size, within in self.faults["pop"] if self.degrees[name] >= at)
        if self.faults["jelly"]:
            last, self.before = self.before, sum(values)
            rise += 0.001 * (last or 0.0)
        rise += sum(size * self.degrees[name] for name, size in self.faults["bulge"])
        for point, weights, share in zip(self.mesh["points"], self.mesh["weights"], self.patch):
            shaped, placed = (point[0], point[1], point[2] + rise * share), [0.0, 0.0, 0.0]
            for joint, weight in weights:
                offset = turned(self.turns[joint], [a - b for a, b in zip(shaped, self.place[joint])])
                placed = [p + weight * (a + b) for p, a, b in zip(placed, self.places[joint], offset)]
            out += placed
        return matrices, out


def main(words):
    faults = {name: [] if none == () else none for name, none in NO_FAULTS.items()}
    files = []
    words = list(words)
    while words:
        word = words.pop(0)
        if word in ("--flip", "--pop"):
            name, _, rest = words.pop(0).partition("=")
            numbers = [float(number) for number in rest.split(":")[:3 if word == "--pop" else 2]]
            faults[word[2:]].append((name, *numbers, 0.0)[:4] if word == "--pop" else (name, *numbers, *rest.split(":")[2:]))
        elif word in ("--kink", "--bulge", "--nod", "--stop"):
            name, _, size = words.pop(0).partition("=")
            faults[word[2:]].append((name, float(size)))
        elif word in ("--lose", "--reverse"):
            faults[word[2:]].append(words.pop(0))
        elif word in ("--memory", "--jelly"):
            faults[word[2:]] = True
        else:
            files.append(word)
    try:
        with open(files[0], encoding="utf-8") as file:
            rig = Rig(json.load(file), faults)
    except (IndexError, OSError, ValueError, KeyError) as error:
        backbend_rig.refuse(f"{files[0] if files else 'no skeleton was named'}: {error}")
    mesh = {}
    if rig.mesh:
        mesh = {"mesh": [[v for row in rig.mesh[key] for v in row] for key in ("points", "triangles")],
                "pose_with_points": rig.pose_with_points}
    backbend_rig.serve([(name, "rotation", 0.0) for name in CHANNELS], rig.declared(), rig.pose,
                       program="example_rig.py", scene=files[0], pure=not faults["memory"], **mesh)


if __name__ == "__main__":
    main(sys.argv[1:])
