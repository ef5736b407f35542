"""Rigs written in Python: judged as a rig in its own program is; their faults and their errors are found."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from module import PYTHON, SOURCE, ModuleTest, character, human, run_backbend  # noqa: E402

import glb  # noqa: E402

# The rig of the example script, and what its pose() can be made to do.
RIG = f"""
sys.path.insert(0, {str(SOURCE / "scenes/python")!r})
from judge_my_rig import EvenShares, about, turns
body = backbend.load(HUMAN)
class Changed(EvenShares):
    def __init__(self, change, **more):
        super().__init__(body)
        self.change = change
    def pose(self, values):
        return self.change(super().pose(values), values)
"""


class JudgingARigInPython(ModuleTest):
    vertices = 1500  # it is the rig that is judged, a dozen times

    def test_it_is_judged_as_the_same_rig_in_its_own_program_is(self):
        report = json.loads(self.run_script(RIG + "print(backbend.judge(body, EvenShares(body)).text)"))
        inspected = json.loads(self.run_script(RIG + """
import json
heights = [list(map(float, matrix[:3, 3])) for matrix in body.rest_matrices]
print(json.dumps({"joints": [{"name": n, "parent": p, "position": at} for n, p, at in zip(body.joints, body.parents, heights)],
                  "spine": body.anatomy.spine}))
"""))
        (self.folder / "skeleton.json").write_text(json.dumps(inspected))
        command = f"command:{PYTHON} {SOURCE / 'scenes/bridges/example_rig.py'} skeleton.json"
        result = run_backbend(["check", human(self.vertices), "--rig", command, "--quick", "--json", "-o", "out"], self.folder)
        self.assertIn(result.returncode, (0, 1), result.stderr)
        told = json.loads(result.stdout)
        mine, other = report["rigs"][0], told["rigs"][0]
        self.assertEqual(mine["rig"], "EvenShares")
        for ours, theirs in zip(mine["headroom"], other["headroom"]):
            for name in ("channel", "needs_deg", "tested_to_deg"):
                self.assertEqual(ours[name], theirs[name])
            self.assertAlmostEqual(ours["clean_to_deg"], theirs["clean_to_deg"], delta=2.01)  # one step of the sweep
        self.assertEqual({row["code"]: row["planned"] for row in mine["coverage"]},
                         {row["code"]: row["planned"] for row in other["coverage"]})

    def test_a_jump_is_found_at_its_angle(self):
        # Few joints: Python turns each of those above the jump in every pose.
        (self.folder / "tube.glb").write_bytes(glb.tube())
        findings = json.loads(self.run_script(RIG.replace("HUMAN", repr(str(self.folder / "tube.glb"))) + """
import json
chest = body.joints.index(body.anatomy.spine[-1])
def jump(world, values):
    over = values[:, 0] > 40.0
    below = [j for j in range(len(body.joints)) if j == chest or below_chest[j]]
    extra = turns(np.radians(np.where(over, 35.0, 0.0))[:, None] * np.array([[0.0, 1.0, 0.0]]))
    for joint in below:
        moved = world[:, chest].copy()
        there = np.tile(np.eye(4), (len(values), 1, 1)); there[:, :3, 3] = moved[:, :3, 3]
        back = np.tile(np.eye(4), (len(values), 1, 1)); back[:, :3, 3] = -moved[:, :3, 3]
        world[:, joint] = np.where(over[:, None, None], there @ extra @ back @ world[:, joint], world[:, joint])
    return world
below_chest = [False] * len(body.joints)
for joint, parent in enumerate(body.parents):
    below_chest[joint] = parent >= 0 and (parent == chest or below_chest[parent])
report = backbend.judge(body, Changed(jump))
print(json.dumps([finding for finding in report.findings if finding.code == "BB001" and finding.sweep == "extension"]))
"""))
        self.assertTrue(findings)
        self.assertTrue(any(abs(finding["control_deg"] - 40.0) < 1e-3 for finding in findings), findings)
        self.assertTrue(all(finding["owner"] == "RIG" for finding in findings if finding["rig"] == "Changed"))

    def test_a_rig_that_remembers_is_found(self):
        self.run_script(RIG + """
