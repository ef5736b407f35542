"""backbend history, approve and report: one bad rig over several nights, from its first run to the
ratchet that lets it pass and the night on which it gets worse."""

import json
import pathlib
import tempfile
import unittest

from harness import BAD_INPUT, CommandTest, USAGE, contents, human, run_backbend

HUMAN = human()
NO_BASELINE = 6
FINDINGS = 1
CHECK = ("check", HUMAN, "--quick", "--rig", "three_bone")


class OneBadRig(unittest.TestCase):
    """A run that fails, looked at from all sides; every test works on a copy of nothing but files."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend nights ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.result = run_backbend([*CHECK, "-o", "run", "--history", "nights.jsonl", "--label", "v001"], cls.folder)
        cls.report = json.loads((cls.folder / "run/report.json").read_text())
        cls.failures = [f for f in cls.report["findings"] if f["verdict"] == "fail" and f["rig"] == "three_bone"]

    def backbend(self, *arguments, code=0):
        result = run_backbend(arguments, self.folder)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}\n{result.stderr}")
        return result

    def test_the_run_fails_and_is_the_first_night(self):
        self.assertEqual(self.result.returncode, FINDINGS, self.result.stderr)
        self.assertIn("Judging the RIG and the WEIGHTS of human", self.result.stdout.splitlines()[0])
        self.assertTrue(self.failures)
        (night,) = [json.loads(line) for line in (self.folder / "nights.jsonl").read_text().splitlines()]
        self.assertEqual(night["label"], "v001")
        self.assertEqual(self.report["nights"], [night["date"] + " v001"])
        self.assertEqual({f["code"] for f in night["failures"]}, {f["code"] for f in self.failures})

    def test_the_history_is_shown_within_any_width_and_as_json(self):
        self.assertIn("1 nights", self.backbend("history", "--file", "nights.jsonl").stdout)
        shown = json.loads(self.backbend("history", "--file", "nights.jsonl", "--json").stdout)
        self.assertEqual(len(shown["trends"]), len(self.report["trends"]))
        one = self.backbend("history", "--file", "nights.jsonl", "--metric", "chain_kink").stdout
        self.assertIn("*", one)

    def test_the_index_is_made_again_where_it_is_gone_or_damaged_and_says_the_same(self):
        copy, index = self.folder / "kept.jsonl", self.folder / "kept.jsonl.index"
        copy.write_bytes((self.folder / "nights.jsonl").read_bytes())
        first = self.backbend("history", "--file", "kept.jsonl", "--json").stdout
        self.assertTrue(index.read_bytes().startswith(b"SQLite format 3"))
        whole = index.read_bytes()
        for damage in (b"", b"no database", whole[:5000], whole[:4096] + b"\xff" * (len(whole) - 4096)):
            index.write_bytes(damage)
            self.assertEqual(self.backbend("history", "--file", "kept.jsonl", "--json").stdout, first)
        index.unlink()
        self.assertEqual(self.backbend("history", "--file", "kept.jsonl", "--json").stdout, first)
        self.backbend("history", "--file", "kept.jsonl", "--add", "run", "--date", "2099-01-01", "--label", "v002")
        grown = json.loads(self.backbend("history", "--file", "kept.jsonl", "--json").stdout)
        self.assertEqual(len(grown["nights"]), 2)
        self.assertEqual(copy.read_bytes().count(b"\n"), 2)

    def test_the_version_where_it_began_is_named(self):
        code = self.failures[0]["code"]
        shown = self.backbend("history", "--file", "nights.jsonl", "--first-bad", "human", code).stdout
        self.assertIn("v001", shown)
        self.assertIn(self.report["characters"][0]["hash"], shown)
        self.assertIn("never failed", self.backbend("history", "--file", "nights.jsonl", "--first-bad", "human", "BB000").stdout)
        wrong = self.backbend("history", "--file", "nights.jsonl", "--first-bad", "humann", code, code=USAGE)
        self.assertIn("did you mean 'human'", wrong.stderr)

    def test_a_night_is_added_once_and_damage_is_refused_by_line(self):
        before = (self.folder / "nights.jsonl").read_bytes()
        copy = self.folder / "copy.jsonl"
        copy.write_bytes(before)
        added = ("history", "--file", "copy.jsonl", "--add", "run", "--date", "2099-01-01", "--label", "v002")
        self.backbend(*added)
        self.backbend(*added)
        lines = copy.read_bytes().splitlines(keepends=True)
        self.assertEqual(len(lines), 2)
        self.assertEqual(lines[0], before)
        copy.write_bytes(before + lines[1][:100])
        torn = copy.read_bytes()
        for arguments in (added, ("history", "--file", "copy.jsonl"), (*CHECK, "-o", "never", "--history", "copy.jsonl")):
            self.assertIn("copy.jsonl:2: ", self.backbend(*arguments, code=BAD_INPUT).stderr)
        self.assertEqual(copy.read_bytes(), torn)
        self.assertFalse((self.folder / "never").exists(), "a damaged history is said before the work")

    def test_what_is_approved_passes_until_its_day_and_nothing_else_does(self):
        self.backbend("approve", "--run", "run", "--author", "lead", "--reason", "show start", "--until", "2099-12-31", "--baseline", "base.json")
        approved = json.loads((self.folder / "base.json").read_text())["approvals"]
        may = [f for f in self.failures if not (f["code"] == "BB001" and f["inside_envelope"])]
        self.assertEqual(len(approved), len(may))
        run_backbend([*CHECK, "-o", "again", "--baseline", "base.json"], self.folder)
        again = json.loads((self.folder / "again/report.json").read_text())
        left = [f for f in again["findings"] if f["verdict"] == "fail" and f["rig"] == "three_bone"]
        self.assertEqual(len(left), len(self.failures) - len(may))
        waived = [f for f in again["findings"] if f["verdict"] == "waived"]
        self.assertEqual(len(waived), len(may))
        self.assertIn("until 2099-12-31 by lead: show start", waived[0]["detail"])

    def test_a_baseline_that_is_not_there_has_an_exit_code_of_its_own(self):
        self.assertIn("gone.json", self.backbend(*CHECK, "-o", "never", "--baseline", "gone.json", code=NO_BASELINE).stderr)

    def test_approvals_of_another_run_are_refused_and_change_nothing(self):
        page = (self.folder / "run/index.html").read_text()
        start = page.index('id="hashes">') + len('id="hashes">')
        hashes = json.loads(page[start:page.index("</script>", start)])
        first = self.report["findings"].index(self.failures[0])
        good = {"schema": "backbend.approvals/1", "report": hashes["report"], "suite": "check", "author": "lead",
                "reason": "seen", "until": "", "cases": [{"finding": first, "hash": hashes["findings"][first]}]}
        wrong = {"stale": {**good, "report": "0" * 32}, "no such finding": {**good, "cases": [{"finding": 99999, "hash": "x"}]},
                 "wrong hash": {**good, "cases": [{"finding": first, "hash": "0" * 32}]}, "reason": {**good, "reason": ""},
                 "damaged": {"schema": "backbend.approvals/1"}}
        for word, document in wrong.items():
            (self.folder / "approvals.json").write_text(json.dumps(document))
            before = contents(self.folder)
            told = self.backbend("approve", "approvals.json", "--run", "run", "--baseline", "page.json", code=BAD_INPUT)
            self.assertIn(word, told.stderr)
            self.assertEqual(contents(self.folder), before)
        (self.folder / "approvals.json").write_text(json.dumps(good))
        self.backbend("approve", "approvals.json", "--run", "run", "--baseline", "page.json")
        (approved,) = json.loads((self.folder / "page.json").read_text())["approvals"]
        self.assertEqual((approved["code"], approved["author"], approved["reason"]), (self.failures[0]["code"], "lead", "seen"))

    def test_the_report_is_written_again_byte_for_byte(self):
        self.backbend("report", "run/report.json", "-o", "twice")
        for name in ("report.json", "index.html", "junit.xml", "report.md", "findings.csv", "headline.txt"):
            self.assertEqual((self.folder / "run" / name).read_bytes(), (self.folder / "twice" / name).read_bytes(), name)


class Pruning(CommandTest):
    """Five runs; the two newest stay whole, and what no run made is never touched."""

    def setUp(self):
        super().setUp()
        for day in (1, 2, 3, 4, 5):
            for name in ("report.json", "index.html", "findings/x/a.exr", "frames/f.png", "media/m.mp4", "review/r.mp4", "mine.txt"):
                self.write(f"runs/2026-11-0{day}_031500/{name}", "x" * 1000)
        self.write("runs/keep me/frames/f.png", "mine")
        self.write("runs/2026-11-01_notes/frames/f.png", "mine")
        (self.folder / "runs/latest").symlink_to("2026-11-01_031500")
        (self.folder / "runs/2026-11-02_031500/meshes").symlink_to(self.folder / "runs/keep me")

    def test_old_pictures_go_and_everything_else_stays(self):
        before = contents(self.folder)
        self.assertIn("2026-11-03_031500", self.assert_runs("prune", "--keep", "2", "--dry-run").stdout)
        self.assertEqual(contents(self.folder), before)
        self.assert_runs("prune", "--keep", "2")
        gone = set(before) - set(contents(self.folder))
        want = {f"runs/2026-11-0{day}_031500/{name}" for day in (2, 3)
                for name in ("findings", "findings/x", "findings/x/a.exr", "frames", "frames/f.png", "media", "media/m.mp4", "review", "review/r.mp4")}
        self.assertEqual(gone, want)

    def test_a_missing_folder_is_named(self):
        self.assert_refused("prune", "gone", names=["gone"])


class Refusals(CommandTest):
    def test_a_file_without_a_name_is_a_mistake_of_usage(self):
        for option in ("--history", "--baseline"):
            nameless = self.backbend(*CHECK, "-o", "run", option, "")
            self.assertEqual(nameless.returncode, USAGE)
            self.assertIn("expected a file's name", nameless.stderr)

    def test_wrong_days_and_missing_runs_are_named(self):
        self.assert_refused("history", "--add", "gone", names=["gone"])
        self.assert_refused("approve", "--run", "gone", "--reason", "x", names=["gone"])
