#!/usr/bin/env python3
"""How the wall of whole jobs falls with threads, and the share of each that one thread does alone.

    tests/bench/threads.py build/release/cli/backbend [--jobs check,turntable] [--rounds 3]

Each job runs with 1 to as many threads as there are processors, in turns, so that what else the
machine does meets all alike; `--threads 1,2,4` names others. Printed for each: medians of the wall
and of processor seconds (with those of encoders that it starts), the wall over one thread's, and
the serial share s of the whole, fitted by least squares to wall(n) = wall(1) (s + (1 - s) / n). On
a machine with other work the wall of several threads is too long, and so is s. That is what the
next columns are for, which waiting for a processor does not change: `busy` is the mean number of
threads that could run, encoders' included; `alone` is the time in which only one could, over the
time of all of them, so about the serial share. What the job writes is compared, byte for byte, with
what it wrote with one thread.
"""

import argparse
import filecmp
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

JOBS = {
    "night": ["nightly", "--fresh"],
    "night --quick": ["nightly", "--quick", "--fresh"],
    "check": ["check", "{character}"],
    "turntable": ["turntable", "{character}"],
    "compare": ["compare", "even", "isner", "--character", "{character}"],
    "calibrate": ["calibrate", "--poses", "200", "--faults", "40"],
}
EXPECTED_EXITS = (0, 1, 2, 3, 5)  # a run with findings still ran to its end


def family(pid):
    """A process and all that it started, as far as they still run."""
    found = [pid]
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{task}/children") as children:
                for child in children.read().split():
                    found += family(int(child))
    except OSError:
        pass
    return found


def runnable(pids):
    count = 0
    for pid in pids:
        try:
            for task in os.listdir(f"/proc/{pid}/task"):
                with open(f"/proc/{pid}/task/{task}/stat") as stat:
                    count += stat.read().rsplit(")", 1)[1].split()[0] in "RD"
        except OSError:
            pass
    return count


def run(command, log):
    """Wall, processor seconds, and of threads that could run: the mean, and the share alone."""
    before = os.times()
    start = time.monotonic()
    samples = []
    with open(log, "w") as out:
        child = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT)
        while child.poll() is None:
            samples.append(max(1, runnable(family(child.pid))))
            time.sleep(0.02)
    wall = time.monotonic() - start
    after = os.times()
    if child.returncode not in EXPECTED_EXITS:
        with open(log) as out:
            sys.exit(f"{' '.join(command)}: exit {child.returncode}\n{out.read()[-2000:]}")
    processor = (after.children_user - before.children_user
                 + after.children_system - before.children_system)
    samples = samples or [1]
    return wall, processor, statistics.mean(samples), samples.count(1) / sum(samples)


def differing(a, b):
    """Files of two folders that are not alike, logs and dates apart."""
    found = []
    for folder, _, names in os.walk(a):
        for name in names:
            one = os.path.join(folder, name)
            other = os.path.join(b, os.path.relpath(one, a))
            if not os.path.isfile(other) or not filecmp.cmp(one, other, shallow=False):
                found.append(os.path.relpath(one, a))
    return found


def serial_share(walls):
    """The s of wall(n) / wall(1) = s + (1 - s) / n that fits best; none with one thread alone."""
    top = bottom = 0.0
    for threads, wall in walls.items():
        parallel = 1.0 - 1.0 / threads
        top += parallel * (wall / walls[1] - 1.0 / threads)
        bottom += parallel * parallel
    return top / bottom if bottom > 0.0 else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--character", help="for check, turntable and compare "
                        "[mh_female_cmu_13k.glb in the folder BACKBEND_CHARACTERS]")
    parser.add_argument("--jobs", default=",".join(JOBS), help="separated by commas [all]")
    parser.add_argument("--threads", help="numbers separated by commas, 1 among them")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    character = options.character or os.path.join(os.environ.get("BACKBEND_CHARACTERS", "."),
                                                  "mh_female_cmu_13k.glb")
    cores = len(os.sched_getaffinity(0))
    threads = [int(n) for n in options.threads.split(",")] if options.threads \
        else list(range(1, cores + 1))
    if 1 not in threads:
        parser.error("--threads: one thread must be among them")
    unknown = set(options.jobs.split(",")) - set(JOBS)
    if unknown:
        parser.error(f"--jobs: unknown {', '.join(sorted(unknown))}; known: {', '.join(JOBS)}")
    program = os.path.abspath(options.program)
    print("| job | threads | wall, s | over one thread's | processor, s | busy | alone | "
          "serial share |\n|---|---|---|---|---|---|---|---|")
    failed = False
    with tempfile.TemporaryDirectory() as scratch:
        for job in options.jobs.split(","):
            words = [word.format(character=character) for word in JOBS[job]]
            seen = {n: [] for n in threads}
            for turn in range(options.rounds):
                for n in threads:
                    # The same folder for all: pages name it.
                    folder = os.path.join(scratch, "run")
                    shutil.rmtree(folder, ignore_errors=True)
                    seen[n].append(run([program, *words, "--threads", str(n), "-o", folder],
                                       os.path.join(scratch, "log")))
                    if turn > 0:
                        continue
                    kept = os.path.join(scratch, "one")
                    if n == 1:
                        shutil.rmtree(kept, ignore_errors=True)
                        shutil.copytree(folder, kept)
                    elif os.path.isdir(kept):
                        for name in differing(kept, folder):
                            print(f"{job}, {n} threads: {name} differs from one thread's",
                                  file=sys.stderr)
                            failed = True
            middle = {n: [statistics.median(each) for each in zip(*seen[n])] for n in threads}
            walls = {n: middle[n][0] for n in threads}
            for n in threads:
                share = f"{100.0 * serial_share(walls):.1f} %" if n == max(threads) > 1 else ""
                alone = f"{100.0 * middle[n][3]:.1f} %" if n > 1 else ""
                print(f"| {job} | {n} | {walls[n]:.2f} | {walls[n] / walls[1]:.2f} | "
                      f"{middle[n][1]:.2f} | {middle[n][2]:.2f} | {alone} | {share} |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
