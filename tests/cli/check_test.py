"""backbend check: the answer on stdout, the run folder, and that they say the same."""

import concurrent.futures
import json
import pathlib
import tempfile
import unittest

import glb
from harness import CommandTest, SOURCE, character, contents, human, run_backbend

HUMAN = SOURCE / "scenes/characters/human.toml"


class CheckingTheBundledHuman(unittest.TestCase):
    """One run without pictures, looked at from all sides."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend check ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.result = run_backbend(["check", HUMAN, "--quick"], cls.folder)
        runs = cls.folder / "runs"
        cls.run_folder = runs / "latest"
        cls.report = json.loads((cls.run_folder / "report.json").read_text())

    def test_the_exit_code_is_the_reports(self):
        self.assertEqual(self.result.returncode, self.report["exit_code"], self.result.stderr)
        self.assertIn(self.result.returncode, (0, 1, 5))

    def test_the_first_line_says_what_is_judged(self):
        first = self.result.stdout.splitlines()[0]
        for word in ("Judging the WEIGHTS", "human", "even", "--baked CLIP"):
            self.assertIn(word, first)

    def test_every_pose_is_accounted_for(self):
        rows = [row for rig in self.report["rigs"] for row in rig["coverage"]]
        self.assertTrue(rows)
        for row in rows:
            self.assertEqual(row["planned"], row["measured"] + row["not_measured"] + row["not_applicable"], row)

    def test_headroom_is_given_for_every_channel(self):
        proposed = [rig for rig in self.report["rigs"] if rig["role"] == "proposed"]
        self.assertEqual(len(proposed), 1)
        self.assertEqual({row["channel"] for row in proposed[0]["headroom"]},
                         {"extension", "flexion", "side", "twist"})
        for channel in ("extension", "flexion", "side", "twist"):
            self.assertIn(channel, self.result.stdout)

    def test_the_canary_did_its_duty(self):
        self.assertTrue(self.report["canaries"])
        for canary in self.report["canaries"]:
            self.assertTrue(canary["ok"], canary)

    def test_every_finding_has_a_code_that_explain_knows(self):
        for code in {finding["code"] for finding in self.report["findings"]}:
            told = run_backbend(["explain", code], self.folder)
            self.assertEqual(told.returncode, 0, told.stderr)
            self.assertIn(code, told.stdout)

    def test_the_page_is_there_and_is_named(self):
        page = [word for word in self.result.stdout.split() if word.endswith("index.html")]
        self.assertEqual(len(page), 1, self.result.stdout)
        self.assertTrue((self.folder / page[0]).is_file())
        self.assertTrue((self.run_folder / "index.html").samefile(self.folder / page[0]))

    def test_only_the_run_folder_is_written_and_nothing_half(self):
        self.assertEqual([path.name for path in self.folder.iterdir()], ["runs"])
        self.assertEqual(len(list((self.folder / "runs").iterdir())), 2)  # the run, and `latest`
        self.assertEqual([p for p in self.folder.rglob("*") if ".tmp-" in p.name], [])

    def test_colour_stays_away_from_a_pipe(self):
        self.assertNotIn("\x1b", self.result.stdout)


class CheckingAgain(CommandTest):
    def test_the_same_bytes_for_any_thread_count_locale_and_folder(self):
        def folder_of(name, *more, **options):
            result = self.backbend("check", HUMAN, "--quick", "-o", self.folder / name, *more, **options)
            self.assertIn(result.returncode, (0, 1, 5), result.stderr)
            return contents(self.folder / name)

        first = folder_of("a")
        self.assertIn("report.json", first)
        self.assertEqual(folder_of("b", "--threads", "1"), first)
        self.assertEqual(folder_of("c", environment={"LC_ALL": "de_DE.UTF-8", "TZ": "Asia/Kolkata"}), first)

    def test_json_is_the_report_and_stdout_holds_nothing_else(self):
        result = self.backbend("check", human(1500), "--quick", "--json", "-o", "out")
        self.assertIn(result.returncode, (0, 1, 5), result.stderr)
        self.assertEqual(json.loads(result.stdout), json.loads((self.folder / "out/report.json").read_text()))

    def test_runs_that_start_in_one_second_take_a_folder_each(self):
        body = human(1500)
        with concurrent.futures.ThreadPoolExecutor(6) as pool:
            runs = list(pool.map(lambda _: self.backbend("check", body, "--quick", "--threads", "1"), range(6)))
        for run in runs:
            self.assertIn(run.returncode, (0, 1, 5), run.stderr)
        folders = [path for path in (self.folder / "runs").iterdir() if not path.is_symlink()]
        self.assertEqual(len(folders), 6)
        for folder in folders:
            self.assertTrue((folder / "report.json").is_file())

    def test_quiet_says_nothing_on_stderr(self):
        result = self.backbend("check", human(1500), "--quick", "--quiet", "-o", "out")
        self.assertEqual(result.stderr, "")


class WhatTheEnvelopeNeeds(CommandTest):
    SUITE = """[suite]
