"""`backbend hunt`: the worst poses of a rig in a box, confirmed, and added to a suite that then finds them."""

import json
import signal
import subprocess
import time

from external_rig_test import RigTest
from harness import BACKBEND, BAD_INPUT, CommandTest, USAGE, human

FEW = ("--evaluations", "600")


class Hunt(CommandTest):
    def setUp(self):
        super().setUp()
        self.write("hero.glb", human(1500).read_bytes())

    def hunt(self, *words, code=1):
        return json.loads(self.assert_runs("hunt", *words, "--character", "hero.glb", "--json", "-q", code=code).stdout)

    def found(self, hunt, code):
        return [find for find in hunt["findings"] if find["code"] == code]

    def test_the_known_flip_of_the_isner_spine_is_found_at_its_angle(self):
        hunt = self.hunt("isner", "--box", "sweep", "--envelope", "sweep", "--check", "BB001")
        flips = self.found(hunt, "BB001")
        self.assertTrue(any(find["from"]["extension"] < 100.87 < find["pose"]["extension"] + 0.01
                            and set(find["pose"]) == {"extension"} for find in flips), flips)
        for find in flips:
            self.assertGreater(find["value"], 170)
            self.assertIn("chest.rz", find["controls"])

    def test_what_it_adds_to_a_suite_the_next_night_fails(self):
        text = '# ours\n[suite]\ncharacters = ["hero.glb"]\ncorners = false\nenvelope = "human"\n\n' \
               '[[rig]]\nsolver = { system = "curve" }\n\n[[sweep]]\nchannel = "side"\nto = 5\nstep = 5'
        self.write("night.toml", text)
        hunt = self.hunt("curve", *FEW, "--add-to", "night.toml")
        added = (self.folder / "night.toml").read_text()
        self.assertTrue(added.startswith(text))
        # Several checks may be at their worst in one pose.
        self.assertEqual(added.count("[[pose]]"), len({json.dumps(find["pose"], sort_keys=True) for find in hunt["findings"]}))
        result = self.backbend("nightly", "night.toml", "--quick", "--json", "-o", "run")
        night = json.loads(result.stdout)
        for find in hunt["findings"]:
            same = [f for f in night["findings"] if f["code"] == find["code"]
                    and abs(f["value"] - find["value"]) < 1e-9 * abs(find["value"])]
            self.assertTrue(same, find)
        # A second hunt finds the same, and adds nothing twice.
        self.hunt("curve", *FEW, "--add-to", "night.toml")
        self.assertEqual((self.folder / "night.toml").read_text(), added)

    def test_it_says_what_to_set_how_wide_it_is_and_what_it_may_have_missed(self):
        done = self.assert_runs("hunt", "curve", "--character", "hero.glb", *FEW, "-o", "out", "--res", "64x48", code=1)
        self.assertIn("arm drift, rotation", done.stdout)
        self.assertRegex(done.stdout, r"set top\.r[xyz] ")
        self.assertRegex(done.stdout, r"width of the bad region here: .*deg of bend")
        self.assertIn("This is a search, not a proof.", done.stdout)
        told = json.loads((self.folder / "out/hunt.json").read_text())
        for find in told["findings"]:
            self.assertTrue((self.folder / "out" / find["picture"]).is_file())
            # The command that is shown renders that pose.
            self.assertIn("backbend render hero.glb --rig curve", find["reproduce"])

    def test_a_sound_rig_passes_and_says_the_worst_of_each_check(self):
        hunt = self.hunt("even", *FEW, code=0)
        self.assertEqual([find for find in hunt["findings"] if find["verdict"] == "fail"], [])
        self.assertIn("BB030", [worst["code"] for worst in hunt["worst"]])
        self.assertLessEqual(hunt["evaluations"], 600)

    def test_a_box_of_ones_own_bounds_the_poses(self):
        self.write("box.toml", "extension = [30, 50]\nside = [10, 20]\ntwist = [5, 5]\n")
        hunt = self.hunt("curve", *FEW, "--box", "box.toml", "--check", "BB020")
        (find,) = hunt["findings"]
        self.assertEqual(find["pose"]["twist"], 5)
        self.assertTrue(30 <= find["pose"]["extension"] <= 50 and 10 <= find["pose"]["side"] <= 20, find["pose"])

    def test_threads_change_nothing_and_seeds_do(self):
        def text(*words):
            return self.assert_runs("hunt", "curve", "--character", "hero.glb", "--json", "-q", *FEW, *words, code=1).stdout
        one = text("--threads", "1")
        self.assertEqual(one, text("--threads", "3"))
        self.assertNotEqual(one, text("--seed", "2"))

    def test_a_stopped_hunt_goes_on_to_the_same_result(self):
        question = ["hunt", "curve", "--character", "hero.glb", "--evaluations", "3000", "--res", "64x48", "--threads", "1"]
        self.assert_runs(*question, "-o", "whole", code=1)
        self.assertFalse((self.folder / "whole/parts").exists())
        stopped = subprocess.Popen([str(BACKBEND), *question, "-o", "out"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for _ in range(600):  # until something is kept
            if stopped.poll() is not None or len(list(self.folder.glob("out/parts/*"))) > 1:
                break
            time.sleep(0.05)
        stopped.send_signal(signal.SIGINT)
        said = stopped.communicate(timeout=120)[1]
        if stopped.returncode == 130:  # else it was done before
            self.assertIn("--resume", said)
        self.assert_runs(*question, "-o", "out", "--resume", code=1)
        self.assertEqual((self.folder / "out/hunt.json").read_text(), (self.folder / "whole/hunt.json").read_text())
        self.assert_refused("hunt", "curve", "--character", "hero.glb", "--resume", code=USAGE, names=["-o"])

    def test_parts_of_a_stopped_night_are_left_alone(self):
        self.write("night/parts/plan.json", "{}")
        self.assert_refused("hunt", "curve", "--character", "hero.glb", *FEW, "-o", "night", code=BAD_INPUT, names=["night"])
        self.assertTrue((self.folder / "night/parts/plan.json").exists())

    def test_what_it_cannot_search_is_refused(self):
        self.write("bad.toml", "side = [10, -10]\n")
        words = ("--character", "hero.glb")
        self.assert_refused("hunt", "curve", *words, "--box", "bad.toml", names=["bad.toml:1", "inverted"])
        self.assert_refused("hunt", "curve", *words, "--box", "envelop", names=["envelope"])
        self.assert_refused("hunt", "curve", *words, "--box", "gone.toml", names=["gone.toml"])
        self.assert_refused("hunt", "curve", *words, "--check", "BB042", code=USAGE, names=["BB042"])
        self.assert_refused("hunt", "curve", *words, "--evaluations", "5", code=USAGE)
        self.assert_refused("hunt", "curvy", *words, names=["curve"])
        self.assert_refused("hunt", "curve:bonse=3", *words, names=["bonse"])
        self.assert_refused("hunt", "curve", "--character", "gone.glb", names=["gone.glb"])
        self.assert_refused("hunt", "curve", *words, "--add-to", "gone.toml", names=["gone.toml"])


class NightHunt(CommandTest):
    """A night whose only sweep shows little: what fails inside the envelope is found between the sweeps, or not at all."""

    TEXT = '[suite]\ncharacters = ["hero.glb"]\ncorners = false\nenvelope = "human"\n\n' \
           '[[rig]]\nsolver = { system = "curve" }\n\n[[rig]]\nsolver = { system = "even" }\nrole = "reference"\n\n' \
           '[[sweep]]\nchannel = "extension"\nto = 2\nstep = 2\n' \
           '[[sweep]]\nchannel = "side"\nto = 2\nstep = 2\n' \
           '[[sweep]]\nchannel = "twist"\nto = 2\nstep = 2\n'

    def setUp(self):
        super().setUp()
        self.write("hero.glb", human(1500).read_bytes())
        self.write("night.toml", self.TEXT)

    def night(self, run, *words, code=1):
        done = self.backbend("nightly", "night.toml", "-o", run, "--quick", *words)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return json.loads((self.folder / run / "report.json").read_text()), done.stdout

    def test_it_finds_what_its_sweeps_do_not_show_and_says_what_it_searched(self):
        report, told = self.night("run", "--hunt-percent", "3000")
        curve, even = report["rigs"]
        hunt = curve["hunt"]
        # Six poses are swept.
        self.assertTrue(140 <= hunt["evaluations"] <= 180, hunt["evaluations"])
        self.assertEqual(hunt["box"], "extension 0..60, flexion 0..90, side -45..45, twist -60..60")
        self.assertIn(f"curve/chest: searched {hunt['evaluations']} poses of extension 0..60", " ".join(told.split()))
        finds = [worst for worst in hunt["worst"] if worst["sweep"]]
        self.assertTrue(finds)
        for find in finds:
            self.assertTrue(find["over"])
            # It is a finding like any other: measured on a path of its own, with the pose, its owner and a command.
            same = [f for f in report["findings"] if f["sweep"] == find["sweep"] and f["code"] == find["code"]]
            self.assertEqual(len(same), 1, find)
            self.assertTrue(same[0]["inside_envelope"] and same[0]["owner"] and "--pose" in same[0]["reproduce"], same)
            if find["code"] == "BB002":  # of others the path's end is named
                self.assertEqual(find["pose"], same[0]["pose"])
            if find["pose"] == same[0]["pose"]:
                self.assertAlmostEqual(same[0]["value"], find["value"], delta=1e-3 * abs(find["value"]))
            # No sweep shows as much.
            for other in report["findings"]:
                if other["code"] == find["code"] and other["rig"] == "curve" and not other["sweep"].startswith("hunt "):
                    self.assertLess(other["value"], find["value"])
            (path,) = [s for s in curve["sweeps"] if s["sweep"] == find["sweep"]]
            self.assertGreater(len(path["control_deg"]), 2)
        # A search does not show that a rig is clean.
        self.assertNotIn("clean", [line for line in told.splitlines() if " hunt " in line][0])
        # Each rig has its own paths, and they are no pairs.
        self.assertFalse([s for c in report["comparisons"] for s in c["sweeps"] if s["sweep"].startswith("hunt ")])

    def test_the_same_for_any_threads_and_shards_and_nothing_with_0(self):
        words = ("--hunt-percent", "700")
        self.night("one", *words, "--threads", "1")
        self.night("three", *words, "--threads", "3")
        expected = (self.folder / "one/report.json").read_text()
        self.assertEqual(expected, (self.folder / "three/report.json").read_text())
        for share in ("1/2", "2/2"):
            self.assert_runs("nightly", "night.toml", "--quick", *words, "-o", share[0], "--shard", share)
        self.assert_runs("merge", "1", "2", "-o", "merged", code=1)
        self.assertEqual(expected, (self.folder / "merged/report.json").read_text())
        for none in (("--hunt-percent", "0"), ()):  # a quick night searches where it is told to
            report, told = self.night("none", *none, code=5)  # the sweeps do not cover the envelope
            self.assertFalse([finding for finding in report["findings"] if finding["verdict"] == "fail"])
            self.assertFalse([rig for rig in report["rigs"] if "hunt" in rig or "volume" in rig])
            self.assertNotIn("searched", told)

    def test_proved_and_searched_volume_stand_apart(self):
        report, told = self.night("run", "--hunt-percent", "1000")
        curve, even = (rig["volume"] for rig in report["rigs"])
        self.assertEqual(curve["certified"]["no_jump"], 1)
        self.assertGreater(curve["certified"]["share"], 0.9)
        self.assertEqual(even["certified"]["share"], 1)
        for volume in (curve, even):
            poses, clean = volume["searched"]["poses"], volume["searched"]["clean"]
            self.assertGreaterEqual(poses, 20)
            self.assertLessEqual(volume["searched"]["at_least"], clean / poses)
        self.assertEqual(even["searched"]["clean"], even["searched"]["poses"])
        self.assertAlmostEqual(even["searched"]["at_least"], 0.05 ** (1 / even["searched"]["poses"]), places=9)
        self.assertLess(curve["searched"]["clean"], curve["searched"]["poses"])
        self.assertIn("random poses clean (95 % sure: at least", " ".join(told.split()))

    def test_what_a_nights_boxes_are_too_few_for_is_said(self):
        suite = self.folder / "night.toml"
        suite.write_text(suite.read_text().replace('system = "curve"', 'system = "stretchy"'))
        report, _ = self.night("run", "--hunt-percent", "100", code=1)
        stretchy = report["rigs"][0]["volume"]
        self.assertIsNone(stretchy["certified"])
        self.assertIn("stretchy", stretchy["not_certified"])

    def test_a_share_that_is_none_is_refused(self):
        self.write("night.toml", self.TEXT + "[hunt]\npercent = -5\n")
        self.assert_refused("nightly", "night.toml", "--quick", "-o", "run", names=["night.toml:26", "percent"])
        self.write("night.toml", self.TEXT)
        self.assert_refused("nightly", "night.toml", "-o", "run", "--hunt-percent", "-1", code=USAGE, names=["--hunt-percent"])


class LiveHunt(RigTest, CommandTest):
    def test_a_flip_of_a_running_rig_is_found_from_both_its_sides(self):
        # Beyond this twist one joint stays turned: no slope leads there, but poses on both sides do.
        hunt = json.loads(self.assert_runs("hunt", self.rig("--flip", "twist=41.2345:30"), "--character", self.body,
                                           "--chest", "neck", "--envelope", "human", "--evaluations", "400",
                                           "--check", "BB001", "--json", "-q", code=1).stdout)
        flips = [find for find in hunt["findings"] if find["code"] == "BB001"]
        self.assertTrue(flips)
        for find in flips:
            low, high = sorted((find["from"].get("twist", 0), find["pose"].get("twist", 0)))
            self.assertTrue(low <= 41.2345 <= high, find)
            self.assertEqual(find["owner"].upper(), "RIG")
            self.assertAlmostEqual(find["value"], 30, delta=0.1)
