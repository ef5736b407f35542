#!/usr/bin/env python3
"""render_against_cycles.py PEERS CHARACTER: how long Cycles takes for a picture as clean as ours.

PEERS is the folder with cycles_turntable.py and noise_compare.py. Both renderers show the same mesh,
each in its own studio, and each picture's noise is measured against a picture of the same renderer
with many samples and another seed; times are then compared at equal noise (relMSE).

Seconds are of processor time and of the frame alone. Two ratios are printed: one counts all that
Cycles does for a frame, the other leaves out what it does for a frame of one sample."""

import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
BACKBEND = pathlib.Path(os.environ.get("BACKBEND", SOURCE / "build/release/cli/backbend"))
SAMPLES = (4, 16, 64)


def told_by(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def turn_z_up(source, target):
    """The peer's scene has z up and looks along +y; ours has y up and faces +z. As tall as it wants."""
    lines = source.read_text().splitlines()
    points = [[float(word) for word in line.split()[1:4]] for line in lines if line.startswith("v ")]
    low, high = min(p[1] for p in points), max(p[1] for p in points)
    scale = 1.8 / (high - low)
    with target.open("w") as out:
        for line in lines:
            kind, *words = line.split() or [""]
            if kind in ("v", "vn"):
                x, y, z = (float(word) for word in words[:3])
                if kind == "v":
                    x, y, z = x * scale, (y - low) * scale, z * scale
                line = f"{kind} {x:.7g} {-z:.7g} {y:.7g}"
            out.write(line + "\n")


def cycles(job, mesh, samples, seed):
    folder = job.folder / f"cycles_{samples}_{seed}"
    told = told_by("blender", "-b", "--factory-startup", "--python", job.peers / "cycles_turntable.py", "--",
                   "--mesh", mesh, "--res", f"{job.res}x{job.res}", "--spp", samples, "--seed", seed, "--out", folder)
    (result,) = [json.loads(line[7:]) for line in told.splitlines() if line.startswith("RESULT ")]
    return folder / "f0000.exr", result["first"]["cpu"], result["tris"]


def ours(job, samples, seed):
    name = f"ours_{samples}_{seed}"
    size = f"{job.res}x{job.res}"
    told_by(BACKBEND, "-q", "render", job.character, "--res", size, "--spp", samples, "--seed", seed, "--name", name,
            "-o", job.folder)
    seconds = 0.0
    if samples in SAMPLES:
        told = told_by(BACKBEND, "-q", "--json", "bench", "rays", job.character, "--res", size, "--spp", samples,
                       "--repeat", 3)
        seconds = json.loads(told)["frame_s"]
    return job.folder / f"{name}.exr", seconds


def noise(job, reference, pictures):
    """relMSE of each picture, by the peers' own script, which also prints the bias."""
    words = [f"{path}:{samples}:{max(seconds, 1e-9)}" for samples, (path, seconds) in pictures.items()]
    told = told_by(sys.executable, job.peers / "noise_compare.py", "--ref-spp", job.reference, reference, *words)
    return {int(n): float(e) for n, e in re.findall(r"spp +(\d+) .* relMSE (\S+)", told)}


def seconds_at(error, errors, seconds):
    """Seconds for a noise, along the straight line through the logarithms of the two nearest."""
    known = sorted((math.log(errors[n]), math.log(seconds[n])) for n in errors)
    (e0, s0), (e1, s1) = min(zip(known, known[1:]), key=lambda p: abs(p[0][0] + p[1][0] - 2 * math.log(error)))
    return math.exp(s0 + (math.log(error) - e0) / (e1 - e0) * (s1 - s0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("peers", type=pathlib.Path)
    parser.add_argument("character", type=pathlib.Path)
    parser.add_argument("--res", type=int, default=512, help="pixels along either side [512]")
    parser.add_argument("--reference", type=int, default=4096, help="samples of the clean pictures [4096]")
    job = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        job.folder = pathlib.Path(folder)
        told_by(BACKBEND, "-q", "render", job.character, "--res", "16x16", "--spp", 1, "--name", "mesh", "-o", folder,
                "--export-obj", job.folder / "y_up.obj")
        mesh = job.folder / "z_up.obj"
        turn_z_up(job.folder / "y_up.obj", mesh)

        _, fixed, triangles = cycles(job, mesh, 1, 0)
        theirs, own = {}, {}
        for samples in SAMPLES:  # in turn, so that a busy machine slows both
            path, seconds, _ = cycles(job, mesh, samples, 0)
            theirs[samples] = (path, seconds)
            own[samples] = ours(job, samples, 0)
        their_noise = noise(job, cycles(job, mesh, job.reference, 1)[0], theirs)
        own_noise = noise(job, ours(job, job.reference, 1)[0], own)

        print(f"{job.character.name}: {triangles} triangles, {job.res}x{job.res}, seconds of processor time")
        print("samples  Cycles s  relMSE    ours s  relMSE    Cycles / ours at equal noise  without its fixed cost")
        for samples in SAMPLES:
            error = their_noise[samples]
            seconds = seconds_at(error, own_noise, {n: s for n, (_, s) in own.items()})
            print(f"{samples:7d}  {theirs[samples][1]:8.3f}  {error:.2e}  {own[samples][1]:6.3f}  "
                  f"{own_noise[samples]:.2e}  {theirs[samples][1] / seconds:28.2f}  "
                  f"{(theirs[samples][1] - fixed) / seconds:22.2f}")


main()
