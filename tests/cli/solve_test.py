"""backbend solve: the acceptance cases, and the manners of its output."""

import json
import math
import pathlib
import re
import shutil

from harness import BAD_INPUT, CommandTest, SOURCE, USAGE

ACCEPT = SOURCE / "tests/accept"

STRAIGHT = """\
[rig]
system = "curve"
bones = 10

[chain]
joints = [[0, 0, 0], [0, 2, 0], [0, 4, 0], [0, 6, 0]]

[pose]
lower = [0, 0, 0]
middle = [0, 0, -20]
top = [10, 0, -30]
"""


def degrees_between(p, q):
    """The angle of the turn from p to q, quaternions w,x,y,z of either sign: atan2 keeps its digits
    near zero, where the arc cosine of a dot product has none."""
    pw, px, py, pz = (c / math.hypot(*p) for c in p)
    qw, qx, qy, qz = (c / math.hypot(*q) for c in q)
    vector = (pw * qx - px * qw - py * qz + pz * qy,
              pw * qy + px * qz - py * qw - pz * qx,
              pw * qz - px * qy + py * qx - pz * qw)
    scalar = pw * qw + px * qx + py * qy + pz * qz
    return math.degrees(2 * math.atan2(math.hypot(*vector), abs(scalar)))


class AcceptanceCases(CommandTest):
    def setUp(self):
        super().setUp()
        shutil.copy(ACCEPT / "mSaurus_neck.json", self.folder)  # a rest file lies beside its TOML
        self.cases = json.loads((ACCEPT / "solver_cases.json").read_text())["cases"]

    def test_every_case_gives_the_expected_numbers(self):
        self.assertGreaterEqual(len(self.cases), 27)
        for case in self.cases:
            with self.subTest(case["name"]):
                file = self.write("case.toml", case["toml"])
                result = self.assert_runs("solve", file.name, "--json")
                self.compare(json.loads(result.stdout), case)

    def compare(self, pose, case):
        self.assertEqual(pose["schema"], "backbend.pose/1")
        expect, joints, compared = case["expect"], pose["joints"], 0
        if "positions" in expect:
            chosen = expect.get("joint_indices", range(len(joints)))
            self.assertEqual(len(chosen), len(expect["positions"]))
            for joint, position in zip(chosen, expect["positions"]):
                off = math.dist(joints[joint]["position"], position)
                self.assertLessEqual(off, case["tol_position"], f"position of joint {joint}")
                compared += 1
        if "turns_wxyz" in expect:
            self.assertLessEqual(len(expect["turns_wxyz"]), len(joints))
            for joint, turn in enumerate(expect["turns_wxyz"]):
                off = degrees_between(joints[joint]["turn"], turn)
                self.assertLessEqual(off, case["tol_turn_deg"], f"turn of joint {joint}")
                compared += 1
        for name, value in expect.get("measures", {}).items():
            off = abs(pose["measures"][name] - value)
            self.assertLessEqual(off, case["tol_measure"], f"measure {name}")
            compared += 1
        self.assertGreater(compared, 0)


