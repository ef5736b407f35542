#!/usr/bin/env python3
"""render_against_cycles.py PEERS [CHARACTER]: our renderer beside Blender's Cycles on the same mesh.

PEERS is the folder with cycles_turntable.py and noise_compare.py. Without CHARACTER the bundled human is made
with 20 k, 200 k and 2 M triangles. Both renderers show the same mesh, each in its own studio, and each picture's
noise is measured against one of the same renderer with many samples and another seed; times are compared at equal
noise (relMSE). Seconds are of processor time over all cores unless they are called wall, and what is compared runs
in turn, so that a busy machine slows both.

  rays      frame and raw device on the same recorded rays: bench rays
  noise     Cycles' seconds over ours for a picture as clean as its, frame alone
  still     the same for the whole process, from its start to the last file, at the noise of Cycles' 64 samples
  turntable seconds a frame over a turn, at the noise of Cycles' 16 samples
  animated  seconds a frame, of a sequence whose pose changes over those of a turntable; and Cycles' over ours
  memory    peak resident bytes that each further triangle takes, from the smallest mesh to the largest"""

import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
BACKBEND = pathlib.Path(os.environ.get("BACKBEND", SOURCE / "build/release/cli/backbend"))
SAMPLES = (16, 64, 256)
PARTS = ("rays", "noise", "still", "turntable", "animated", "memory")
FRAMES = 12


class Run:
    """One process to its end: what it printed, and what it took."""

    def __init__(self, *command):
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            start = time.monotonic()
            process = subprocess.Popen([str(word) for word in command], stdout=out, stderr=err)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            self.wall = time.monotonic() - start
            out.seek(0), err.seek(0)
            self.told = out.read()
            if process.returncode != 0:
                sys.exit(f"{' '.join(map(str, command))}: exit code {process.returncode}\n{err.read()}")
        self.seconds = usage.ru_utime + usage.ru_stime
        self.peak = usage.ru_maxrss * 1024


def turn_z_up(source, target):
    """The peer's scene has z up and looks along +y; ours has y up and faces +z. As tall as it wants."""
    points = [[float(word) for word in line.split()[1:4]] for line in source.open() if line.startswith("v ")]
    low, high = min(p[1] for p in points), max(p[1] for p in points)
    scale = 1.8 / (high - low)
    with target.open("w") as out:
        for line in source.open():
            kind, *words = line.split() or [""]
            if kind in ("v", "vn"):
                x, y, z = (float(word) for word in words[:3])
                if kind == "v":
                    x, y, z = x * scale, (y - low) * scale, z * scale
                line = f"{kind} {x:.7g} {-z:.7g} {y:.7g}\n"
            out.write(line)


class Subject:
    """One character, as ours and as the peer's mesh."""

    def __init__(self, job, character):
        self.job, self.character = job, character
        self.mesh = job.folder / f"{character.stem}.obj"
        y_up = job.folder / "y_up.obj"
        self.ours("mesh", 1, "--res", "16x16", "--export-obj", y_up)
        turn_z_up(y_up, self.mesh)
        y_up.unlink()
        with self.mesh.open() as lines:
            self.triangles = sum(line.startswith("f ") for line in lines)

    def cycles(self, samples, seed=0, mode="still", frames=1):
        """The process, and what it says of itself."""
        out = self.job.folder / f"cycles_{samples}_{seed}"
        run = Run("blender", "-b", "--factory-startup", "--python", self.job.peers / "cycles_turntable.py", "--",
                  "--mesh", self.mesh, "--res", self.job.size, "--spp", samples, "--seed", seed, "--mode", mode,
                  "--frames", frames, "--out", out)
        (result,) = [json.loads(line[7:]) for line in run.told.splitlines() if line.startswith("RESULT ")]
        run.picture = out / "f0000.exr"
        return run, result

    def ours(self, name, samples, *words, command="render", seed=0):
        run = Run(BACKBEND, "-q", command, self.character, "--res", self.job.size, "--spp", samples, "--seed", seed,
                  "--name", name, "-o", self.job.folder / "ours", *words)
        run.picture = self.job.folder / f"ours/{name}.exr"
        return run

    def rays(self, samples):
        return json.loads(Run(BACKBEND, "-q", "--json", "bench", "rays", self.character, "--res", self.job.size,
                              "--spp", samples, "--repeat", 3).told)


def noise(job, reference, pictures):
    """relMSE of each picture, by the peers' own script."""
    words = [f"{path}:{samples}:1" for samples, path in pictures.items()]
    told = Run(sys.executable, job.peers / "noise_compare.py", "--ref-spp", job.reference, reference, *words).told
    return {int(n): float(e) for n, e in re.findall(r"spp +(\d+) .* relMSE (\S+)", told)}


def at_error(error, errors, values):
    """A value for a noise, along the straight line through the logarithms of the two nearest."""
    known = sorted((math.log(errors[n]), math.log(values[n])) for n in errors)
    (e0, v0), (e1, v1) = min(zip(known, known[1:]), key=lambda p: abs(p[0][0] + p[1][0] - 2 * math.log(error)))
    return math.exp(v0 + (math.log(error) - e0) / (e1 - e0) * (v1 - v0))


