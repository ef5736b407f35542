#!/usr/bin/env python3
"""What asking a live rig costs beside the rig itself: prints ratios, of one run on one machine.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/bench/live_rig.py [BATCHES]

A server in pure Python poses ten joints. It is asked for the same poses through `backbend.Rig`, and by a few lines here
that send and read the bytes of the protocol and do nothing with them. The two take turns, so that whatever else the
machine does slows both: the ratio is the median of those of all rounds. Once with the bend of a chain alone, which no
program with a rig is as quick as, and once with a rig that takes half a millisecond, which is half of what Blender takes
for a Rigify human.
"""

import array
import json
import pathlib
import random
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/cli"))

import glb  # noqa: E402

ROUNDS = 15
BATCH = 256  # kMostPosesAsked
NAMES = ["hips", *(f"spine{k}" for k in range(1, 9)), "chest"]
STEP = 1.6 / len(NAMES)

# Bends forward and back alone, each joint by the same share, and takes as long as it is told.
SERVER = f"""
import math, sys, time
sys.dont_write_bytecode = True
sys.path.insert(0, {str(SOURCE / "scenes/bridges")!r})
import backbend_rig
NAMES = {NAMES!r}

WORK = float(sys.argv[1])  # seconds

def pose(values):
    begin = time.perf_counter() if WORK else 0.0
    while WORK and time.perf_counter() - begin < WORK:
        pass
    share, angle, y, z, out = math.radians(values[0]) / {len(NAMES) - 1}, 0.0, 0.0, 0.0, []
    for _ in NAMES:
        c, s = math.cos(angle), math.sin(angle)
        out.append((1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0, 0, y, z, 1))
        angle += share
        y, z = y + {STEP} * math.cos(angle), z - {STEP} * math.sin(angle)
    return out

rest = pose([0.0])
backbend_rig.serve([("extension", "rotation", 0.0)],
                   [(name, k - 1, rest[k]) for k, name in enumerate(NAMES)], pose)
"""


class Bytes:
    """The server, asked without looking at what it answers."""

    def __init__(self, words):
        self.server = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        json.loads(self.server.stdout.readline())

    def ask(self, values):
        size = 8 * 16 * len(NAMES)
        for first in range(0, len(values), BATCH):
            some = values[first:first + BATCH]
            self.server.stdin.write(json.dumps({"ask": len(some)}).encode() + b"\n" + some.tobytes())
            self.server.stdin.flush()
            self.server.stdout.readline()
            if len(self.server.stdout.read(size * len(some))) != size * len(some):
                raise RuntimeError("a short answer")

    def close(self):
        self.server.stdin.close()
        self.server.wait()
        self.server.stdout.close()


def seconds(call):
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def measure(name, folder, work, count):
    import backbend
    import numpy as np

    spread = random.Random(1)
    # Of every round its own: backbend does not ask for a pose twice.
    rounds = [array.array("d", [spread.uniform(-60.0, 60.0) for _ in range(count)]) for _ in range(ROUNDS + 1)]
    words = [sys.executable, "-B", str(folder / "server.py"), str(work)]
    body = backbend.load(folder / "tube.glb", hip=NAMES[0], chest=NAMES[-1])
    rig = backbend.Rig("command:" + " ".join(map(shlex.quote, words)), body)
    alone = Bytes(words)
    ratios, times = [], []
    for turn, values in enumerate(rounds):
        controls = np.array(values)[:, None]
        own = seconds(lambda: alone.ask(values))
        whole = seconds(lambda: rig.solve(controls))
        if turn > 0:  # the first warms both up
            ratios.append(whole / own)
            times.append(whole)
    alone.close()
    print(f"{name}: {count} poses of {len(NAMES)} joints in batches of {BATCH}: {statistics.median(ratios):.3f} of the "
          f"server's own time, {count / statistics.median(times):.0f} poses a second")


def main():
    count = BATCH * int(sys.argv[1] if len(sys.argv) > 1 else 40)
    with tempfile.TemporaryDirectory(prefix="backbend live ") as holder:
        folder = pathlib.Path(holder)
        (folder / "server.py").write_text(SERVER)
        (folder / "tube.glb").write_bytes(glb.tube(NAMES))
        measure("the bend alone (reach 20000 a second)", folder, 0.0, count)
        measure("half a millisecond a pose (reach 1.10)", folder, 5e-4, max(BATCH, count // 10))


if __name__ == "__main__":
    main()