seen = []
def remembers(world, values):
    before = seen[-1] if seen else 0.0
    seen.append(float(values[-1, 0]))
    world[:, :, 2, 3] += 1e-4 * abs(before) * (values[:, :1] != 0.0)
    return world
report = backbend.judge(body, Changed(remembers))
assert any(finding.code == "BB044" for finding in report.findings), report.headline
""")

    def test_its_errors_come_with_what_it_raised(self):
        self.run_script(RIG + """
def fails(world, values):
    raise LookupError("no such control")
def refused(rig, words, cause=None):
    for call in (lambda: backbend.Rig(rig, body), lambda: backbend.judge(body, rig)):
        try:
            call()
        except backbend.InputError as error:
            assert all(word in str(error) for word in words), error
            assert cause is None or isinstance(error.__cause__, cause), repr(error.__cause__)
            assert error.exit_code == 3
        else:
            raise SystemExit(f"taken: {words}")
refused(Changed(fails), ["python:Changed", "LookupError: no such control"], LookupError)
refused(Changed(lambda world, values: world[:, :3]), ["expected", "x 4 x 4"], ValueError)
refused(Changed(lambda world, values: np.full_like(world, np.nan)), ["finite"], ValueError)
refused(Changed(lambda world, values: None), ["real numbers"], TypeError)
refused(Changed(lambda world, values: world * 2.0), ["python:Changed"])
refused(Changed(lambda world, values: backbend.judge(body, "even")), ["pose() cannot judge"], RuntimeError)
class NoPose(backbend.PythonRig):
    pass
refused(NoPose(["extension"], body.joints, body.parents, body.rest_matrices), ["must define pose"], NotImplementedError)
refused(NoPose(["bend"], body.joints, body.parents, body.rest_matrices), ["--map"])
refused(NoPose(["extension"], ["one"], [-1], [np.eye(4)]), ["no joint"])
class NotSetUp(backbend.PythonRig):
    def __init__(self):
        pass
try:
    backbend.judge(body, NotSetUp())
except (RuntimeError, TypeError) as error:
    assert "__init__" in str(error), error
for wrong in (lambda: NoPose(["extension"], ["one"], [-1, 0], [np.eye(4)]), lambda: NoPose(["extension"], ["one"], [-1], np.eye(3))):
    try:
        wrong()
    except ValueError:
        continue
    raise SystemExit("taken")
""")

    def test_few_joints_that_turn_alike_are_no_fault_of_the_rig(self):
        body = character("cesium_man.glb")
        findings = json.loads(self.run_script(RIG.replace("HUMAN", repr(str(body))) + """
import json
class Uneven(EvenShares):
    def __init__(self, body):
        super().__init__(body)
        self.spine = self.spine[:1]
print(json.dumps([[f for f in backbend.judge(body, rig(body)).findings if "equal_shares" in f.geometry] for rig in (EvenShares, Uneven)]))
"""))
        even, uneven = findings
        # Two joints cannot share a bend of 63 degrees; one that does all of it is to blame.
        self.assertTrue([f for f in even if f["code"] == "BB011" and f["geometry"]["equal_shares"] > f["limit"] > f["geometry"]["ideal"]], even)
        self.assertFalse([f for f in even if f["owner"] == "RIG" and f["verdict"] == "fail"], even)
        self.assertTrue([f for f in uneven if f["owner"] == "RIG" and f["verdict"] == "fail"], uneven)

    def test_a_joint_in_the_place_of_the_hips_carries_its_share(self):
        def together(document):  # the spine's first joint goes down to the hips, the next one stays
            document["nodes"][2]["translation"][1] += document["nodes"][1]["translation"][1]
            document["nodes"][1]["translation"][1] = 0
        names = ["hips", "spine", "spine1", "spine2", "chest", "neck", "head"]
        body = glb.with_bind_matrix(glb.tube(names, change=together), 1, lambda matrix: (*matrix[:13], 0.0, *matrix[14:]))
        (self.folder / "body.glb").write_bytes(body)
        findings = json.loads(self.run_script(RIG.replace("HUMAN", repr(str(self.folder / "body.glb"))) + """