class Solving(CommandTest):
    def test_stdout_is_one_json_object_and_stderr_is_empty(self):
        self.write("pose.toml", STRAIGHT)
        result = self.assert_runs("solve", "pose.toml", "--json")
        pose = json.loads(result.stdout)
        self.assertEqual(result.stderr, "")
        self.assertLessEqual({"schema", "system", "options", "joints", "measures"}, pose.keys())
        self.assertEqual(pose["system"], "curve")
        self.assertEqual(len(pose["joints"]), 11)  # ten bones and the tip
        self.assertEqual(pose["options"]["basis"], "bspline")  # options come with their defaults
        for joint in pose["joints"]:
            self.assertLessEqual({"name", "parent", "position", "turn"}, joint.keys())

    def test_a_sweep_gives_one_object_a_line_and_the_same_poses_as_one_by_one(self):
        self.write("pose.toml", STRAIGHT)
        lines = self.assert_runs("solve", "pose.toml", "--sweep", "top.rz=0:-90:-30").stdout.splitlines()
        self.assertEqual(len(lines), 4)
        for line, angle in zip(lines, (0, -30, -60, -90)):
            self.write("one.toml", STRAIGHT.replace("[10, 0, -30]", f"[10, 0, {angle}]"))
            alone = json.loads(self.assert_runs("solve", "one.toml", "--json").stdout)
            self.assertEqual(json.loads(line)["joints"], alone["joints"], angle)

    def test_the_same_bytes_from_anywhere_in_any_locale(self):
        file = self.write("a folder/pöse.toml", STRAIGHT)
        expected = self.assert_runs("solve", file, "--json").stdout
        for environment in ({"LC_ALL": "de_DE.UTF-8"}, {"LC_ALL": "C"}, {"LANG": "tr_TR.UTF-8"},
                            {"TZ": "Asia/Kolkata"}, {"LC_NUMERIC": "fr_FR.UTF-8"}):
            again = self.assert_runs("solve", file.name, "--json", cwd=file.parent, environment=environment)
            self.assertEqual(again.stdout, expected, environment)
        self.assertEqual(self.assert_runs("--threads", "1", "solve", file, "--json").stdout, expected)


class Explaining(CommandTest):
    def explained(self, text):
        """The sections that --explain prints: name to lines."""
        told = self.assert_runs("solve", self.write("pose.toml", text), "--explain").stdout.splitlines()
        sections, name = {}, None
        for line in told[1:]:
            if line.startswith("  "):
                sections[name].append(line.strip())
            else:
                name = line
                sections[name] = []
        return told[0], sections

    def test_every_system_says_its_inputs_options_order_and_measures(self):
        for system in ("three_bone", "curve", "even", "isner", "stretchy", "neck", "snake", "spline_ik", "matrix_blend"):
            chain = STRAIGHT.replace('"curve"', f'"{system}"').replace("bones = 10\n", "")
            chain = chain[:chain.index("[pose]")]
            with self.subTest(system=system):
                name, sections = self.explained(chain)
                self.assertEqual(name, system)
                solved = json.loads(self.assert_runs("solve", "pose.toml", "--json").stdout)
                self.assertEqual({line.split(" = ")[0] for line in sections["options"]}, set(solved["options"]))
                measures = dict(line.split(" = ") for line in sections["measures"])
                self.assertEqual(set(measures), set(solved["measures"]))
                for key, value in measures.items():
                    self.assertAlmostEqual(float(value), solved["measures"][key], delta=1e-5)
                steps = sections["order of evaluation"]
                self.assertEqual([int(line.split()[0]) for line in steps], list(range(1, len(steps) + 1)))
                self.assertTrue(steps and sections["inputs"])
                self.assertIn("0 deg: twist 0, aim 0", sections["drift of the arms against the chest control"][0])

    def test_the_curve_spines_drift_is_explained_by_its_parts(self):
        bent = STRAIGHT.replace("[0, 0, -20]", "[10, 30, 40]").replace("[10, 0, -30]", "[20, -25, 50]")
        _, sections = self.explained(bent)
        self.assertIn("middle  rx 10 deg  ry 30 deg  rz 40 deg", sections["inputs"])
        drift, story = sections["drift of the arms against the chest control"]
        twist = float(re.search(r"twist (-?[0-9.]+), aim", drift)[1])
        parts = [float(part) for part in re.findall(r"(-?[0-9.]+)(?: \+| deg$)", story)]
        self.assertEqual(len(parts), 3)
        self.assertGreater(abs(twist), 1.0)
        self.assertAlmostEqual(abs(sum(parts)), abs(twist), delta=0.05)
        # Twist of the control below Top never reaches the chain.
        self.assertIn("lost twist", story)

    def test_what_a_pose_complains_of_is_a_flag(self):
        slid = STRAIGHT.replace('"curve"', '"snake"').replace("bones = 10\n", "")
        slid = slid[:slid.index("[pose]")] + "[pose]\nslide = 2\n"
        _, sections = self.explained(slid)
        self.assertTrue(any(name.startswith("flag  'slide' is past 0 to 1") for name in sections), sections.keys())


