"""What the tests and the battery of `export even` share: poses, the solver's own answer to them, the written graph
evaluated as docs/export.md says, and how far two spines are apart."""

import json
import math
import random

from harness import run_backbend

CHANNELS = [f"{control}.{axis}" for control in ("lower", "middle", "top") for axis in ("rx", "ry", "rz")]


def random_poses(count, seed):
    """Nine channels each, degrees, evenly from +-180; every eighth pose has each at an end."""
    draw = random.Random(seed)
    return [[draw.choice((-180.0, 180.0)) if k % 8 == 0 else draw.uniform(-180.0, 180.0) for _ in CHANNELS]
            for k in range(count)]


def solver_poses(graph, poses, folder, options=""):
    """[(turn, place) of each of the graph's joints] of each pose, by `backbend solve`: turns from rest as
    three rows, places in the character's space. `options`: lines of TOML that the graph's rig has beside its joints."""
    file = folder / "spine.toml"
    fractions = [0.0]
    for joint in graph["joints"]:
        if joint["at"] > fractions[-1]:
            fractions.append(joint["at"])
    places = {0.0: graph["origin"], **{joint["at"]: joint["place"] for joint in graph["joints"]}}
    head = (f'[rig]\nsystem = "even"\njoints = {fractions}\n{options}[chain]\n'
            f'joints = {[places[at] for at in fractions]}\nleft = {graph["left"]}\n[pose]\ntop = [0, 0, 0]\n')
    out = []
    for first in range(0, len(poses), 1000):
        some = poses[first:first + 1000]
        file.write_text(head + "".join(
            f"[[key]]\ntime = {k}\npose = {{ lower = {pose[0:3]}, middle = {pose[3:6]}, top = {pose[6:9]} }}\n"
            for k, pose in enumerate(some)))
        told = run_backbend(["solve", file, "--sweep", f"time=0:{max(len(some) - 1, 1)}:1"], folder)
        if told.returncode != 0:
            raise AssertionError(told.stderr)
        for line in told.stdout.splitlines()[:len(some)]:
            joints = json.loads(line)["joints"]
            out.append([(matrix_of(joints[at]["turn"]), joints[at]["position"])
                        for at in (fractions.index(joint["at"]) for joint in graph["joints"])])
    return out


def matrix_of(q):
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def inverse(a):
    across = [[a[1][1] * a[2][2] - a[1][2] * a[2][1], a[0][2] * a[2][1] - a[0][1] * a[2][2], a[0][1] * a[1][2] - a[0][2] * a[1][1]],
              [a[1][2] * a[2][0] - a[1][0] * a[2][2], a[0][0] * a[2][2] - a[0][2] * a[2][0], a[0][2] * a[1][0] - a[0][0] * a[1][2]],
              [a[1][0] * a[2][1] - a[1][1] * a[2][0], a[0][1] * a[2][0] - a[0][0] * a[2][1], a[0][0] * a[1][1] - a[0][1] * a[1][0]]]
    size = sum(a[0][k] * across[k][0] for k in range(3))
    return [[v / size for v in row] for row in across]


def moved(a, v):
    return [sum(row[k] * v[k] for k in range(3)) for row in a]


def euler(angles_deg):
    """R = Rz Ry Rx."""
    (a, b), (c, d), (e, f) = ((math.cos(math.radians(v)), math.sin(math.radians(v))) for v in angles_deg)
    return times([[e, -f, 0], [f, e, 0], [0, 0, 1]],
                 times([[c, 0, d], [0, 1, 0], [-d, 0, c]], [[1, 0, 0], [0, a, -b], [0, b, a]]))


def graph_pose(graph, pose):
    """The graph's joints as docs/export.md says: [(turn, place)]."""
    axes = [transposed([control["axes"][k:k + 3] for k in (0, 3, 6)]) for control in graph["controls"]]

    def turn(control, weights):
        channels = [max(-graph["limit_deg"], min(graph["limit_deg"], c)) for c in pose[3 * control:3 * control + 3]]
        scaled = euler([w * c for w, c in zip(weights, channels)])
        return times(axes[control], times(scaled, transposed(axes[control])))

    def bent(entry):
        return times(turn(1, entry["middle"]), turn(2, entry["top"]))

    lower = turn(0, (1, 1, 1))
    sums = [[0.0, 0.0, 0.0]]
    for sample in graph["samples"]:
        sums.append([a + b for a, b in zip(sums[-1], moved(bent(sample), sample["step"]))])
    return [(times(lower, bent(joint)),
             [a + b for a, b in zip(graph["origin"], moved(lower, sums[joint["samples"]]))])
            for joint in graph["joints"]]


def degrees_between(a, b):
    """Angle of the turn from a to b; both may be off orthogonal by rounding."""
    c = times(transposed(a), b)
    vector = (c[2][1] - c[1][2], c[0][2] - c[2][0], c[1][0] - c[0][1])
    return math.degrees(math.atan2(math.hypot(*vector), c[0][0] + c[1][1] + c[2][2] - 1.0))


class Distance:
    """The farthest that any joint was from its own: degrees, and percent of the spine's length."""

    def __init__(self, length):
        self.length, self.turn_deg, self.place_percent = length, 0.0, 0.0

    def add(self, spine, exact):
        for (turn, place), (exact_turn, exact_place) in zip(spine, exact):
            self.turn_deg = max(self.turn_deg, degrees_between(turn, exact_turn))
            self.place_percent = max(self.place_percent, 100 * math.dist(place, exact_place) / self.length)


def largest_gain(pose_all, poses, step_deg=1.0):
    """The most that any joint turns per degree of one channel: each pose is asked again with one of its
    channels, a different one from pose to pose, moved towards 0 by a step. `pose_all`: poses -> spines."""
    others = []
    for k, pose in enumerate(poses):
        other, channel = list(pose), k % len(pose)
        other[channel] -= math.copysign(step_deg, other[channel])
        others.append(other)
    return max(degrees_between(a[0], b[0]) / step_deg
               for spine, near in zip(pose_all(poses), pose_all(others)) for a, b in zip(spine, near))