class Noise:
    """Both renderers' noise and seconds of the frame by samples."""

    def __init__(self, job, subject):
        theirs, own = {}, {}
        self.their_s, self.own_s = {}, {}
        _, first = subject.cycles(1)
        self.fixed_s = first["first"]["cpu"]
        for samples in SAMPLES:
            run, result = subject.cycles(samples)
            theirs[samples], self.their_s[samples] = run.picture, result["first"]["cpu"]
            own[samples] = subject.ours(f"ours_{samples}", samples).picture
            self.own_s[samples] = subject.rays(samples)["frame_s"]
        self.theirs = noise(job, subject.cycles(job.reference, 1)[0].picture, theirs)
        self.own = noise(job, subject.ours("ours_reference", job.reference, seed=1).picture, own)

    def our_samples(self, their_samples):
        """How many of our samples are as clean as so many of theirs."""
        return max(1, math.ceil(at_error(self.theirs[their_samples], self.own, {n: n for n in self.own})))


def measure(job, subject):
    print(f"\n{subject.character.stem}: {subject.triangles} triangles, {job.size}", flush=True)
    if "rays" in job.parts:
        told = subject.rays(16)
        print(f"  rays       {told['ratio']:.3f} of the raw device's rate on the same rays "
              f"({told['frame_s']:.3f} s a frame of 16 samples)", flush=True)
    equal = {16: 16, 64: 64}
    if "noise" in job.parts:
        known = Noise(job, subject)
        for samples in SAMPLES:
            error = known.theirs[samples]
            seconds = at_error(error, known.own, known.own_s)
            print(f"  noise      Cycles {samples:3d} samples {known.their_s[samples]:7.3f} s relMSE {error:.2e}; ours "
                  f"{known.own_s[samples]:6.3f} s {known.own[samples]:.2e}; Cycles / ours at equal noise "
                  f"{known.their_s[samples] / seconds:6.2f}, without its fixed cost "
                  f"{(known.their_s[samples] - known.fixed_s) / seconds:.2f}", flush=True)
        equal = {n: known.our_samples(n) for n in equal}
    if "still" in job.parts:
        theirs, own = subject.cycles(64)[0], subject.ours("still", equal[64])
        print(f"  still      Cycles 64 samples {theirs.seconds:.2f} s ({theirs.wall:.2f} s wall), ours {equal[64]} samples "
              f"{own.seconds:.2f} s ({own.wall:.2f} s wall): {theirs.seconds / own.seconds:.1f} "
              f"({theirs.wall / own.wall:.1f} wall)", flush=True)
    if "turntable" in job.parts:
        theirs = subject.cycles(16, mode="turntable", frames=FRAMES)[1]["cpu_loop_s"] / FRAMES
        own = subject.ours("turn", equal[16], "--views", FRAMES, command="turntable").seconds / FRAMES
        print(f"  turntable  Cycles 16 samples {theirs:.3f} s a frame, ours {equal[16]} samples {own:.3f} s, its start and "
              f"video included: {theirs / own:.1f}", flush=True)
    if "animated" in job.parts:
        for samples in (8, 1):
            # A turntable of as many views is the same work with a pose that stays.
            ratios, seconds = [], []
            for _ in range(3):
                moved = subject.ours("moved", samples, "--sweep", "extension")
                frames = moved.told.count(".exr\n")
                still = subject.ours("still", samples, "--views", frames, command="turntable")
                ratios.append(moved.seconds / still.seconds)
                seconds.append(moved.seconds / frames)
            theirs = subject.cycles(samples, mode="animated", frames=FRAMES)[1]["cpu_loop_s"] / FRAMES
            print(f"  animated   {samples} samples: {sorted(ratios)[1]:.3f} of a turntable's time a frame "
                  f"({sorted(seconds)[1]:.3f} s); Cycles {theirs:.3f} s a frame: {theirs / sorted(seconds)[1]:.1f}",
                  flush=True)
    if "memory" in job.parts:
        return subject.triangles, subject.ours("memory", 1).peak, subject.cycles(1)[0].peak
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("peers", type=pathlib.Path)
    parser.add_argument("character", type=pathlib.Path, nargs="?")
    parser.add_argument("--res", type=int, default=512, help="pixels along either side [512]")
    parser.add_argument("--reference", type=int, default=4096, help="samples of the clean pictures [4096]")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, help="what to measure [all]")
    parser.add_argument("--triangles", nargs="+", type=int, default=(20_000, 200_000, 2_000_000),
                        help="sizes of the bundled human [20000 200000 2000000]")
    job = parser.parse_args()
    job.size = f"{job.res}x{job.res}"
    with tempfile.TemporaryDirectory() as folder:
        job.folder = pathlib.Path(folder)
        characters = [job.character] if job.character else []
        for triangles in () if job.character else job.triangles:
            characters.append(job.folder / f"human_{triangles}.glb")
            Run(BACKBEND, "-q", "body", "--vertices", triangles // 2, "-o", characters[-1])
        print("seconds of processor time, one run of each in turn")
        used = [measure(job, Subject(job, character)) for character in characters]
        if "memory" in job.parts:
            for triangles, own, theirs in used:
                print(f"  memory     {triangles} triangles: ours {own / 1e6:.0f} MB, Blender {theirs / 1e6:.0f} MB")
        if "memory" in job.parts and len(used) > 1:
            (n0, own0, their0), (n1, own1, their1) = min(used), max(used)
            own, theirs = (own1 - own0) / (n1 - n0), (their1 - their0) / (n1 - n0)
            print(f"  memory     a triangle: ours {own:.0f} bytes, Blender {theirs:.0f}: {own / theirs:.2f}")


main()
