"""Rigs of Blender's whose motion is exported: drivers that are disabled, and B-Bones however finely cut."""

import json
import shutil
import subprocess
import unittest

import bridges_test
import harness
from blender_rig_test import BlenderRig
from harness import CommandTest, SOURCE


def of(report, code):
    return [finding for finding in report["findings"] if finding["code"] == code]


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Drivers(BlenderRig, CommandTest):
    def test_an_export_whose_drivers_are_disabled_is_refused_by_name(self):
        path = self.make(flip='"+ jump(var)"', more="""
text = bpy.data.texts.new("functions.py")
text.write("import bpy\\nbpy.app.driver_namespace['jump'] = lambda v: 2.0 if v > 0.7 else 0.0\\n")
text.use_module = True
""")
        mapping = self.write("export.json", json.dumps({**self.MAPPING, "spine": [f"spine{k}" for k in range(5)]}))
        clip = self.folder / "hero.clip"
        for words, code in (([], 3), (["--enable-autoexec"], 0)):
            told = subprocess.run(["blender", "--background", *words, str(path), "--python",
                                   str(SOURCE / "scenes/bridges/backbend_blender.py"), "--", str(mapping), str(clip)],
                                  capture_output=True, text=True, env=harness.bare_environment(self.folder),
                                  timeout=harness.PATIENCE_S)
            self.assertEqual(told.returncode, code, told.stdout + told.stderr)
            self.assertEqual(clip.is_file(), code == 0)
            if code:
                self.assertIn("start Blender with --enable-autoexec", told.stderr)
                self.assertIn("jump(var)", told.stderr)


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Rolls(CommandTest):
    """A B-Bone whose end handle passes half a turn, in a clip of every 2 degrees."""

    def test_it_is_found_however_finely_the_bone_is_cut(self):
        for segments in (6, 8, 10, 16, 32):
            with self.subTest(segments):
                clip = self.folder / "rig.clip"
                rig = bridges_test.B_BONE.replace("bbone_segments = 5", f"bbone_segments = {segments}")
                script = self.write("make.py", rig + bridges_test.EXPORT.format(
                    folder=str(bridges_test.BRIDGES), spine=["hips", "spine"], path=str(clip), stress=True))
                told = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "9", "--python",
                                       str(script)], capture_output=True, text=True, timeout=harness.PATIENCE_S)
                self.assertEqual(told.returncode, 0, told.stdout + told.stderr)
                self.assert_runs("check", "--baked", clip, "--quick", "-o", "run", code=1)
                found = of(json.loads((self.folder / "run/report.json").read_text()), "BB001")
                self.assertTrue(found)
                for finding in found:
                    self.assertLessEqual(abs(abs(finding["control_deg"]) - 180), 2, finding)


if __name__ == "__main__":
    unittest.main()
