#!/usr/bin/env python3
"""Processor seconds of a night, fitted against poses, vertices and pixels, and what a thousand characters would take.

    tests/bench/night_cost.py [--sizes 5000,17000,58000] [--program FILE]

Runs nights of one human in each size under three rigs, at three steps of its sweeps, without pictures, and those of the
smallest size with pictures of three sizes. Prints each, two least-squares fits, and from these a farm's hours.
"""

import argparse
import json
import pathlib
import shutil
import tempfile

import numpy as np

from studio_suite import SOURCE, body_of, measured, suite_of

STEPS = (1, 5, 15)
VERTICES = 20000
PICTURES = ((320, 240), (640, 480), (960, 720))


def night(program, folder, size, step, arguments):
    """Processor seconds, poses, frames of its sweeps, and stills of its findings."""
    out = folder / "run"
    (folder / "suite.toml").write_text(suite_of([f"human_{size}.glb"], step))
    _, seconds, _ = measured([program, "nightly", "suite.toml", "--fresh", "-o", out, *arguments], folder)
    report = json.loads((out / "report.json").read_text())
    # `1 234 poses measured, ...`
    poses = int("".join(filter(str.isdigit, report["headline"].partition(" poses")[0])))
    frames, stills = len(list(out.glob("review/*/*.png"))), len(list(out.glob("findings/*/*.exr")))
    shutil.rmtree(out)
    return seconds, poses, frames, stills


def fit(seconds, *columns):
    return np.linalg.lstsq(np.stack([np.ones(len(seconds)), *map(np.array, columns)], 1), np.array(seconds), rcond=None)[0]


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--sizes", default=[5000, 17000, 58000], type=lambda text: [int(each) for each in text.split(",")])
    options.add_argument("--program", default=SOURCE / "build/release/cli/backbend", type=pathlib.Path)
    options = options.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        plain = {}
        for size in options.sizes:
            body_of(program, folder, "human", size)
            for step in STEPS:
                seconds, poses, _, _ = night(program, folder, size, step, ["--quick"])
                plain[size, step] = seconds, poses
                print(f"{size} vertices, {poses} poses: {seconds:.1f} s", flush=True)
        pictured = []
        size = options.sizes[0]
        for step in STEPS:
            for width, height in PICTURES:
                seconds, poses, frames, stills = night(program, folder, size, step, ["--res", f"{width}x{height}"])
                pictured.append((seconds - plain[size, step][0], frames, stills * width * height))
                print(f"{size} vertices, {poses} poses, {frames} frames, {stills} stills of {width}x{height}: {seconds:.1f} s",
                      flush=True)
    once, vertex, measure = fit([s for s, _ in plain.values()], [size for size, _ in plain],
                                [p * size for (size, _), (_, p) in plain.items()])
    more, frame, pixel = fit(*zip(*pictured))
    print(f"measured: {once:.2f} s + {1e6 * vertex:.1f} us a vertex + {1e9 * measure:.0f} ns a pose and vertex")
    print(f"pictures: {more:.2f} s + {1e3 * frame:.0f} ms a frame of a sweep + {1e6 * pixel:.2f} us a pixel of a still")
    # The middle step's night at the default size of pictures, of a body of the bundled human's size.
    (_, poses), (_, frames, pixels) = plain[size, STEPS[1]], pictured[len(PICTURES) + 1]
    quick = once + VERTICES * (vertex + poses * measure)
    whole = quick + more + frames * frame + pixels * pixel
    for label, seconds in (("without pictures", quick), ("with", whole)):
        print(f"{VERTICES} vertices, {poses} poses, {label}: {seconds:.1f} s; "
              f"1000 such characters on 64 cores: {1000 * seconds / 64 / 60:.1f} min")


if __name__ == "__main__":
    main()
