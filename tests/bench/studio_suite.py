#!/usr/bin/env python3
"""A night at a studio's size: time, memory, page, and history, for many characters under three rigs.

    tests/bench/studio_suite.py [--characters 50] [--sizes 5000,17000,58000,200000] [--pictures] [--nights 1000]
                                [--program FILE] [--keep FOLDER]

Makes bodies of the bundled descriptions in each size, and of these as many characters as asked for, no two with the same
bytes. Prints, for a first night, a second without a change and a third with one character changed: seconds by the clock,
processor seconds, peak memory of the program and of the largest character by itself; then the page's size and the
seconds that Chromium takes to load it beyond an empty one; then what `history` takes over a thousand nights.
"""

import argparse
import datetime
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

from save_to_verdict import SOURCE, renamed

DESCRIPTIONS = ("human", "dinosaur", "snake")
EXPECTED_EXITS = (0, 1, 2, 5)  # a night with findings still ran to its end
SUITE = """[suite]
name = "studio"
characters = [{characters}]
mappings = ["chest"]
envelope = "human"

[[rig]]
name = "even"
role = "proposed"
solver = {{ system = "even" }}

[[rig]]
name = "isner"
role = "reference"
solver = {{ system = "isner" }}

[[rig]]
name = "matrix_blend"
role = "reference"
solver = {{ system = "matrix_blend" }}

[[sweep]]
channel = "extension"
to = 120
step = {step}

[[sweep]]
channel = "side"
from = -45
to = 45
step = {step}

[pictures]
width = 320
height = 240
samples = 16
turntable_views = 0
sheet_columns = 6
"""


def measured(command, folder):
    """Seconds by the clock, processor seconds and peak memory in MB of a run that must end well."""
    start = time.monotonic()
    with open(folder / "log.txt", "w") as log:
        child = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in EXPECTED_EXITS:
        raise SystemExit(f"{' '.join(map(str, command))}: exit {child.returncode}\n{(folder / 'log.txt').read_text()[-800:]}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def suite_of(characters, step=5):
    return SUITE.format(characters=", ".join(f'"{each}"' for each in characters), step=step)


def body_of(program, folder, name, size):
    """The file of a bundled description's body with so many vertices."""
    body = folder / f"{name}_{size}.glb"
    subprocess.run([program, "body", SOURCE / f"scenes/characters/{name}.toml", "--vertices", str(size), "-o", body],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return body


def make_characters(program, folder, count, sizes):
    """Names of the files, small and large in turns, and the largest one's."""
    bodies = []
    for size in sizes:
        for name in DESCRIPTIONS:
            bodies.append(body_of(program, folder, name, size).read_bytes())
    names = []
    for k in range(count):
        names.append(f"char_{k:03}.glb")
        (folder / names[-1]).write_bytes(renamed(bodies[k % len(bodies)], f"studio {k}"))
    return names, max(names, key=lambda name: (folder / name).stat().st_size)


def loading(chromium, page):
    start = time.monotonic()
    subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", page], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.monotonic() - start


def history_of(program, folder, nights):
    """The night once more under each of so many dates; seconds of `history` over all of them, first and again."""
    night = json.loads((folder / "runs/history.jsonl").read_text().splitlines()[-1])
    first = datetime.date(2020, 1, 1)
    with open(folder / "many.jsonl", "w") as out:
        for k in range(nights):
            night["date"] = (first + datetime.timedelta(days=k)).isoformat()
            night["report"] = f"{k:032x}"
            out.write(json.dumps(night) + "\n")
    command = [program, "history", "--history", "many.jsonl", "--nights", str(nights), "--character", "char_000"]
    return [measured(command, folder)[0] for _ in range(2)]


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--characters", type=int, default=50)
    options.add_argument("--sizes", default=[5000, 17000, 58000, 200000],
                         type=lambda text: [int(each) for each in text.split(",")])
    options.add_argument("--pictures", action="store_true", help="with pictures; without, nights are --quick")
    options.add_argument("--nights", type=int, default=1000)
    options.add_argument("--program", default=SOURCE / "build/release/cli/backbend", type=pathlib.Path)
    options.add_argument("--keep", type=pathlib.Path, help="a folder for all files, which stay")
    options = options.parse_args()
    program = options.program.resolve()
    folder = (options.keep or pathlib.Path(tempfile.mkdtemp())).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    names, largest = make_characters(program, folder, options.characters, options.sizes)
    quick = [] if options.pictures else ["--quick"]

    def night(label, characters):
        (folder / "suite.toml").write_text(suite_of(characters))
        wall, processor, memory = measured([program, "nightly", "suite.toml", *quick], folder)
        print(f"{label:40} {wall:8.1f} s  {processor:8.1f} s of processor  {memory:7.0f} MB", flush=True)

    night(f"the largest character, {largest}", [largest])
    shutil.rmtree(folder / "runs")
    night(f"{len(names)} characters x 3 rigs", names)
    night("again, nothing changed", names)
    changed = folder / names[0]
    changed.write_bytes(renamed(changed.read_bytes(), "studio, saved again"))
    night("again, one character changed", names)

    page = folder / "runs/latest/index.html"
    print(f"page: {page.stat().st_size / 1e6:.1f} MB")
    chromium = shutil.which("chromium")
    if chromium:
        empty = folder / "empty.html"
        empty.write_text("<!doctype html><title>empty</title>")
        beyond = statistics.median(loading(chromium, page.as_uri()) - loading(chromium, empty.as_uri()) for _ in range(3))
        print(f"page: loads in {beyond:.2f} s beyond an empty one (median of three)")
    first, again = history_of(program, folder, options.nights)
    print(f"history of {options.nights} nights: {first:.2f} s, and again {again:.2f} s")
    if not options.keep:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
