"""`backbend tune`: a rig's options searched for headroom; what it writes is a rig that check takes."""

import json
import signal
import subprocess
import time

from harness import BACKBEND, CANNOT_WRITE, CommandTest, USAGE, bare_environment, contents, human

FEW = ("--evaluations", "30", "--vary", "arms,bones=6:14")


class Tune(CommandTest):
    def setUp(self):
        super().setUp()
        self.write("hero.glb", human(1500).read_bytes())

    def tune(self, *words, **options):
        return json.loads(self.assert_runs("tune", *words, "--for", "hero.glb", "--json", "-q", **options).stdout)

    def failures(self, rig):
        report = json.loads(self.backbend("check", "hero.glb", "--rig", rig, "--quick", "--json", "-o", "run").stdout)
        return sum(f["verdict"] == "fail" for f in report["findings"])

    def test_the_written_rig_has_more_headroom_and_check_takes_it(self):
        told = self.tune("curve", *FEW, "-o", "better.toml", "--no-picture")
        chosen = told["choices"][told["chosen"] - 1]
        self.assertGreater(chosen["headroom"], told["given"]["headroom"])
        self.assertLessEqual(chosen["change_percent"], 5)
        self.assertEqual(chosen["new_failures"], [])
        # Arms that drift on the end of the chain do not on the control.
        self.assertEqual(chosen["options"]["arms"], "top")
        text = (self.folder / "better.toml").read_text()
        self.assertIn('system = "curve"', text)
        self.assertIn('arms = "top"', text)
        self.assertLess(self.failures("better.toml"), self.failures("curve"))

    def test_choices_are_a_front_each_with_more_headroom_for_more_change(self):
        told = self.tune("curve:length=rest", "--evaluations", "60", "--vary", "length,bones,arms,roll", "-o", "r.toml",
                         "--no-picture")
        choices = told["choices"]
        self.assertGreater(len(choices), 1)
        for one, other in zip(choices, choices[1:]):
            self.assertLess(one["change_percent"], other["change_percent"])
            self.assertLess(one["headroom"], other["headroom"])
        self.assertLessEqual(told["evaluations"] + told["refused"], 60 + 1)
        self.assertEqual(told["given"]["change_percent"], 0)

    def test_threads_change_nothing(self):
        for threads in ("1", "3"):
            self.tune("curve", *FEW, "--threads", threads, "-o", f"{threads}.toml")
        one, three = ((self.folder / f"{n}.toml") for n in "13")
        self.assertEqual(one.read_bytes(), three.read_bytes())
        sheets = [(self.folder / f"{n}_choices.png").read_bytes() for n in "13"]
        self.assertEqual(sheets[0], sheets[1])
        self.assertTrue(sheets[0].startswith(b"\x89PNG"))

    def test_for_a_person_it_prints_the_trade_and_says_what_it_wrote(self):
        done = self.assert_runs("tune", "curve", *FEW, "--for", "hero.glb", "-o", "out/rig.toml", "--no-picture")
        self.assertRegex(done.stdout, r"varied +arms: effector \| top")
        self.assertRegex(done.stdout, r"given +\d+ % +0 % ")
        self.assertRegex(done.stdout, r"\n  1 \* +\d+ % ")
        self.assertIn("wrote out/rig.toml", done.stderr)

    def test_options_that_change_nothing_are_told_and_left_alone(self):
        told = self.tune("even", "--dry-run")
        self.assertIn("minutes", told)
        told = self.tune("curve", "--evaluations", "40", "-o", "r.toml", "--no-picture")
        self.assertIn("knots", told["idle"])  # of another basis
        self.assertNotIn("knots", [axis["option"] for axis in told["varied"]])

    def test_a_rig_that_cannot_be_bettered_is_left_as_it_is(self):
        done = self.assert_runs("tune", "curve:arms=top,bones=10", "--vary", "bones=10:11", "--evaluations", "20",
                                "--for", "hero.glb", "-o", "r.toml", "--no-picture")
        self.assertIn("the given one stays", done.stdout)
        self.assertIn("no rig file was written", done.stderr)
        self.assertFalse((self.folder / "r.toml").exists())

    def test_a_dry_run_writes_nothing(self):
        before = contents(self.folder)
        text = self.assert_runs("tune", "curve", *FEW, "--for", "hero.glb", "--dry-run").stdout
        self.assertIn("nothing was searched or written", text)
        self.assertEqual(contents(self.folder), before)

    def test_explain_names_the_command_for_checks_of_the_solver(self):
        self.assertIn("backbend tune RIG --for CHARACTER -o RIG.toml", self.assert_runs("explain", "BB020").stdout)
        self.assertNotIn("backbend tune", self.assert_runs("explain", "BB064").stdout)

    def test_findings_of_the_solver_name_the_command_and_it_runs(self):
        report = json.loads(self.backbend("check", "hero.glb", "--rig", "curve", "--quick", "--json", "-o", "run").stdout)
        ours = [f["cures"] for f in report["findings"] if f["owner"] == "SOLVER" and f["verdict"] == "fail"]
        self.assertEqual({cures[0]["command"] for cures in ours}, {"backbend tune curve --for hero.glb -o curve_tuned.toml"})
        told = self.assert_runs(*ours[0][0]["command"].split()[1:], "--dry-run")
        self.assertIn("arms", told.stdout)
        self.assertFalse((self.folder / "curve_tuned.toml").exists())
        # What `even` passes in the same pose is cured by taking it, with the headroom that it has here.
        native = [cure for cures in ours for cure in cures if "export" in cure["command"]]
        self.assertTrue(native)
        beside = report["rigs"][0]["beside"][0]
        self.assertEqual(beside["system"], "even")
        extension = next(h for h in beside["headroom"] if h["channel"] == "extension")
        self.assertIn(f"extension {extension['clean_to_deg']:.0f}+", native[0]["gives"])
        self.assert_runs(*native[0]["command"].split()[1:])
        self.assertEqual(len(list(self.folder.glob("*_even.py"))), 1)

    def test_it_stops_when_asked_and_leaves_nothing(self):
        before = contents(self.folder)
        running = subprocess.Popen([str(BACKBEND), "tune", "even", "--for", "hero.glb", "-o", "r.toml", "--evaluations",
                                    "100000"], cwd=self.folder, env=bare_environment(self.folder),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(1.5)
        running.send_signal(signal.SIGINT)
        self.assertEqual(running.wait(60), 130)
        self.assertEqual(contents(self.folder), before)

    def test_what_cannot_be_tuned_is_refused(self):
        out = ("--for", "hero.glb", "-o", "r.toml")
        self.assert_refused("tune", "curve", "--for", "hero.glb", code=USAGE, names=["-o RIG.toml"])
        self.assert_refused("tune", "curve", "--for", "hero.glb", "-o", "r.json", code=USAGE, names=["r.json", ".toml"])
        self.assert_refused("tune", "curve", "--vary", "boness", *out, code=USAGE, names=["boness", "bones"])
        self.assert_refused("tune", "curve", "--vary", "bones=9:4", *out, code=USAGE, names=["bones=9:4"])
        self.assert_refused("tune", "curve", "--vary", "bones=1:99", *out, code=USAGE, names=["1 to 64"])
        self.assert_refused("tune", "three_bone", *out, names=["nothing to tune"])
        self.assert_refused("tune", "curv", *out, names=["curv", "curve"])
        self.assert_refused("tune", "command:true", *out, names=["a rig of your own"])
        self.assert_refused("tune", "curve", "--for", "gone.glb", "-o", "r.toml", names=["gone.glb"])
        self.write("broken.glb", b"glTF")
        self.assert_refused("tune", "curve", "--for", "broken.glb", "-o", "r.toml", names=["broken.glb"])
        self.write("rig.toml", '[rig]\nsystem = "curve"\nbones = 999\n')
        self.assert_refused("tune", "rig.toml", *out, names=["bones", "1 to 64"])
        self.assert_refused("tune", "rig.toml", "--for", "hero.glb", "-o", "rig.toml", code=USAGE, names=["rig.toml", "input"])
        self.assert_refused("tune", "curve", "--evaluations", "5", *out, code=USAGE, names=["--evaluations"])
        (self.folder / "file").write_text("x")
        self.assert_refused("tune", "curve", "--for", "hero.glb", "-o", "file/r.toml", code=CANNOT_WRITE, names=["file"])
