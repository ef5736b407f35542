#!/usr/bin/env python3
"""Seconds from a save to the verdict under `check --watch --quick`, and the processor seconds of each save.

    tests/bench/save_to_verdict.py CHARACTER.glb [--saves 20] [--program FILE]

Saves the character under turns of names that its JSON holds, so that every byte that is measured stays and nothing is
known by its content, and waits for the verdict's lines. Prints median and 95th percentile; on a machine that does other
work look at the processor seconds.
"""

import argparse
import json
import os
import pathlib
import signal
import statistics
import struct
import subprocess
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def renamed(glb, generator):
    """The same character with another `generator` in its JSON."""
    size, = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20:20 + size])
    document.setdefault("asset", {})["generator"] = generator
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + size:]
    return struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest


def processor_s(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    options = argparse.ArgumentParser()
    options.add_argument("character", type=pathlib.Path)
    options.add_argument("--saves", type=int, default=20)
    options.add_argument("--program", default=SOURCE / "build/release/cli/backbend", type=pathlib.Path)
    options = options.parse_args()
    glb = options.character.read_bytes()
    walls, processors = [], []
    with tempfile.TemporaryDirectory() as folder:
        hero = pathlib.Path(folder, "hero.glb")
        hero.write_bytes(glb)
        with subprocess.Popen([options.program.resolve(), "check", "hero.glb", "--watch", "--quick", "-o", "out"], cwd=folder,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as run:
            def verdict():
                for line in run.stdout:
                    if "Ctrl-C ends" in line:
                        return
                raise SystemExit("the program ended")

            verdict()
            for save in range(options.saves):
                time.sleep(1.0)  # its report is written meanwhile
                content = renamed(glb, f"save {save}")
                before = processor_s(run.pid)
                hero.write_bytes(content)
                saved = time.monotonic()
                verdict()
                walls.append(time.monotonic() - saved)
                processors.append(processor_s(run.pid) - before)
            run.send_signal(signal.SIGINT)
    for name, values in (("wall", walls), ("processor", processors)):
        print(f"{name}: median {statistics.median(values):.2f} s, p95 {statistics.quantiles(values, n=20)[-1]:.2f} s, "
              f"least {min(values):.2f} s, of {len(values)} saves")


if __name__ == "__main__":
    main()
