"""cmake --install: the program runs from wherever it was put, without the launcher and the sources."""

import os
import pathlib
import subprocess

import harness
from harness import CommandTest

BUILD = os.environ.get("BACKBEND_BUILD")


class Installing(CommandTest):
    def setUp(self):
        super().setUp()
        if not BUILD:
            self.skipTest("BACKBEND_BUILD names no build folder")
        self.prefix = self.folder / "first place"
        done = subprocess.run(["cmake", "--install", BUILD, "--prefix", self.prefix], text=True,
                              capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def run_installed(self, program, *arguments):
        done = subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_the_installed_program_finds_its_scenes_by_itself_and_may_be_moved(self):
        moved = self.folder / "second place"
        self.prefix.rename(moved)
        link = self.folder / "link"
        link.symlink_to(moved / "bin/backbend")
        for name, program in (("moved", moved / "bin/backbend"), ("link", link)):
            # The bundled human comes from the scenes.
            self.run_installed(program, "body", "-o", f"{name}.glb")
            self.assertGreater((self.folder / f"{name}.glb").stat().st_size, 100_000)
            # Pictures come through a module that lies beside the program.
            self.run_installed(program, "render", f"{name}.glb", "--res", "32x32", "--spp", "1", "-o", f"{name} out")
            self.assertTrue(list((self.folder / f"{name} out").rglob("*.png")))

    def test_it_gives_the_same_bytes_as_the_one_that_was_built(self):
        self.run_installed(self.prefix / "bin/backbend", "body", "-o", "installed.glb")
        self.assert_runs("body", "-o", "built.glb")
        self.assertEqual((self.folder / "installed.glb").read_bytes(), (self.folder / "built.glb").read_bytes())

    def test_the_python_module_is_found_where_debian_looks_and_finds_the_programs_files(self):
        found = list(self.prefix.glob("lib/python3*/dist-packages/backbend/_core*.so"))
        if not found:
            self.skipTest("the Python module is not built")
        (library,) = found
        packages = library.parents[1]
        self.assertEqual({path.name for path in library.parent.iterdir()},
                         {library.name, "__init__.py", "__init__.pyi", "py.typed"})
        below = f"/usr/local/{packages.relative_to(self.prefix)}"  # the default prefix
        self.assertIn(below, self.run_installed("/usr/bin/python3", "-c", "import site; print(site.getsitepackages())"))
        # The bundled human, and what reads pictures, are the program's.
        done = subprocess.run(["/usr/bin/python3", "-c", "import backbend\n"
                               "print(len(backbend.compare('even', 'even', sweeps='standard').rigs))"],
                              env=harness.bare_environment(self.folder, PYTHONPATH=str(packages)), cwd=self.folder,
                              capture_output=True, text=True, timeout=harness.PATIENCE_S)
        self.assertEqual((done.returncode, done.stdout), (0, "2\n"), done.stderr)

    def test_nothing_of_the_build_machine_is_installed(self):
        if b"\0.debug_info\0" in harness.BACKBEND.read_bytes():
            self.skipTest("debug information says where the sources are")
        for path in self.prefix.rglob("*"):
            if path.is_file():
                content = path.read_bytes()
                self.assertNotIn(os.fsencode(str(harness.SOURCE)) + b"/", content, path)
                self.assertNotIn(os.fsencode(str(pathlib.Path(BUILD))), content, path)


