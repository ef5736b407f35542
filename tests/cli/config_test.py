"""Where options get their values: command line, environment, project file, default, in this order; and that
`backbend config` tells which."""

import json
import os
import pathlib
import re

import glb
from harness import BAD_INPUT, SOURCE, USAGE, CommandTest, contents

# Variables of builds, tests and the launcher. An option of such a name would be set by them unasked.
OTHERS = {"BUILD", "CHARACTERS", "CHROMIUM", "FRESH_NAMESPACE", "FUZZ_ROUNDS", "INTERVAL_OPERATIONS", "PROOF_POSES", "PYBLISH", "KILLS", "KILL_STEP", "LONG",
          "LONG_TESTS", "NODE", "PACKAGES", "PRELOAD", "PROJECT", "SHOTS", "TESTS", "TEST_SLOWER"}


class Settings(CommandTest):
    def settings(self, *words, **options):
        """What config --json says: option -> (value, origin), of the commands' one line or file."""
        told = json.loads(self.assert_runs("config", "--json", *words, **options).stdout)
        self.place = {row["option"]: row.get("variable") or (row.get("file"), row.get("line"))
                      for row in told["settings"]}
        self.project = told["project"]
        return {row["option"]: (row["value"], row["origin"]) for row in told["settings"]}

    def test_the_command_line_counts_before_the_environment_before_the_project(self):
        file = self.write("backbend.toml", "spp = 64\nrig = \"isner\"\n[render]\nspp = 32\nres = \"64x48\"\n")
        self.write("hero.glb", glb.tube())
        line = ("render", "hero.glb")
        self.assertEqual(self.settings(*line)["spp"], ("32", "project"))
        self.assertEqual(self.place["spp"], (os.path.realpath(file), 4))
        self.assertEqual(self.settings("turntable", "hero.glb")["spp"], ("64", "project"))
        some = {"BACKBEND_SPP": "8", "BACKBEND_VIEW": ""}
        self.assertEqual(self.settings(*line, environment=some)["spp"], ("8", "environment"))
        self.assertEqual(self.place["spp"], "BACKBEND_SPP")
        given = self.settings(*line, "--spp", "4", environment=some)
        self.assertEqual(given["spp"], ("4", "command line"))
        self.assertEqual(given["rig"], ("isner", "project"))
        self.assertEqual(given["view"], ("profile", "default"))  # an empty variable is none
        self.assertEqual(given["mapping"], ("chest", "default"))
        self.assertEqual(self.settings("--no-project", *line)["rig"], ("even", "default"))

    def test_what_it_tells_is_what_a_command_takes(self):
        self.write("backbend.toml", "[render]\nres = \"48x32\"\nspp = 1\nrig = \"rigs/mine.toml\"\nmode = \"Heat\"\n"
                                    "multipart = true\n")
        self.write("rigs/mine.toml", "[rig]\nsystem = \"three_bone\"\n")
        self.write("hero.glb", glb.tube())
        done = self.assert_runs("render", "hero.glb", "-o", "out")
        self.assertRegex(done.stderr, r"^backbend: .*\brig\b.* from .*/backbend\.toml\n")
        self.assertEqual(done.stdout, "out/hero_mine.exr\nout/hero_mine.png\n")
        self.assertEqual((self.folder / "out/hero_mine.png").read_bytes()[16:24], bytes((0, 0, 0, 48, 0, 0, 0, 32)))
        # The same said on the command line gives the same bytes.
        self.assert_runs("--no-project", "render", "hero.glb", "-o", "said", "--res", "48x32", "--spp", "1",
                         "--rig", "rigs/mine.toml", "--mode", "heat", "--multipart")
        self.assertEqual(contents(self.folder / "said"), contents(self.folder / "out"))

    def test_the_working_folder_changes_nothing_where_a_file_is_named(self):
        self.write("show/backbend.toml", "rig = \"isner\"\n")
        hero = self.write("show/assets/hero.glb", glb.tube())
        self.write("elsewhere/backbend.toml", "rig = \"stretchy\"\n")
        cases = [("render", hero), ("check", hero), ("check", "--baked", hero), ("compare", "curve", "isner", "--character", hero),
                 ("compare", hero, hero)]
        for words in cases:
            with self.subTest(words=words):
                self.settings(*words, cwd=self.folder / "elsewhere")
                self.assertEqual(self.project, os.path.realpath(self.folder / "show/backbend.toml"))
        self.assertEqual(self.settings(hero, cwd=self.folder / "elsewhere")["rig"], ("isner", "project"))
        self.assertEqual(self.settings(cwd=self.folder / "elsewhere")["rig"], ("stretchy", "project"))
        # A word to choose names no file, whatever is called so.
        self.write("elsewhere/slurm/backbend.toml", "spp = 1\n")
        self.assertEqual(self.settings("farm", "slurm", cwd=self.folder / "elsewhere")["spp"][1], "default")

    def test_a_project_may_be_named_and_left_out(self):
        self.write("backbend.toml", "spp = 64\n")
        other = self.write("other.toml", "spp = 3\n")
        spp = lambda *words, **options: self.settings(*words, **options)["spp"][0]
        self.assertEqual(spp("check"), "64")
        self.assertEqual(spp("check", "--project", "other.toml"), "3")
        named = {"BACKBEND_PROJECT": str(other)}
        self.assertEqual(spp("check", environment=named), "3")
        self.assertEqual(spp("check", "--project", "backbend.toml", environment=named), "64")
        self.assertEqual(spp("check", "--no-project", environment=named), "16")
        self.assert_refused("list", "rigs", "--no-project", "--project", "other.toml", code=USAGE)
        self.assert_refused("explain", "BB001", "--project", "none.toml", names=["none.toml"])

    def test_a_value_that_is_not_taken_names_its_place(self):
        self.write("hero.glb", glb.tube())
        for text, *names in (("spp = 0", ":1:", "'spp'"), ("mapping = \"chst\"", ":1:", "'mapping'", "chest"),
                             ("\nrig = \"evn\"", ":2:", "'even'"), ("res = \"12\"", "'res'", "image size"),
                             ("spp = 2.5", ":1:", "'spp'"), ("spq = 4", "'spp'"), ("[rendr]", "'render'"),
                             ("spp = ", ":1:"), ("\xff", ":1:"), ("environment = \"no.hdr\"", "no.hdr")):
            with self.subTest(text=text):
                self.write("backbend.toml", text.encode("latin-1"))
                self.assert_refused("render", "--quiet", "hero.glb", "-o", "out", names=names)
        os.remove(self.folder / "backbend.toml")
        for variable, value, *names in (("SPP", "0"), ("RIG", "evn", "'even'"), ("MAPPING", "chst", "chest"),
                                        ("BURN_IN", "yes", "true or false"), ("THREADS", "many")):
            with self.subTest(variable=variable):
                self.assert_refused("render", "hero.glb", "-o", "out", code=USAGE, names=["BACKBEND_" + variable, *names],
                                    environment={"BACKBEND_" + variable: value})
        self.write("backbend.toml", "spp = 0")
        self.assert_refused("config", names=["backbend.toml:1:"])
        self.assert_runs("list", "rigs")  # shows what is built in
        self.assert_refused("config", "nowhere.glb", code=USAGE, names=["nowhere.glb"])

    def test_a_project_that_is_found_names_nothing_outside_of_its_folder(self):
        (self.folder / "show").mkdir()
        os.symlink(self.folder, self.folder / "show/out")
        for path in ("../elsewhere/history.jsonl", "/elsewhere/history.jsonl", "out/history.jsonl"):
            self.write("show/backbend.toml", f"[nightly]\nhistory = \"{path}\"\n")
            self.assert_refused("nightly", "--dry-run", cwd=self.folder / "show", names=["backbend.toml:2:", "'history'"])
            # One that a person names is a person's word.
            self.settings("nightly", "--project", "show/backbend.toml")
            self.assertEqual(self.place["history"][1], 2)
        self.write("show/backbend.toml", "[nightly]\nhistory = \"records/history.jsonl\"\n")
        told = self.settings("nightly", cwd=self.folder / "show")["history"]
        self.assertEqual(told[0], os.path.realpath(self.folder / "show") + "/records/history.jsonl")

    def test_a_flag_of_the_project_can_be_taken_back(self):
        self.write("backbend.toml", "quick = true\n")
        self.assertEqual(self.settings("check")["quick"], ("on", "project"))
        self.assertEqual(self.settings("check", "--quick=false")["quick"], ("off", "command line"))
        self.assertEqual(self.settings("check", environment={"BACKBEND_QUICK": "false"})["quick"], ("off", "environment"))

    def test_farm_scripts_hold_what_was_taken_and_take_nothing_more(self):
        self.write("backbend.toml", "spp = 3\nquick = true\n[farm]\nbaseline = \"approved.json\"\nsuite = \"show.toml\"\n")
        self.write("hero.glb", glb.tube())
        self.write("show.toml", "[suite]\ncharacters = [\"hero.glb\"]\n[[rig]]\nsolver = { system = \"even\" }\n")
        self.write("approved.json", json.dumps({"schema": "backbend.baseline/1", "suite": "show", "approvals": []}))
        self.assert_runs("--no-project", "farm", "slurm", "show.toml", "-o", "plain", "--quick")
        script = (self.folder / "plain/farm/shard.sh").read_text()
        self.assertIn("--no-project", script)
        self.assertNotIn("--spp", script)
        done = self.backbend("farm", "slurm", "-o", "run", "--quick=false")
        self.assertEqual(done.returncode, 0, done.stderr)
        script = (self.folder / "run/farm/shard.sh").read_text()
        self.assertIn("--spp=3", script)
        self.assertNotIn("--quick ", script.replace("--quiet", ""))
        self.assertIn(os.path.realpath(self.folder) + "/show.toml", script)

    def test_an_envelope_of_the_project_yields_to_the_characters_own(self):
        self.write("backbend.toml", "envelope = \"creature\"\n")
        self.write("hero.glb", glb.tube())
        envelope = lambda *words: re.search(r"envelope '(\w+)'", self.backbend(
            "check", "hero.glb", "--quick", "-o", "run", *words).stdout).group(1)
        self.assertEqual(envelope(), "creature")
        self.assert_runs("inspect", "hero.glb", "--save")
        sidecar = self.folder / "hero.backbend.toml"
        text = re.sub(r"(?m)^#?\s*envelope\s*=.*\n", "", sidecar.read_text())
        sidecar.write_text("envelope = \"cartoon\"\n" + text)
        self.assertEqual(envelope(), "cartoon")
        self.assertEqual(envelope("--envelope", "creature"), "creature")

    def test_the_table_for_people_says_each_value_once(self):
        self.write("backbend.toml", "rig = \"even\"\n")
        text = self.assert_runs("config", "--show-origin", environment={"BACKBEND_THREADS": "2"}).stdout
        self.assertRegex(text, r"^project  /.*/backbend\.toml\n\n")
        self.assertRegex(text, r"\nthreads +2 +BACKBEND_THREADS +all\n")
        self.assertRegex(text, r"\nrig +even +/.*/backbend\.toml:1 +check, compare, why, render, turntable, bake\n")
        self.assertNotIn("BACKBEND_THREADS", self.assert_runs("config", environment={"BACKBEND_THREADS": "2"}).stdout)
        self.assertEqual(self.assert_runs("config", "--no-project").stdout.splitlines()[0], "project  none")


