"""The package around the module: types, examples, a light import, Blender."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from module import MODULE, PATIENCE_S, PYTHON, SOURCE, ModuleTest, has, human  # noqa: E402

EXAMPLES = sorted((SOURCE / "scenes/python").glob("*.py"))
STUB = SOURCE / "cli/python/backbend/__init__.pyi"


class Types(ModuleTest):
    def test_the_examples_pass_mypy_strictly(self):
        if not has("mypy"):
            self.skipTest("mypy is not installed")
        # matplotlib of Debian brings no types.
        (self.folder / "mypy.ini").write_text("[mypy]\n[mypy-matplotlib.*]\nignore_missing_imports = True\n")
        self.assertEqual(len(EXAMPLES), 3)
        for files in (EXAMPLES, [STUB]):
            done = subprocess.run([PYTHON, "-m", "mypy", "--strict", "--config-file", "mypy.ini", *map(str, files)],
                                  cwd=self.folder, env=self.environment() | {"MYPYPATH": str(MODULE)},
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_wrong_use_does_not_pass(self):
        if not has("mypy"):
            self.skipTest("mypy is not installed")
        (self.folder / "wrong.py").write_text(
            'import backbend\nreport = backbend.judge("hero.glb", sweeps="all")\nreport.findings[0].code + 1\n')
        done = subprocess.run([PYTHON, "-m", "mypy", "--strict", "wrong.py"], cwd=self.folder,
                              env=self.environment() | {"MYPYPATH": str(MODULE)}, capture_output=True, text=True)
        self.assertIn("Found 2 errors", done.stdout)

    def test_the_types_name_what_the_module_has(self):
        text = STUB.read_text()
        told = self.run_script("""
for kind in (backbend.Character, backbend.Rig, backbend.Chain, backbend.PythonRig):
    print(kind.__name__, *(name for name in vars(kind) if not name.startswith("_")))
print("module", *(name for name in backbend.__all__ if name[0].islower() and not name.startswith("_")))
""")
        for line in told.splitlines():
            kind, *names = line.split()
            body = text if kind == "module" else re.search(rf"^class {kind}:\n((?:    .*\n|\n)+)", text, re.M)[1]
            defined = set(re.findall(r"^\s*def (\w+)", body, re.M)) - {"__init__"}
            if kind == "module":
                defined = set(re.findall(r"^def (\w+)", text, re.M))
            self.assertEqual(set(names), defined, kind)

    def test_the_types_of_a_report_are_the_names_of_its_schema(self):
        schema = json.loads((SOURCE / "validate/report/report.schema.json").read_text())
        text = STUB.read_text()
        named = {frozenset(re.findall(r"^    (\w+):", body, re.M))
                 for body in re.findall(r"^class \w+\(Record\):\n((?:    .*\n)+)", text, re.M)}
        for name, definition in [*schema["definitions"].items(), ("report", schema)]:
            if "properties" in definition:
                wanted = set(definition["properties"]) | ({"text"} if name == "report" else set())
                self.assertIn(frozenset(wanted), named, name)

    def test_every_public_thing_says_what_it_does(self):
        self.run_script("""
import inspect
for name in backbend.__all__:
    thing = getattr(backbend, name)
    if isinstance(thing, str): continue
    assert inspect.getdoc(thing), name
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            if not member.startswith("_"):
                assert inspect.getdoc(value), (name, member)
""")


class Examples(ModuleTest):
    def example(self, name, *arguments, codes=(0,)):
        done = subprocess.run([PYTHON, str(SOURCE / "scenes/python" / name), *map(str, arguments)], cwd=self.folder,
                              env=self.environment(), capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return done.stdout

    def test_judge_my_rig(self):
        out = self.example("judge_my_rig.py", human(), codes=(0, 1))
        self.assertRegex(out, r"extension +clean to \d+\.?\d*, needs 60")

    def test_headroom_over_versions(self):
        if not has("matplotlib"):
            self.skipTest("matplotlib is not installed")
        out = self.example("headroom_over_versions.py", human(), human(), "-o", "headroom.png")
        self.assertRegex(out, r"(?m)^extension (\S+) \1$")
        self.assertEqual((self.folder / "headroom.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_search_a_pose(self):
        out = self.example("search_a_pose.py", human(), "--evaluations", "12")
        self.assertRegex(out, r"^mesh_kink \d+\.\d+ at extension=\S+,side=\S+,twist=\S+\nbackbend render ")
        self.assertEqual(out, self.example("search_a_pose.py", human(), "--evaluations", "12"))


class Importing(ModuleTest):
    def test_it_brings_neither_numpy_nor_the_libraries_of_pictures(self):
        done = subprocess.run([PYTHON, "-c", "import sys, backbend\n"
                               "assert 'numpy' not in sys.modules and 'json' not in sys.modules\n"
                               "maps = open('/proc/self/maps').read()\n"
                               "assert '_core' in maps and 'OpenImageIO' not in maps and 'opencv' not in maps\n"],
                              env=self.environment(), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_only_its_entry_is_seen_by_other_libraries(self):
        if not shutil.which("nm"):
            self.skipTest("binutils are not installed")
        (library,) = (MODULE / "backbend").glob("_core*.so")
        names = subprocess.run(["nm", "-D", "--defined-only", "-C", library], capture_output=True, text=True, check=True).stdout
        ours = [line for line in names.splitlines() if "backbend::" in line]
        self.assertEqual(ours, [])
        self.assertIn("PyInit__core", names)


class BesideOthers(ModuleTest):
    def test_exceptions_of_another_module_stay_its_own(self):
        if not has("contourpy"):
            self.skipTest("no other module of pybind11 is installed (matplotlib brings contourpy)")
        self.run_script("""
import contourpy
levels = contourpy.contour_generator(z=np.zeros((2, 2)))
try:
    levels.filled(2.0, 1.0)  # std::invalid_argument
except ValueError as error:
    assert not isinstance(error, backbend.Error), repr(error)
else:
    raise SystemExit("taken")
""")


class InBlender(ModuleTest):
    def test_its_python_imports_and_judges(self):
        blender = shutil.which("blender")
        if not blender:
            self.skipTest("Blender is not installed")
        if os.environ.get("BACKBEND_PRELOAD"):
            self.skipTest("Blender does not run under a sanitizer")
        # Debian's Blender takes its modules from beside the first python3 on the PATH: the system's.
        environment = self.environment() | {"PATH": os.path.dirname(PYTHON) + os.pathsep + os.environ["PATH"]}
        script = self.folder / "in_blender.py"
        script.write_text("import os, sys\nsys.path.insert(0, os.environ['PYTHONPATH'])\nimport bpy, backbend, numpy\n"
                          "body = backbend.load(os.environ['HUMAN'])\nreport = backbend.judge(body, 'even')\n"
                          "rig = backbend.Rig('even', body)\n"
                          "mesh = bpy.data.meshes.new('posed')\n"
                          "posed = body.pose(rig, rig.controls(extension=45))\n"
                          "mesh.from_pydata(posed.positions[0].tolist(), [], body.triangles.tolist())\n"
                          "assert len(mesh.vertices) == len(body.positions)\n"
                          "pixels = body.render(rig, extension=45, width=32, height=32, samples=1).layers['RGBA']\n"
                          "assert numpy.isfinite(pixels).all()\n"
                          "print('judged in Blender', bpy.app.version_string, report.exit_code)\n")
        done = subprocess.run([blender, "--background", "--factory-startup", "--python-exit-code", "3", "--python", script],
                              env=environment, cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("judged in Blender", done.stdout)
