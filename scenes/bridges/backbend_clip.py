"""Writes `backbend.clip/1`: what a rig did, pose by pose, for `backbend check --baked`.

Needs nothing but Python 3: Blender, Maya and Houdini all bring it. The form is one line of JSON and
then little-endian float32 numbers; docs/bridges/clip.md describes it.
"""

import array
import json
import math
import os
import sys

STANDARD_SWEEPS = [("extension", 0, 120, 2), ("flexion", 0, 90, 2), ("side", -45, 45, 2), ("twist", -90, 90, 2)]
STRESS_SWEEPS = [("extension", 0, 180, 2), ("twist", -360, 360, 2)]


def sweeps(channels, stress=False):
    """The sweeps of the channels that a mapping has: (name, [degrees, ...])."""
    found = []
    for name, first, last, step in STANDARD_SWEEPS + (STRESS_SWEEPS if stress else []):
        if name not in channels:
            continue
        count = int(round((last - first) / step))
        values = [first + step * k for k in range(count + 1)]
        if stress and any(other == name for other, _ in found):
            found = [entry for entry in found if entry[0] != name]
        found.append((name, values))
    if not found:
        raise ValueError("the mapping has none of the channels extension, flexion, side and twist")
    return found


def check_mapping(mapping):
    """Raises ValueError for a mapping that cannot be used, naming the place.

    {"spine": ["hips", ..., "chest"], "arms": {"left": [...], "right": [...]},
     "channels": {"twist": [{"control": "chest_ctl", "channel": "ry", "per_degree": 1.0}, ...]}}
    """
    if not isinstance(mapping.get("channels"), dict) or not mapping["channels"]:
        raise ValueError("channels: missing or empty")
    known = {name for name, _, _, _ in STANDARD_SWEEPS}
    for name, targets in mapping["channels"].items():
        if name not in known:
            raise ValueError(f"channels: '{name}' is none of {', '.join(sorted(known))}")
        if not isinstance(targets, list) or not targets:
            raise ValueError(f"channels/{name}: not a list of controls")
        for k, target in enumerate(targets):
            for key in ("control", "channel"):
                if not isinstance(target.get(key), str):
                    raise ValueError(f"channels/{name}/{k}/{key}: missing")
            factor = target.get("per_degree", 1.0)
            if not isinstance(factor, (int, float)) or not math.isfinite(factor):
                raise ValueError(f"channels/{name}/{k}/per_degree: not a number")
    if not mapping.get("spine") or len(mapping["spine"]) < 2:
        raise ValueError("spine: fewer than two joints")


class ClipWriter:
    """Collects poses and writes them in one piece.

    `joints`: [(name, index of the parent or -1, rest matrix), ...]. Matrices are sixteen numbers,
    column by column (the fourth column is the position), from the joint to the world.
    """

    def __init__(self, joints, points=0, up="Y", metres_per_unit=1.0, program="", scene="",
                 spine=None, arms=None):
        self.points = points
        self.header = {
            "schema": "backbend.clip/1",
            "source": {"program": program, "file": os.path.basename(scene)},
            "up": up,
            "metres_per_unit": metres_per_unit,
            "joints": [{"name": name, "parent": parent, "rest": [float(v) for v in rest]}
                       for name, parent, rest in joints],
            "points": points,
            "poses": [],
        }
        if spine:
            self.header["spine"] = list(spine)
        if arms:
            self.header["arms"] = {side: list(names) for side, names in arms.items()}
        self.matrices = array.array("f")
        self.positions = array.array("f")

    def add(self, matrices, points=None, sweep="clip", controls=None, time=None):
        """One pose: a matrix for every joint, three numbers for every point."""
        flat = [float(v) for matrix in matrices for v in matrix]
        if len(flat) != 16 * len(self.header["joints"]):
            raise ValueError(f"{len(flat)} numbers for {len(self.header['joints'])} joints")
        if len(points or []) != 3 * self.points:
            raise ValueError(f"{len(points or [])} numbers for {self.points} points")
        for value in flat:
            if not math.isfinite(value):
                raise ValueError(f"pose {len(self.header['poses'])} of {sweep} is not finite")
        self.matrices.extend(flat)
        self.positions.extend(points or [])
        pose = {"sweep": sweep, "time": len(self.header["poses"]) / 24.0 if time is None else time}
        if controls:
            pose["controls"] = controls
        self.header["poses"].append(pose)

    def save(self, path):
        """Writes beside the target first, so that a clip is there whole or not at all."""
        for numbers in (self.matrices, self.positions):
            if sys.byteorder == "big":
                numbers.byteswap()
        temporary = path + ".part"
        with open(temporary, "wb") as file:
            file.write(json.dumps(self.header).encode() + b"\n")
            file.write(self.matrices.tobytes())
            file.write(self.positions.tobytes())
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)


def record(mapping, stress, set_control, read_pose, writer, say=print):
    """Drives every sweep of a mapping and collects its poses.

    `set_control(control, channel, value)` sets one control to its rest value plus `value`;
    `read_pose()` gives (matrices, points) of the scene as it then stands.
    """
    check_mapping(mapping)
    for name, values in sweeps(mapping["channels"], stress):
        targets = mapping["channels"][name]
        for value in values:
            for target in targets:
                set_control(target["control"], target["channel"], value * target.get("per_degree", 1.0))
            matrices, points = read_pose()
            writer.add(matrices, points, sweep=name, controls={name: value})
        for target in targets:
            set_control(target["control"], target["channel"], 0.0)
        say(f"backbend: {name}, {len(values)} poses")