characters = ["human.glb"]
envelope = "creature"
corners = %s
[[rig]]
solver = { system = "even" }
[[sweep]]
channel = "side"
from = %d
to = %d
step = 15
"""

    def check(self, *words):
        self.backbend("check", human(1500), "--quick", "-o", "out", *words)
        return json.loads((self.folder / "out/report.json").read_text())

    def proposed(self, report):
        return next(rig for rig in report["rigs"] if rig["role"] == "proposed")

    def test_every_channel_is_swept_to_the_end_of_the_envelope(self):
        for name, needs in (("creature", {"extension": 45, "flexion": 60, "side": 60, "twist": 45}),
                            ("cartoon", {"extension": 120, "flexion": 120, "side": 75, "twist": 120})):
            rig = self.proposed(self.check("--envelope", name))
            for row in rig["headroom"]:
                self.assertEqual(row["needs_deg"], needs[row["channel"]])
                self.assertGreaterEqual(row["tested_to_deg"], row["needs_deg"] - 1e-9, row)
            self.assertTrue(rig["corners"]["needed"])
            self.assertGreaterEqual(rig["corners"]["poses"], 200)

    def test_the_kind_of_body_chooses_it_and_says_why(self):
        facts = self.check()["characters"][0]
        self.assertEqual((facts["kind"], facts["envelope"]), ("human", "human"))
        self.assertIn("upright", facts["envelope_reason"])
        shown = self.backbend("check", SOURCE / "scenes/characters/snake.toml", "--quick", "-o", "snake").stdout
        self.assertIn("envelope 'snake' (no arms and no legs", shown)

    def test_what_no_sweep_reaches_is_not_measured_and_no_pass(self):
        (self.folder / "human.glb").write_bytes(human(1500).read_bytes())
        self.write("short.toml", self.SUITE % ("true", -45, 45))
        result = self.backbend("nightly", "short.toml", "--quick", "-o", "short")
        report = json.loads((self.folder / "short/report.json").read_text())
        self.assertEqual((result.returncode, report["verdict"]), (5, "not_measured"), result.stdout)
        shown = " ".join(result.stdout.split())  # however its lines are broken
        self.assertIn("side to 60, measured to 45", shown)
        self.assertIn("twist to 45, not measured", shown)
        self.assertNotIn(" 0 not measured", result.stdout)

    def test_nor_is_what_goes_one_way_only(self):
        (self.folder / "human.glb").write_bytes(human(1500).read_bytes())
        self.write("half.toml", self.SUITE % ("false", 0, 60))
        result = self.backbend("nightly", "half.toml", "--quick", "-o", "half")
        self.assertEqual(result.returncode, 5, result.stdout)
        shown = " ".join(result.stdout.split())
        self.assertIn("side to 60, measured to 0", shown)
        self.assertIn("its corners, not measured", shown)


class Explaining(CommandTest):
    def test_knows_every_word_that_reports_use(self):
        for word in ("SOLVER", "RIG", "MOTION", "WEIGHTS", "SKELETON", "POSE", "INPUT", "TOOL", "envelope", "headroom",
                     "corners", "mapping", "proxy weights", "proxy_weights", "Envelope"):
            result = self.assert_runs("explain", word)
            self.assertIn("means", result.stdout)
        wrong = self.backbend("explain", "envelop")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("did you mean 'envelope'", wrong.stderr)

    def test_knows_the_limit_of_every_kind_of_input(self):
        told = self.assert_runs("explain", "BB010").stdout
        self.assertIn("at most 2 deg", told)
        self.assertIn("at most 30 deg", told)
        checks = json.loads(self.assert_runs("list", "checks", "--json").stdout)
        kink = next(check for check in checks if check["code"] == "BB010")
        self.assertEqual((kink["limit"], kink["clip_limit"], kink["sense"]), (2, 30, "at most"))


class WhatNothingMoves(CommandTest):
    def notes(self, apart):
        """Of a check of a tube whose last joint hangs from the chain's, or stands a metre beside it."""
        names = [*glb.HUMAN, "other"]
        last = len(names) - 1

        def change(document):
            if apart:
                del document["nodes"][last - 1]["children"]
                document["nodes"][last]["translation"] = [1, 1.6 / len(names) * last, 0]
                document["scenes"][0]["nodes"].append(last)

        def rigid(_, position, joints, weights):
            return position, [joints[weights[1] > 0.5], 0, 0, 0], [1.0, 0.0, 0.0, 0.0]

        (self.folder / "tube.glb").write_bytes(glb.tube(names, change, rigid, rings=25))
        self.backbend("check", "tube.glb", "--chest", "neck", "--quick", "-o", "run")
        notes = json.loads((self.folder / "run/report.json").read_text())["characters"][0]["notes"]
        return [note for note in notes if "that nothing moves" in note]

    def test_is_said_beside_the_verdict(self):
        self.assertEqual(self.notes(apart=False), [])
        self.assertRegex(self.notes(apart=True)[0], r"1 joint, [0-9.]+ % of all weight, that nothing moves: other$")


class CheckingRealCharacters(CommandTest):
    def test_each_healthy_human_passes_with_no_other_argument(self):
        for name in ("mh_male_13k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb"):
            with self.subTest(name):
                result = self.assert_runs("check", character(name), "--quick", "-o", name + ".run")
                self.assertIn("Judging the WEIGHTS of " + name, result.stdout.splitlines()[0])
                self.assertIn("spine", result.stdout)

    def test_one_whose_weights_do_not_sum_to_1_fails_by_that_alone(self):
        self.assert_runs("check", character("cesium_man.glb"), "--quick", "-o", "out", code=1)
        findings = json.loads((self.folder / "out/report.json").read_text())["findings"]
        self.assertEqual({(f["code"], f["owner"]) for f in findings if f["verdict"] == "fail"}, {("BB060", "INPUT")})
