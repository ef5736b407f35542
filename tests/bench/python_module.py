#!/usr/bin/env python3
"""How much of the libraries' speed reaches Python: prints ratios, of one run on one machine.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/bench/python_module.py build/release CHARACTER

Skinning one pose after the other and solving 10^4 poses, against build/release/tests/bench/python_reference, which does
the same by the same calls in C++. The two take turns, so that whatever else the machine does slows both: a ratio is the
median of those of all rounds. And the time of the import, against that of an interpreter alone, in turns too.
"""

import pathlib
import statistics
import subprocess
import sys
import time

ROUNDS = 41


def seconds(call, repeat):
    begin = time.perf_counter()
    for _ in range(repeat):
        call()
    return (time.perf_counter() - begin) / repeat


def start_time(code):
    return seconds(lambda: subprocess.run([sys.executable, "-c", code], check=True), 1)


def paired(reference, what, call, repeat):
    """The median share of C++'s speed that Python has, and Python's median seconds."""
    shares, times = [], []
    for turn in range(ROUNDS + 1):
        reference.stdin.write(f"{what} {repeat}\n")
        reference.stdin.flush()
        told = float(reference.stdout.readline())
        mine = seconds(call, repeat)
        if turn > 0:  # the first warms both up
            shares.append(told / mine)
            times.append(mine)
    return statistics.median(shares), statistics.median(times)


def main():
    build, character = pathlib.Path(sys.argv[1]), sys.argv[2]
    more = [start_time("import backbend") - start_time("pass") for _ in range(ROUNDS)]
    print(f"import backbend: {statistics.median(more):.3f} s (reach 0.15)")

    import backbend
    import numpy as np

    body = backbend.load(character)
    rig = backbend.Rig("even", body)
    matrices = body.pose(rig, rig.controls(extension=60)).matrices
    out = (np.empty((1, len(body.positions), 3), np.float32), np.empty((1, len(body.positions), 3), np.float32))
    controls = np.random.default_rng(1).uniform(-60.0, 60.0, (10_000, len(rig.channels)))
    for column, name in enumerate(rig.channels):
        if rig.units[name] != "degrees":
            controls[:, column] = np.radians(controls[:, column])  # the reference has one range for all of them
    with subprocess.Popen([build / "tests/bench/python_reference", character], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          text=True) as reference:
        skin, skin_s = paired(reference, "skin", lambda: body.skin(matrices), 500)
        into, into_s = paired(reference, "skin", lambda: body.skin(matrices, out=out), 500)
        solve, solve_s = paired(reference, "solve", lambda: rig.solve(controls), 1)
        reference.stdin.close()
    print(f"skinning {len(body.positions)} vertices: {skin:.3f} of C++ (reach 0.95; {skin_s * 1e6:.0f} us), "
          f"into arrays of the caller's {into:.3f} ({into_s * 1e6:.0f} us)")
    print(f"solving 10000 poses of even: {solve:.3f} of C++ (reach 0.90; {solve_s * 1e3:.1f} ms)")


if __name__ == "__main__":
    main()
