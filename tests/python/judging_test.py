"""judge, compare, measures and pictures from Python: the command's own results."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from module import SOURCE, ModuleTest, human, run_backbend  # noqa: E402

import exr  # noqa: E402  (beside the command's tests)


def without_program(report):
    """A report without what says which program made it."""
    report = dict(report)
    report.pop("provenance")
    return report


class JudgingLikeTheCommand(ModuleTest):
    vertices = 1500

    def test_the_report_is_that_of_check(self):
        result = run_backbend(["check", human(self.vertices), "--rig", "curve", "--quick", "--json", "-o", "out"], self.folder)
        told = json.loads(result.stdout)
        mine = json.loads(self.run_script('print(backbend.judge(HUMAN, "curve").text)'))
        self.assertEqual(mine["exit_code"], result.returncode)
        self.assertEqual(without_program(mine), without_program(told))
        self.assertEqual(sorted(path.name for path in self.folder.iterdir() if path.name != "out"), [])

    def test_the_report_is_an_object_with_the_names_of_the_schema(self):
        schema = json.loads((SOURCE / "validate/report/report.schema.json").read_text())
        self.run_script("""
report = backbend.judge(backbend.load(HUMAN), "isner")
for name in sys.argv[1:]:
    assert name in report, name
    getattr(report, name)
assert report.rigs[0].system == "isner" and report.rigs[0].headroom[0].channel == "extension"
assert any(finding.code == "BB001" and finding.verdict == "stress" for finding in report.findings)
assert report.findings[0]["code"] == report.findings[0].code
try:
    report.findigns
except AttributeError as error:
    assert "findings" in str(error)
""", *schema["required"])

    def test_a_folder_gets_the_report_in_all_its_forms(self):
        self.run_script("""
report = backbend.judge(HUMAN, "even", folder="out", pictures=False)
assert open("out/report.json").read().strip() == report.text.strip()
assert os.path.exists("out/index.html")
""")

    def test_a_folder_that_cannot_be_written_is_a_write_error(self):
        (self.folder / "file").write_text("")
        self.run_script("""
try:
    backbend.judge(HUMAN, "even", folder="file/out", pictures=False)
except backbend.WriteError as error:
    assert error.exit_code == 73 and isinstance(error, OSError), error
else:
    raise SystemExit("written below a file")
""")

    def test_comparing_two_rigs_is_what_the_command_says(self):
        result = run_backbend(["compare", "even", "isner", "--character", human(self.vertices), "--quick", "--sweeps", "standard",
                               "--json", "-o", "out"], self.folder)
        told = json.loads(result.stdout)
        mine = json.loads(self.run_script(
            'print(backbend.compare("even", "isner", character=HUMAN, sweeps="standard").text)'))
        self.assertEqual(mine["comparisons"], told["comparisons"])
        self.assertEqual(mine["findings"], told["findings"])

    def test_two_characters_are_compared(self):
        self.run_script("""
body = backbend.load(HUMAN)
report = backbend.compare(body, body, sweeps="standard")
(comparison,) = report.comparisons
assert comparison.ahead in (None, "") and comparison.same == comparison.paired > 0, comparison
""")


class MeasuringAndDrawing(ModuleTest):
    def test_a_pose_measures_what_the_sweep_measures_there(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("curve", body)
sweep = body.measure_sweep(rig, "extension")
at = int(np.flatnonzero(sweep.control_deg == 60)[0])
pose = body.measure(rig, extension=60)
compared = 0
for name, values in pose.metric.items():
    assert pose.unit[name] == sweep.unit[name]
    if np.isfinite(values[0]):
        assert values[0] == sweep.metric[name][at], name
        compared += 1
assert compared > 10
""")

    def test_a_picture_holds_the_pixels_of_the_command(self):
        run = run_backbend(["render", human(), "--rig", "even", "--pose", "extension=60", "--res", "64x48", "--spp", "2",
                            "--aovs", "all", "-o", "out", "--name", "picture"], self.folder)
        self.assertEqual(run.returncode, 0, run.stderr)
        file = exr.Exr(self.folder / "out/picture.exr")
        pixels = {name: list(file.channels[name]) for name in file.channels}
        (self.folder / "pixels.json").write_text(json.dumps(pixels))
        self.run_script("""
import json
body = backbend.load(HUMAN)
picture = body.render(backbend.Rig("even", body), extension=60, width=64, height=48, samples=2, all_layers=True)
layers = picture.layers
assert layers["RGBA"].shape == (48, 64, 4) and layers["Z"].shape == (48, 64, 1) and layers["N"].shape == (48, 64, 3)
told = {name: np.array(values, np.float32).reshape(48, 64) for name, values in json.load(open("pixels.json")).items()}
found = {}
for name, layer in layers.items():
    assert layer.dtype == np.float32 and layer.shape[:2] == (48, 64), name
    channels = [["R", "G", "B", "A"], [name], *([f"{name}.{part}" for part in parts] for parts in ("XYZ", "RGB", "rgba"))]
    (named,) = [each for each in channels if len(each) == layer.shape[2] and set(each) <= set(told) - set(found)][:1]
    found |= {channel: layer[..., k] for k, channel in enumerate(named)}
assert set(found) == set(told), set(found) ^ set(told)
for name, values in told.items():  # of half precision some
    assert np.allclose(found[name], values, rtol=1e-3, atol=1e-6, equal_nan=True), name
assert (layers["Z"][..., 0] == told["Z"]).all() and (found["P.X"] == told["P.X"]).all()
assert any(name.endswith("/manifest") and "{" in text for name, text in picture.attributes.items())
hit = layers["Z"][..., 0] < 1e9
assert 0.03 < hit.mean() < 1.0
# What P says of a pixel projects back onto it.
row, column = map(int, np.argwhere(hit)[hit.sum() // 2])
at = picture.ndc_from_world @ np.append(layers["P"][row, column], 1.0)
assert abs(at[0] / at[3] * 64 - column - 0.5) < 1 and abs(at[1] / at[3] * 48 - row - 0.5) < 1
""")

    def test_the_same_picture_comes_for_any_number_of_threads(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
pictures = []
for threads in (1, 0):
    backbend.set_threads(threads)
    pictures.append(body.render(rig, side=30, width=64, height=48, samples=1, mode="heat").layers["RGBA"])
assert (pictures[0] == pictures[1]).all()
assert (body.render(rig, side=30, width=64, height=48, samples=1, mode="heat",
                    heat=np.zeros(len(body.positions))).layers["RGBA"] != pictures[0]).any()
""")
