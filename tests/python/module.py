"""What the tests of the Python module share: scripts that run in an interpreter of their own."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))

from harness import BACKBEND, PATIENCE_S, SOURCE, bare_environment, character, human, run_backbend  # noqa: E402, F401

MODULE = pathlib.Path(os.environ.get("PYTHONPATH", SOURCE / "build/release/python"))
PYTHON = sys.executable  # tests.cmake runs these files by the interpreter that the module is for


def has(name):
    return subprocess.run([PYTHON, "-c", f"import {name}"], capture_output=True).returncode == 0


class ModuleTest(unittest.TestCase):
    """Runs scripts in a folder of their own, with the bundled human as HUMAN, of `vertices` where they are given."""

    vertices = None

    def setUp(self):
        if not MODULE.is_dir():
            self.skipTest(f"the module is not built: {MODULE}")
        if not has("numpy"):
            self.skipTest("NumPy is not installed for this interpreter")
        holder = tempfile.TemporaryDirectory(prefix="backbend python ")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def environment(self):
        more = {"PYTHONPATH": str(MODULE), "PYTHONDONTWRITEBYTECODE": "1", "HUMAN": str(human(self.vertices))}
        if preload := os.environ.get("BACKBEND_PRELOAD"):
            # Python and NumPy keep memory to their end; that is not a leak of ours.
            more |= {"LD_PRELOAD": preload, "ASAN_OPTIONS": "detect_leaks=0:alloc_dealloc_mismatch=0"}
        return bare_environment(self.folder) | more

    def start(self, script, *arguments):
        head = "import os, sys\nimport numpy as np\nimport backbend\nHUMAN = os.environ['HUMAN']\n"
        return subprocess.Popen([PYTHON, "-c", head + script, *map(str, arguments)], cwd=self.folder,
                                env=self.environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def run_script(self, script, *arguments, code=0):
        """What a script printed; it must end with `code`."""
        process = self.start(script, *arguments)
        try:
            out, err = process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            self.fail(f"the script hangs:\n{script}\n{process.communicate()}")
        self.assertEqual(process.returncode, code, f"{script}\nstdout: {out}\nstderr: {err}")
        return out
