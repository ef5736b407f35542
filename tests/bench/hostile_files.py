"""Memory and processor time of refusing hostile files: BACKBEND=... python3 tests/bench/hostile_files.py

Prints one line a file; ends with 1 where one takes 512 MB, a second of processor time, or another
exit code than it should. Time is this machine's, so this is no test of the suite: beside the time
that the program takes for nothing at all it says what the file itself costs.
"""

import os
import pathlib
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/cli"))
sys.dont_write_bytecode = True
import hostile  # noqa: E402

BACKBEND = os.environ.get("BACKBEND", str(SOURCE / "build/release/cli/backbend"))
MOST_BYTES, MOST_SECONDS = 512 << 20, 1.0


def run(file, content):
    with tempfile.TemporaryDirectory() as folder:
        path = hostile.write(folder, file, content)
        out = ["-o", os.path.join(folder, "out.glb")] if file.endswith(".bvh") else []
        words = [BACKBEND, "body" if out else "inspect", path, *out]
        return hostile.measured(words, {"PATH": os.environ["PATH"], "HOME": folder}, folder)


def main():
    nothing = min(run("hero.glb", b"")[4] for _ in range(5))
    print(f"refusing an empty file takes {nothing:.2f} s")
    files = [(name, *entry, 3) for name, entry in hostile.REFUSED.items()]
    files += [(name, "hero.glb", entry[0], 0) for name, entry in hostile.ACCEPTED.items()]
    bad = 0
    for name, file, content, expected in files:
        code, _, _, memory, seconds = run(file, content)
        wrong = code != expected or memory >= MOST_BYTES or seconds >= MOST_SECONDS
        bad += wrong
        print(f"{'X' if wrong else ' '} exit {code}  {memory >> 20:4d} MB  {seconds:5.2f} s  "
              f"(file {max(0.0, seconds - nothing):5.2f} s)  {name}")
    print(f"{len(files)} files, {bad} beyond 512 MB, {MOST_SECONDS:.0f} s or with another exit code")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
