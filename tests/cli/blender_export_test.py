"""Rigs of Blender's whose motion is exported: drivers that are disabled."""

import json
import shutil
import subprocess
import unittest

import harness
from blender_rig_test import BlenderRig
from harness import CommandTest, SOURCE


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


if __name__ == "__main__":
    unittest.main()
