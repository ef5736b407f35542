"""What the command-line tests share: the program under test, a folder of their own, and the
manners that every refusal must have."""

import functools
import hashlib
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
BACKBEND = pathlib.Path(os.environ.get("BACKBEND", SOURCE / "build/release/cli/backbend"))

# Real characters live beside the project, not in it; tests that want them skip where they are absent.
CHARACTERS = pathlib.Path(os.environ.get("BACKBEND_CHARACTERS", SOURCE.parent / "shared/characters"))

# How many times as long commands take under a sanitizer, at most; and after how long one hangs.
SLOWER = float(os.environ.get("BACKBEND_TEST_SLOWER", 1))
PATIENCE_S = 300 * SLOWER

USAGE = 2
BAD_INPUT = 3
INTERNAL = 70
CANNOT_WRITE = 73
RETRY = 75


def character(name):
    """The path of one of the real characters, or a skipped test."""
    path = CHARACTERS / name
    if not path.is_file():
        raise unittest.SkipTest(f"{path} is not on this machine")
    return path


def contents(folder):
    """Every path under `folder` with what it holds: equal before and after means nothing was written."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink():
            found[name] = "link to " + os.readlink(path)
        elif path.is_file():
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        else:
            found[name] = "folder"
    return found


def bare_environment(home, **more):
    """Nothing of this machine's environment but the PATH, and what steers sanitizers from outside."""
    steering = {name: value for name, value in os.environ.items() if name.endswith("SAN_OPTIONS")}
    return {"PATH": os.environ["PATH"], "HOME": str(home), **steering, **more}


def blender_environment(home, **more):
    """A bare environment in which Blender has its system's Python: it takes the first one on the PATH for its own."""
    return bare_environment(home, PATH="/usr/bin:/bin", **more)


def run_backbend(arguments, folder, environment=None, cwd=None, timeout_s=PATIENCE_S):
    """Runs the program in a bare environment. `folder` is its working folder and its home."""
    return subprocess.run([str(BACKBEND), *map(str, arguments)], cwd=cwd or folder,
                          env=bare_environment(folder, **(environment or {})),
                          stdin=subprocess.DEVNULL, capture_output=True, timeout=timeout_s,
                          encoding="utf-8", errors="surrogateescape")


@functools.lru_cache(maxsize=None)
def human(vertices=None):
    """The bundled human as a file, or a coarser one. Making it takes longer than most of what tests ask of it, so it is
    made once for each build of the program, and kept in the build's folder where there is one."""
    program = BACKBEND.stat()
    recipe = (SOURCE / "scenes/characters/human.toml").read_bytes()
    key = hashlib.sha256(recipe + f" {program.st_size} {program.st_mtime_ns}".encode()).hexdigest()[:16]
    bodies = pathlib.Path(os.environ.get("BACKBEND_BUILD") or tempfile.gettempdir(), "backbend_test_bodies")
    path = bodies / key / (f"human_{vertices}.glb" if vertices else "human.glb")
    if not path.is_file():
        # A build's folder keeps none of the builds before; another test may be making this one.
        for other in bodies.glob("*") if "BACKBEND_BUILD" in os.environ else ():
            if other.name != key:
                shutil.rmtree(other, ignore_errors=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        size = ["--vertices", vertices] if vertices else []
        made = run_backbend(["body", SOURCE / "scenes/characters/human.toml", *size, "-o", path], path.parent)
        assert made.returncode == 0, made.stderr
    return path


# What CommandTest.made_once() keeps: the content of files by their names, by what they were made with.
MADE = {}


class CommandTest(unittest.TestCase):
    """Runs the program in a fresh folder that is its home, too, so that whatever it writes is seen."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="backbend cli ")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def backbend(self, *arguments, **options):
        return run_backbend(arguments, self.folder, **options)

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def made_once(self, key, names, make):
        """Files that are slow to make, in this test's folder: `make()` writes those `names` there for the first test that
        asks with `key`, which says all that they depend on; the others get copies. Returns the first one's path."""
        if key not in MADE:
            make()
            MADE[key] = [(self.folder / name).read_bytes() for name in names]
        for name, content in zip(names, MADE[key]):
            self.write(name, content)
        return self.folder / names[0]

    def assert_runs(self, *arguments, code=0, **options):
        """The command ends with `code`; returns what it said."""
        result = self.backbend(*arguments, **options)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}\n{result.stderr}")
        return result

    def assert_refused(self, *arguments, code=BAD_INPUT, names=(), **options):
        """The command ends with `code`, one line of printable text on stderr that holds every word
        of `names`, nothing on stdout, and the folder as it was."""
        before = contents(self.folder)
        result = self.backbend(*arguments, **options)
        told = f"{arguments}\nstdout: {result.stdout}\nstderr: {result.stderr}"
        self.assertEqual(result.returncode, code, told)
        self.assertEqual(result.stdout, "", told)
        self.assertTrue(result.stderr.endswith("\n"), told)
        # Whatever bytes the input held, the line is plain text.
        self.assertTrue(result.stderr[:-1].isprintable(), ascii(told))
        for name in names:
            self.assertIn(str(name), result.stderr, told)
        self.assertEqual(contents(self.folder), before, told)
        return result
