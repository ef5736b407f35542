#!/usr/bin/env python3
"""Judges a rig that is written here, in Python, on a character: judge_my_rig.py hero.glb"""

import sys

import backbend
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class EvenShares(backbend.PythonRig):
    """Every joint of the spine above the hips turns by an equal share of the pose; the rest follows its parent."""

    def __init__(self, body: backbend.Character) -> None:
        super().__init__(["extension", "side", "twist"], body.joints, body.parents, body.rest_matrices)
        self.parents, self.rest = body.parents, body.rest_matrices
        self.spine = [body.joints.index(name) for name in body.anatomy.spine[1:]]
        # An axis per channel: a backbend, a bend to the left, a turn to the left, whether the spine stands or lies.
        left = np.array(body.anatomy.left)
        along = self.rest[self.spine[-1]][:3, 3] - self.rest[body.joints.index(body.anatomy.spine[0])][:3, 3]
        along /= np.linalg.norm(along)
        self.axes = np.array([-left, -np.cross(left, along), along])

    def pose(self, values: Floats) -> Floats:
        share = turns(np.radians(values) @ self.axes / len(self.spine))
        world = np.empty((len(values), len(self.parents), 4, 4))
        for joint, parent in enumerate(self.parents):
            world[:, joint] = self.rest[joint]
            if parent >= 0:
                world[:, joint] = world[:, parent] @ np.linalg.inv(self.rest[parent]) @ self.rest[joint]
            if joint in self.spine:
                world[:, joint] = world[:, joint] @ np.linalg.inv(self.rest[joint]) @ about(self.rest[joint], share) @ self.rest[joint]
        return world


def turns(vectors: Floats) -> Floats:
    """N x 4 x 4 rotations about N vectors by their lengths, radians (Rodrigues)."""
    angle = np.linalg.norm(vectors, axis=1)
    axis = vectors / np.where(angle > 0.0, angle, 1.0)[:, None]
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = axis
    cross[:, [1, 2, 0], [2, 0, 1]] = -axis
    out = np.tile(np.eye(4), (len(vectors), 1, 1))
    out[:, :3, :3] += np.sin(angle)[:, None, None] * cross + (1.0 - np.cos(angle))[:, None, None] * cross @ cross
    return out


def about(joint: Floats, turn: Floats) -> Floats:
    """The turns, about the joint's own place."""
    there, back = np.eye(4), np.eye(4)
    there[:3, 3], back[:3, 3] = joint[:3, 3], -joint[:3, 3]
    return there @ turn @ back


def main() -> int:
    body = backbend.load(sys.argv[1])
    report = backbend.judge(body, EvenShares(body))
    print(report.headline)
    for room in report.rigs[0].headroom:
        print(f"  {room.channel:10} clean to {room.clean_to_deg}, needs {room.needs_deg}")
    for finding in report.findings[:3]:
        print(f"  {finding.code} {finding.pose}: {finding.value} {finding.unit} (limit {finding.limit}), owner {finding.owner}")
    return report.exit_code


if __name__ == "__main__":
    sys.exit(main())