import json
assert body.anatomy.spine[:2] == ["hips", "spine"], body.anatomy.spine
print(json.dumps([f for f in backbend.judge(body, EvenShares(body)).findings if f.code in ("BB040", "BB049") and f.verdict == "fail"]))
"""))
        self.assertEqual(findings, [])

    def test_arms_that_hang_below_the_end_of_the_chain_have_no_drift(self):
        findings = json.loads(self.run_script(RIG + """
import json
higher = backbend.load(HUMAN, chest=body.anatomy.spine_to_head[len(body.anatomy.spine)])
assert len(higher.anatomy.spine) == len(body.anatomy.spine) + 1
print(json.dumps([f for f in backbend.judge(higher, EvenShares(higher)).findings if f.code in ("BB020", "BB021", "BB022") and f.verdict == "fail"]))
"""))
        self.assertEqual(findings, [])

    def measured(self, *files, rig):
        """Names of each file's joints, and what is measured on it in one pose, as text."""
        return json.loads(self.run_script(RIG + f"""
import json
class Short(backbend.PythonRig):  # without the last joint
    def __init__(self, body):
        self.whole = EvenShares(body)
        super().__init__(["extension", "side", "twist"], ["hips", "spine", "chest", "neck"], body.parents[:4], body.rest_matrices[:4])
    def pose(self, values):
        return self.whole.pose(values)[:, :4]
told = []
for file in {files!r}:
    body = backbend.load(file, hip="hips", chest="neck")
    measured = body.measure(backbend.Rig({rig}(body), body), extension=40, side=10).metric
    told.append([body.joints[:5], {{name: str(value) for name, value in measured.items()}}])
print(json.dumps(told))
"""))

    def test_joints_that_share_a_name_are_told_apart_by_their_number(self):
        (self.folder / "plain.glb").write_bytes(glb.tube())
        (self.folder / "shared.glb").write_bytes(glb.tube(["hips", "spine", "spine", "neck", "head"]))
        (_, plain), (names, shared) = self.measured("plain.glb", "shared.glb", rig="EvenShares")
        self.assertEqual(names, ["hips", "#1", "#2", "neck", "head"])
        self.assertTrue(plain)
        self.assertEqual(plain, shared)

    def test_of_joints_with_the_name_of_one_of_the_rig_the_one_in_its_place_follows_it(self):
        (self.folder / "plain.glb").write_bytes(glb.tube())
        (self.folder / "shared.glb").write_bytes(glb.tube(["hips", "spine", "chest", "neck", "spine"]))
        (_, plain), (_, shared) = self.measured("plain.glb", "shared.glb", rig="Short")
        self.assertEqual(plain, shared)

    def test_it_is_a_system_like_any_other(self):
        self.run_script(RIG + """
import gc
rig = backbend.Rig(EvenShares(body), body)
gc.collect()
assert rig.channels == ["extension", "side", "twist"] and rig.joints == body.anatomy.spine
poses = rig.solve(np.array([[0.0, 0, 0], [30, 0, 10]]))
assert np.abs(poses.positions[0] - body.chain).max() < 1e-9
bent = body.pose(rig, [[30.0, 0.0, 10.0]])
assert np.abs(bent.matrices[0] - EvenShares(body).pose(np.array([[30.0, 0.0, 10.0]]))[0]).max() < 1e-9
assert "chain_kink" in body.measure(rig, extension=20).metric or body.measure(rig, extension=20).metric
report = backbend.compare(EvenShares(body), "isner", character=body, sweeps="standard")
assert report.comparisons[0].paired > 0
""")
