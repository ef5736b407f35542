#!/usr/bin/env python3
"""How much of the libraries' speed reaches Python: prints ratios, of one run on one machine.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/bench/python_module.py build/release CHARACTER

Skinning one pose after the other and solving 10^4 poses, against build/release/tests/bench/python_reference, which does
the same by the same calls in C++; and the time of the import, against that of an interpreter alone.
"""

import pathlib
import statistics
import subprocess
import sys
import time

ROUNDS = 7


def best(call, repeat):
    call()
    times = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for _ in range(repeat):
            call()
        times.append((time.perf_counter() - begin) / repeat)
    return min(times)


def start_time(code):
    times = []
    for _ in range(15):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def main():
    build, character = pathlib.Path(sys.argv[1]), sys.argv[2]
    bare = start_time("pass")
    print(f"import backbend: {start_time('import backbend') - bare:.3f} s (reach 0.15)")

    import backbend
    import numpy as np

    body = backbend.load(character)
    rig = backbend.Rig("even", body)
    matrices = body.pose(rig, rig.controls(extension=60)).matrices
    out = (np.empty((1, len(body.positions), 3), np.float32), np.empty((1, len(body.positions), 3), np.float32))
    controls = np.random.default_rng(1).uniform(-60.0, 60.0, (10_000, len(rig.channels)))
    skin = best(lambda: body.skin(matrices), 200)
    into = best(lambda: body.skin(matrices, out=out), 200)
    solve = best(lambda: rig.solve(controls), 1)
    told = subprocess.run([build / "tests/bench/python_reference", character], check=True, capture_output=True, text=True)
    reference = dict(line.split() for line in told.stdout.splitlines())
    print(f"skinning {len(body.positions)} vertices: {float(reference['skin']) / skin:.2f} of C++ (reach 0.95; "
          f"{skin * 1e6:.0f} us), into arrays of the caller's {float(reference['skin']) / into:.2f}")
    print(f"solving 10000 poses of even: {float(reference['solve']) / solve:.2f} of C++ (reach 0.90; {solve * 1e3:.1f} ms)")


if __name__ == "__main__":
    main()
