"""Proofs over whole boxes of poses, their certificates, and what is refused."""

import json
import signal
import subprocess
import time

from harness import BACKBEND, BAD_INPUT, CommandTest, USAGE, human


def interrupted(folder, *words):
    """Exit code and stderr of a command that is interrupted soon after its start."""
    running = subprocess.Popen([str(BACKBEND), *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True)
    time.sleep(0.3)
    running.send_signal(signal.SIGINT)
    said = running.communicate(timeout=120)[1]
    return running.returncode, said


class Prove(CommandTest):
    def test_even_is_certified_and_its_certificate_holds(self):
        told = self.assert_runs("prove", "even", "--json", "-o", "even.json")
        proof = json.loads(told.stdout)
        self.assertEqual(proof["schema"], "backbend.proof/1")
        self.assertEqual((proof["certified"], proof["open"], proof["refuted"]), (1.0, 0.0, []))
        self.assertLess(proof["gain_bound"], 1.00000001)
        self.assertIn("even.json holds", self.assert_runs("prove", "--check", "even.json").stdout)
        checked = json.loads(self.assert_runs("prove", "even", "--check", "even.json", "--json").stdout)
        self.assertTrue(checked["holds"])
        self.assert_refused("prove", "isner", "--check", "even.json", code=BAD_INPUT, names=["even.json", "isner"])

    def test_even_with_limits_or_reach_is_certified_with_the_gain_of_its_theorem(self):
        for rig, least, most in (("even:limits=human", 1.9, 2.00001), ("even:reach=0.5", 5.5, 5.7)):
            proof = json.loads(self.assert_runs("prove", rig, "--json", "-o", "even.json").stdout)
            self.assertEqual(proof["certified"], 1.0, rig)
            self.assertTrue(least < proof["gain_bound"] < most, proof["gain_bound"])
            if "limits" in rig:
                self.assertIn("even.json holds", self.assert_runs("prove", "--check", "even.json").stdout)
            else:
                self.assert_refused("prove", "--check", "even.json", code=BAD_INPUT, names=["reach"])
        # No smaller box has a lower bound: it stays open at one look, proved not to jump.
        steep = json.loads(self.assert_runs("prove", "even:reach=1", "--json", code=5).stdout)
        self.assertEqual((steep["boxes"]["looked_at"], steep["open"], steep["no_jump"]), (1, 1.0, 1.0))

    def test_a_flip_is_shown_with_its_pose(self):
        told = self.backbend("prove", "isner", "--box", "extension=90:120,side=0,twist=0", "--smallest", "0.01")
        self.assertEqual(told.returncode, 1, told.stderr)
        for flip in ("100.8696", "114.27445", "116.23568"):
            self.assertIn("at extension " + flip, told.stdout)
        self.assertIn("jumps by 180 deg", told.stdout)

    def test_a_stopped_search_goes_on_to_the_same_certificate(self):
        question = ["prove", "isner", "--box", "extension=0:60,side=-20:20,twist=-20:20", "--threads", "1"]
        whole = self.backbend(*question, "-o", "whole.json")
        self.assertEqual(whole.returncode, 0, whole.stderr)
        stopped, said = interrupted(self.folder, *question, "-o", "parts.json")
        if stopped == 130:  # else it was done before
            self.assertIn("--resume", said)
            self.assert_refused("prove", "--check", "parts.json", code=BAD_INPUT, names=["parts.json", "--resume"])
            again = self.backbend(*question, "-o", "parts.json", "--resume")
            self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.folder / "parts.json").read_text(), (self.folder / "whole.json").read_text())
        self.assert_refused("prove", "isner", "--box", "sweep", "-o", "whole.json", "--resume", code=BAD_INPUT,
                            names=["whole.json", "box"])

    def test_what_cannot_be_proved_is_refused_by_name(self):
        for rig, reason in (("snake:lead=0.5", "lead"), ("curve:roll=full", "full"), ("stretchy:lead=0.5", "lead"), ("neck:limits=[10,10,10,10]", "limits"), ("isner:slerp=raw", "raw"),
                            ("command:true", "backbend hunt")):
            self.assert_refused("prove", rig, code=BAD_INPUT, names=[reason])
        for box, reason in (("extension=10:0", "10"), ("extension=5", "empty"), ("extension=0:inf", "finite"),
                            ("nosuch", "nosuch")):
            self.assert_refused("prove", "--box", box, code=BAD_INPUT, names=[reason])
        self.assert_refused("prove", "snake", "--box", "slide=0:1", code=BAD_INPUT, names=["slide"])
        wrong = self.write("box.toml", "[box]\nextension = [0, 10, 20]\n")
        self.assert_refused("prove", "--box", wrong, code=BAD_INPUT, names=["box.toml:2"])
        self.assert_refused("prove", "--resume", code=USAGE, names=["-o"])
        self.assert_refused("prove", "--check", "none.json", code=BAD_INPUT, names=["none.json"])
        self.write("cut.json", '{"schema": "backbend.certif')
        self.assert_refused("prove", "--check", "cut.json", code=BAD_INPUT, names=["cut.json"])


