"""What a start of the program loads: image libraries only where pictures are read or written."""

import re
import shutil
import unittest

import harness
from harness import BAD_INPUT, INTERNAL, SOURCE, CommandTest

SOLVE = """\
[rig]
system = "curve"
[chain]
joints = [[0, 0, 0], [0, 2, 0], [0, 4, 0], [0, 6, 0]]
[pose]
top = [0, 0, -30]
"""
# What OpenImageIO brings; a start without it loads under twenty.
MOST_LIBRARIES = 40


class Loading(CommandTest):
    def libraries(self, *arguments, code=0):
        """The shared libraries that a command loads, as the loader itself tells."""
        self.assert_runs(*arguments, code=code,
                         environment={"LD_DEBUG": "files", "LD_DEBUG_OUTPUT": str(self.folder / "loaded")})
        loaded = set()
        for path in self.folder.glob("loaded.*"):
            loaded |= set(re.findall(r"calling init: \S*/([^/\s]+)$", path.read_text(), re.MULTILINE))
            path.unlink()
        if "libtbb.so.12" not in loaded:
            raise unittest.SkipTest("the loader does not tell what it loads")
        return loaded

    def test_commands_without_pictures_load_no_image_library(self):
        case = self.write("case.toml", SOLVE)
        for command in (["--version"], ["--help"], ["list", "checks"], ["list", "rigs"], ["explain", "BB010"],
                        ["completions", "bash"], ["config"], ["solve", case],
                        ["inspect", SOURCE / "scenes/characters/human.toml"], ["body", "-o", "body.glb"],
                        ["nightly", "--dry-run", "--quick"]):
            loaded = self.libraries(*command)
            self.assertEqual({name for name in loaded if "OpenImageIO" in name or "pictures" in name}, set(), command)
            self.assertLess(len(loaded), MOST_LIBRARIES, command)

    def test_a_check_that_is_refused_loads_no_image_library(self):
        spoiled = self.write("spoiled.glb", "no glTF")
        for character in ("none.glb", spoiled):
            loaded = self.libraries("check", character, "-o", "out", code=BAD_INPUT)
            self.assertEqual({name for name in loaded if "OpenImageIO" in name or "pictures" in name}, set())

    def test_commands_with_pictures_load_them(self):
        loaded = self.libraries("render", harness.human(), "--res", "32x32", "--spp", "1", "-o", "out")
        self.assertIn("backbend-pictures.so", loaded)
        self.assertTrue(any("libOpenImageIO.so" in name for name in loaded), loaded)


class Missing(CommandTest):
    def test_a_program_without_its_module_says_which_file_it_wants(self):
        alone = self.folder / "bin/backbend"
        alone.parent.mkdir()
        shutil.copy2(harness.BACKBEND, alone)
        saved, harness.BACKBEND = harness.BACKBEND, alone
        self.addCleanup(setattr, harness, "BACKBEND", saved)
        self.assert_runs("list", "checks")
        missing = self.assert_runs("render", SOURCE / "scenes/characters/human.toml", "--res", "32x32", "--spp", "1",
                                   "-o", "out", code=INTERNAL)
        self.assertIn(str(self.folder / "libexec/backbend/backbend-pictures.so"), missing.stderr)
        self.assertFalse(list(self.folder.rglob("*.png")))