class Names(CommandTest):
    """One table of options: manual, page and variables are of the same names."""

    def test_no_option_takes_the_variable_of_something_else(self):
        rows = json.loads(self.assert_runs("config", "--json").stdout)["settings"]
        names = {row["option"].upper().replace("-", "_") for row in rows}
        self.assertGreater(len(names), 25)
        self.assertEqual(names & OTHERS, set())
        found = set()
        for path in [*SOURCE.glob("tests/**/*.py"), *SOURCE.glob("tests/**/*.cpp"), *SOURCE.glob("tests/**/*.sh"), SOURCE / "backbend"]:
            if path.name != pathlib.Path(__file__).name:
                found |= set(re.findall(r"(?:environ\w*(?:\.get|\.pop)?[(\[]\"|getenv\(\"|\$\{)BACKBEND_([A-Z_]+)",
                                        path.read_text(encoding="utf-8", errors="replace")))
        self.assertLessEqual({"CHARACTERS", "PACKAGES"}, found)
        self.assertLessEqual(found, OTHERS, "name it there, so that no option takes it")

    def test_the_page_lists_every_option_and_no_other(self):
        rows = json.loads(self.assert_runs("config", "--json").stdout)["settings"]
        told = {}
        for row in rows:
            told.setdefault(row["option"], set()).update(row["commands"])
        page = (SOURCE / "docs/project.md").read_text(encoding="utf-8")
        listed = {option: commands for option, commands in re.findall(r"^\| `([\w-]+)` \| (.*?) \|", page, re.M)}
        self.assertEqual(set(listed), set(told))
        everything = max(len(commands) for commands in told.values())
        for option, commands in listed.items():
            if commands == "all":
                self.assertEqual(len(told[option]), everything, option)
            else:
                self.assertEqual(set(commands.split(", ")), told[option], option)

    def test_the_projects_and_commands_that_pages_show_are_taken(self):
        self.write("rigs/spine.toml", "[rig]\nsystem = \"even\"\n")
        self.write("hero.glb", glb.tube())
        for page in ("docs/project.md", "docs/night.md"):
            text = (SOURCE / page).read_text(encoding="utf-8")
            (shown,) = re.findall(r"^```\n((?:# .*\n)?threads = .*?)^```", text, re.M | re.S)
            self.write("backbend.toml", shown)
            commands = re.findall(r"^(?:    |\./)backbend (config.*?) *(?:#.*)?$", text, re.M)
            self.assertGreater(len(commands), 0, page)
            for command in commands:
                self.assertIn("backbend.toml", self.assert_runs(*command.split()).stdout, command)

    def test_the_manual_names_each_variable(self):
        manual = self.assert_runs("completions", "man").stdout.replace("\\-", "-")
        section = manual.split(".SH ENVIRONMENT")[1]
        for row in json.loads(self.assert_runs("config", "--json").stdout)["settings"]:
            self.assertIn("BACKBEND_" + row["option"].upper().replace("-", "_") + "\\fR", section)