class Bounds(CommandTest):
    BOX = ["--box", "extension=-80:50,side=-30:30"]

    def test_limits_of_the_skin_hold_at_every_pose_of_a_healthy_rig(self):
        told = self.assert_runs("prove", "even", "--character", human(), "--bound", "BB030", "--bound", "BB033=0",
                                *self.BOX, "--json")
        proof = json.loads(told.stdout)
        self.assertEqual((proof["schema"], proof["character"]), ("backbend.bounds/1", "human"))
        area, inverted = proof["claims"]
        self.assertEqual((area["check"], area["sense"], area["limit"]), ("BB030", "at least", 0.75))
        self.assertEqual((inverted["check"], inverted["limit"], inverted["bound"]), ("BB033", 0.0, 0.0))
        for claim in (area, inverted):
            self.assertEqual((claim["certified"], claim["refuted_share"], claim["open"]), (1.0, 0.0, 0.0))
        self.assertTrue(0.75 <= area["bound"] < 1.0)
        # More threads, the same text.
        again = self.assert_runs("prove", "even", "--character", human(), "--bound", "BB030", "--bound", "BB033=0",
                                 *self.BOX, "--json", "--threads", "1")
        self.assertEqual(again.stdout, told.stdout)

    def test_a_limit_that_breaks_is_shown_with_its_pose(self):
        told = self.backbend("prove", "isner", "--bound", "BB020", "--bound", "BB041=30", *self.BOX)
        self.assertEqual(told.returncode, 1, told.stderr)
        self.assertIn("BB020 arm drift, rotation, at most 0.5 deg", told.stdout)
        self.assertRegex(told.stdout, r"worst measured [0-9.]+ deg at (extension|flexion) ")
        self.assertIn("x refuted", told.stdout)
        self.assertIn("BB041 end gap, at most 30 % of spine\n  certified  100 %", told.stdout)

    def test_kinks_of_a_chain_on_its_curve_are_bounded_over_the_whole_envelope(self):
        for rig in ("isner", "curve", "neck", "matrix_blend:pivot_pos=0"):
            told = self.assert_runs("prove", rig, "--bound", "BB010")
            self.assertRegex(told.stdout, r"BB010 chain kink, at most 2 deg\n  certified  100 % of the box: at most [012]")

    def test_what_has_no_bound_is_refused_by_name(self):
        for bound, names in (("BB011", ["BB011", "BB030"]), ("BB030", ["BB030", "--character"]),
                             ("BB047=-1", ["BB047=-1"]), ("BB047=x", ["BB047=x"]), ("BB047=", ["BB047="])):
            self.assert_refused("prove", "even", "--bound", bound, code=BAD_INPUT, names=names)
        self.assert_refused("prove", "even:reach=0.5", "--bound", "BB047", code=BAD_INPUT, names=["reach"])
        self.assert_refused("prove", "even", "--bound", "BB047", "--box", "top.rz=0:10", code=BAD_INPUT,
                            names=["body channels"])
        self.assert_refused("prove", "even", "--bound", "BB047", "--resume", code=USAGE, names=["-o"])

    def test_a_stopped_search_goes_on_where_it_was(self):
        question = ("prove", "isner", "--bound", "BB020", "--bound", "BB041=30", "--smallest", "0.5",
                    "--box", "extension=-20:20,side=-15:15")
        whole = self.backbend(*question, "-o", "whole.json")
        self.assertEqual(whole.returncode, 1, whole.stderr)
        stopped, said = interrupted(self.folder, *question, "-o", "parts.json")
        if stopped == 130:  # else it was done before
            self.assertIn("--resume", said)
        again = self.backbend(*question, "-o", "parts.json", "--resume")
        self.assertEqual((again.returncode, again.stdout), (1, whole.stdout), again.stderr)
        self.assertEqual((self.folder / "parts.json").read_text(), (self.folder / "whole.json").read_text())
        self.assert_refused(*question, "--mapping", "spread", "-o", "parts.json", "--resume", code=BAD_INPUT,
                            names=["parts.json", "mapping"])
