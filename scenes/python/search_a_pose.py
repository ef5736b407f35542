#!/usr/bin/env python3
"""Searches the pose of a box where one metric is worst: search_a_pose.py hero.glb --metric mesh_kink"""

import argparse

import backbend
import numpy as np
from numpy.typing import NDArray

CHANNELS = ("extension", "side", "twist")
BOX = np.array([60.0, 45.0, 60.0])  # degrees: extension from 0, the others to both sides


def value_at(body: backbend.Character, rig: backbend.Rig, metric: str, pose: NDArray[np.float64]) -> float:
    measured = body.measure(rig, extension=pose[0], side=pose[1], twist=pose[2])
    if metric not in measured.metric:
        raise SystemExit(f"no metric '{metric}'; there are {', '.join(measured.metric)}")
    return float(measured.metric[metric][0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("character")
    parser.add_argument("--rig", default="even")
    parser.add_argument("--metric", default="mesh_kink")
    parser.add_argument("--evaluations", type=int, default=60)
    arguments = parser.parse_args()
    body = backbend.load(arguments.character)
    rig = backbend.Rig(arguments.rig, body)
    rng = np.random.default_rng(1)  # the same search every time

    # Half of the poses anywhere in the box, then ever nearer to the best.
    low, high = np.array([0.0, -1.0, -1.0]) * BOX, BOX
    best, worst = np.zeros(3), -np.inf
    for number in range(arguments.evaluations):
        near = max(0.0, 2.0 * number / arguments.evaluations - 1.0)
        pose = rng.uniform(low, high)
        if near > 0.0:
            pose = np.clip(best + (pose - best) * 0.5 * (1.0 - near), low, high)
        value = value_at(body, rig, arguments.metric, pose)
        if value > worst:
            best, worst = pose, value
    text = ",".join(f"{channel}={angle:.1f}" for channel, angle in zip(CHANNELS, best))
    print(f"{arguments.metric} {worst:.3f} at {text}")
    print(f"backbend render {arguments.character} --rig {arguments.rig} --pose {text} -o out/")


if __name__ == "__main__":
    main()
