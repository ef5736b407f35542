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

# How far a character has to be clean: as `backbend explain envelope` has it. A mapping names one, or gives its own.
ENVELOPES = {
    "human": {"extension": 60, "flexion": 90, "side": 45, "twist": 60},
    "animal": {"extension": 30, "flexion": 60, "side": 45, "twist": 30},
    "long_neck": {"extension": 20, "flexion": 30, "side": 30, "twist": 20},
    "snake": {"extension": 45, "flexion": 45, "side": 90, "twist": 30},
    "neck": {"extension": 60, "flexion": 90, "side": 60, "twist": 60},
    "cartoon": {"extension": 120, "flexion": 120, "side": 75, "twist": 120},
    "creature": {"extension": 45, "flexion": 60, "side": 60, "twist": 45},
}
CORNER_STEPS = 10  # from rest to a corner
GRID_STEP = 15  # degrees of bend along the grid's paths; side and twist go by quarters of their range


def envelope_of(mapping):
    """What the character must do, degrees by channel: the mapping's `envelope`, a name or a table [human]."""
    wanted = mapping.get("envelope", "human")
    return dict(ENVELOPES[wanted] if isinstance(wanted, str) else wanted)


def sweeps(channels, stress=False, envelope=None):
    """The sweeps of single channels that a mapping has: (name, [degrees, ...]), each at least to the envelope's end."""
    needs = envelope or ENVELOPES["human"]
    ends = {}
    for name, first, last, step in STANDARD_SWEEPS + (STRESS_SWEEPS if stress else []):
        if name in channels:
            far = max(last, needs.get(name, 0))
            ends[name] = (-far if first < 0 else 0, far, step)
    if not ends:
        raise ValueError("the mapping has none of the channels extension, flexion, side and twist")
    found = []
    for name, (first, last, step) in ends.items():
        count = int(math.ceil((last - first) / step - 1e-9))
        found.append((name, [first + (last - first) * k / count for k in range(count + 1)]))
    return found


def ways(values):
    """A list with rest, from a range: (-45, 45) is [-45, 45, 0]."""
    return [value for value in values if value] + [0]


def corners(channels, envelope):
    """From rest straight to each corner of the envelope and of its faces: (name, [{channel: degrees}, ...])."""
    def end(name):
        return envelope.get(name, 0) if name in channels else 0
    bends = [(name, end(name)) for name in ("extension", "flexion") if end(name)] + [("extension", 0)]
    found = []
    for bend, far in bends:
        for side in ways((end("side"), -end("side"))):
            for twist in ways((end("twist"), -end("twist"))):
                goal = {name: value for name, value in ((bend, far), ("side", side), ("twist", twist)) if value}
                if len(goal) < 2:
                    continue
                name = "corner " + " ".join(f"{channel} {value:g}" for channel, value in goal.items())
                found.append((name, [{channel: value * k / CORNER_STEPS for channel, value in goal.items()}
                                     for k in range(CORNER_STEPS + 1)]))
    return found


def grid(channels, single):
    """The whole bend at pairs of side and twist: what only a compound pose shows. `single`: sweeps() of the mapping."""
    ends = {name: max(abs(value) for value in values) for name, values in single}
    back, front = ends.get("extension", 0), ends.get("flexion", 0)
    if not back and not front:
        return []
    bends = []
    for name, far in (("flexion", front), ("extension", back)):
        count = int(math.ceil(far / GRID_STEP - 1e-9))
        leg = [{name: far * k / count} for k in range(1, count + 1)] if count else []
        bends += [*reversed(leg), {}] if name == "flexion" else leg
    found = []
    for across in (-1, -0.5, 0, 0.5, 1):
        for around in (-1, -0.5, 0, 0.5, 1):
            held = {name: far * part for name, far, part in
                    (("side", ends.get("side", 0), across), ("twist", min(ends.get("twist", 0), 90), around))
                    if far * part}
            name = "grid" + "".join(f" {channel} {value:g}" for channel, value in held.items())
            if held and name not in [other for other, _ in found]:
                found.append((name, [{**bend, **held} for bend in bends]))
    return found


def paths(mapping, stress=False):
    """All that record() drives: (name, [{channel: degrees}, ...]). Single channels to their ends, the envelope's
    corners, a grid of compound poses, and the way back to rest from a corner."""
    channels, envelope = mapping["channels"], envelope_of(mapping)
    single = sweeps(channels, stress, envelope)
    found = [(name, [{name: value} for value in values]) for name, values in single]
    to_corners = corners(channels, envelope)
    found += to_corners + grid(channels, single)
    if to_corners:
        found.append(("return to rest", list(reversed(to_corners[0][1]))))
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
    envelope = mapping.get("envelope", "human")
    if isinstance(envelope, str):
        if envelope not in ENVELOPES:
            raise ValueError(f"envelope: '{envelope}' is none of {', '.join(ENVELOPES)}")
    elif not isinstance(envelope, dict) or set(envelope) - known or not all(
            isinstance(value, (int, float)) and math.isfinite(value) and value >= 0 for value in envelope.values()):
        raise ValueError("envelope: neither a name nor degrees of extension, flexion, side and twist")
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
    """Drives every path of a mapping and collects its poses.

    `set_control(control, channel, value)` sets one control to its rest value plus `value`;
    `read_pose()` gives (matrices, points) of the scene as it then stands.
    """
    check_mapping(mapping)

    def pose(degrees, moved):
        # One control may serve several channels: what they ask of it adds up.
        total = {}
        for name in moved:
            for target in mapping["channels"][name]:
                key = (target["control"], target["channel"])
                total[key] = total.get(key, 0.0) + degrees.get(name, 0.0) * target.get("per_degree", 1.0)
        for (control, channel), value in total.items():
            set_control(control, channel, value)

    for name, poses in paths(mapping, stress):
        moved = sorted({channel for degrees in poses for channel in degrees})
        for degrees in poses:
            pose(degrees, moved)
            matrices, points = read_pose()
            writer.add(matrices, points, sweep=name, controls={channel: degrees.get(channel, 0) for channel in moved})
        pose({}, moved)
        say(f"backbend: {name}, {len(poses)} poses")