class SolveRefuses(CommandTest):
    """One line, exit code 3, nothing written; wherever there is one, with the line and a nearest name."""

    def refuse(self, text, *names):
        self.write("pose.toml", text)
        return self.assert_refused("solve", "pose.toml", "--json", names=("pose.toml", *names))

    def test_what_is_no_file(self):
        self.assert_refused("solve", "missing.toml", "--json", names=["missing.toml"])
        self.assert_refused("solve", ".", "--json", names=["."])
        self.assert_refused("solve", "/dev/null/x.toml", "--json")

    def test_what_is_no_toml(self):
        self.refuse("[rig\nsystem = 1", ":1")
        self.refuse("")
        self.write("pose.toml", b"\x00\xff\xfe binary")
        self.assert_refused("solve", "pose.toml", names=["pose.toml"])

    def test_a_long_nesting_and_a_huge_list(self):
        self.refuse("a = " + "[" * 100_000)
        self.refuse("[chain]\njoints = [" + "[0, 0, 0]," * 200_000 + "]\n")

    def test_an_unknown_rig(self):
        self.refuse(STRAIGHT.replace('"curve"', '"curv"'), ":2", "curv", "'curve'")

    def test_an_unknown_key_with_the_nearest_name(self):
        self.refuse(STRAIGHT.replace("bones", "bonse"), ":3", "bonse", "bones")
        self.refuse(STRAIGHT.replace("middle", "midle"), ":10", "midle", "middle")
        self.refuse(STRAIGHT.replace("[chain]", "[chian]"), "chian", "chain")
        self.refuse(STRAIGHT + "[extra]\n", "extra")

    def test_a_wrong_type_or_value(self):
        self.refuse(STRAIGHT.replace("bones = 10", 'bones = "ten"'), ":3", "bones")
        for count in ("0", "65", "-1", "1.5", "99999999999"):
            self.refuse(STRAIGHT.replace("bones = 10", f"bones = {count}"), ":3", "bones")
        self.refuse(STRAIGHT.replace('"curve"', '"curve"\nbasis = "bezier"'), ":3", "bezier")
        self.refuse(STRAIGHT.replace("[10, 0, -30]", "[10, 0]"), "top")
        self.refuse(STRAIGHT.replace("[0, 6, 0]", "[0, 6]"))

    def test_numbers_that_are_not_finite(self):
        for number in ("nan", "-inf", "1e999"):
            self.refuse(STRAIGHT.replace("-30", number), ":11")
            self.refuse(STRAIGHT.replace("[0, 6, 0]", f"[0, {number}, 0]"), ":6")

    def test_a_chain_without_length(self):
        self.refuse(STRAIGHT.replace("[0, 4, 0]", "[0, 2, 0]"))
        self.refuse(STRAIGHT.replace("joints = [[0, 0, 0], [0, 2, 0], [0, 4, 0], [0, 6, 0]]", "joints = []"))

    def test_a_translation_of_a_control_that_only_turns(self):
        self.refuse(STRAIGHT + "top_move = [0, 1, 0]\n", "top")

    def test_a_rest_file_outside_the_files_folder(self):
        neck = '[rig]\nsystem = "neck"\n[chain]\nrest = "%s"\n[pose]\nroll = 0\n'
        self.refuse(neck % "missing.json", "missing.json")
        outside = pathlib.Path("/etc/hostname")
        self.refuse(neck % outside)
        self.refuse(neck % "../../../../../../../../etc/hostname")

    def test_a_sweep_that_is_none(self):
        self.write("pose.toml", STRAIGHT)
        for sweep in ("top.rz", "top.rz=0:10", "top.rz=0:10:0", "top.rz=0:10:-1", "tpo.rz=0:10:1",
                      "top.rz=0:nan:1", "top.rz=0:1e30:1e-9"):
            result = self.backbend("solve", "pose.toml", "--sweep", sweep)
            self.assertIn(result.returncode, (USAGE, BAD_INPUT), sweep)
            self.assert_refused("solve", "pose.toml", "--sweep", sweep, code=result.returncode)
