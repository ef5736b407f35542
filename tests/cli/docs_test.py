"""The pages of docs/ against the program: every rig and every check has its page and its picture, and what a page
says of options, limits and findings is what the program says. Commands shown are run."""

import json
import re
import shlex
import shutil

import glb
from harness import SOURCE, CommandTest, human

RIGS = SOURCE / "docs/rigs"


def words_of(command):
    """A shown command's words, with the project's own characters found from anywhere, and the human made once."""
    places = {"scenes/characters/human.toml": human()}
    return [str(places.get(word, SOURCE / word)) if word.startswith("scenes/") else word
            for word in shlex.split(command)]


class RigPages(CommandTest):
    def rigs(self):
        return [row["name"] for row in json.loads(self.assert_runs("list", "rigs", "--json").stdout)]

    def page(self, rig):
        return (RIGS / (rig + ".md")).read_text(encoding="utf-8")

    def test_every_rig_has_one_with_its_picture_and_none_is_left_over(self):
        rigs = self.rigs()
        self.assertEqual({path.stem for path in RIGS.glob("*.md")} - {"README"}, set(rigs))
        for rig in rigs:
            (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+)\)", self.page(rig))
            self.assertEqual((RIGS / picture).read_bytes()[:8], b"\x89PNG\r\n\x1a\n", rig)
            for heading in ("Controls", "Formula", "Options", "Limits", "Source"):
                self.assertIn("\n## " + heading + "\n", self.page(rig), rig)

    def test_its_options_are_the_systems_with_their_defaults(self):
        self.write("night.toml", "[suite]\ncharacters = [\"%s\"]\ncorners = false\n[[sweep]]\nchannel = \"extension\"\nto = 10\nstep = 5\n"
                   % (SOURCE / "scenes/characters/snake.toml") +
                   "".join(f'[[rig]]\nname = "{rig}"\nsolver = {{ system = "{rig}" }}\n' for rig in self.rigs()))
        result = self.backbend("nightly", "night.toml", "--quick", "--json", "-o", "out")
        for rig in json.loads(result.stdout)["rigs"]:
            told = dict(re.findall(r"^\| `(\w+)` \| (.*?) \| ", self.page(rig["rig"]), re.M))
            self.assertEqual(set(told), set(rig["options"]), rig["rig"])
            for option, default in told.items():
                if default.startswith("`"):
                    self.assertEqual(default.strip("`"), rig["options"][option], (rig["rig"], option))

    def test_the_command_it_shows_makes_a_picture(self):
        for rig in self.rigs():
            (command,) = re.findall(r"^    backbend (render .*)$", self.page(rig), re.M)
            self.assert_runs(*words_of(command), "--res", "32x24", "--spp", "1", "-o", rig)
            self.assertEqual(len(list((self.folder / rig).glob("*.png"))), 1, rig)


CHECKS = SOURCE / "docs/checks"
# A flip, a kink and a drift, each looked at in few small pictures.
PICTURED = """[suite]
characters = ["human.glb"]
mappings = ["chest"]
envelope = "sweep"
[[rig]]
solver = { system = "isner" }
[[rig]]
solver = { system = "three_bone" }
[[sweep]]
channel = "extension"
from = 90
to = 120
step = 10
[pictures]
width = 64
height = 48
samples = 1
turntable_views = 3
sheet_columns = 2
"""
COMMAND = re.compile(r"^    backbend (.*)$", re.M)


class CheckPages(CommandTest):
    """One section for each code: what it means, formula, limit with its reason, what it cannot see, source."""

    def pages(self):
        return {path.stem: path.read_text(encoding="utf-8") for path in sorted(CHECKS.glob("*.md"))
                if path.stem != "README"}

    def sections(self):
        """Code -> the texts of all sections that bear it, with the name in the heading."""
        found = {}
        for text in self.pages().values():
            for code, name, body in re.findall(r"^## (BB\d{3}) (.*?)\n(.*?)(?=^## |\Z)", text, re.M | re.S):
                found.setdefault(code, []).append((name, body))
        return found

    def test_every_check_has_its_section_once_and_none_is_left_over(self):
        checks = json.loads(self.assert_runs("list", "checks", "--json").stdout)
        sections = self.sections()
        self.assertEqual(sorted(sections), [check["code"] for check in checks])
        for check in checks:
            ((name, body),) = sections[check["code"]]
            self.assertEqual(name, check["name"], check["code"])
            for part in ("Formula", "Limit", "Blind to", "Source"):
                self.assertEqual(body.count(f"\n**{part}** "), 1, (check["code"], part))
        for name, text in self.pages().items():  # the title lists what the page holds
            held = re.findall(r"^## (BB\d{3})", text, re.M)
            if held:
                self.assertEqual(re.findall(r"BB\d{3}", text.splitlines()[0]), held, name)

    def test_its_limit_is_the_one_that_list_and_explain_give(self):
        for check in json.loads(self.assert_runs("list", "checks", "--json").stdout):
            limit = "%s %g %s" % (check["sense"], check["limit"], check["unit"])
            told = limit + ("" if check["decides"] else " (advisory)")
            ((_, body),) = self.sections()[check["code"]]
            (stated,) = re.findall(r"^\*\*Limit\*\* (.*?): ", body, re.M)
            self.assertEqual(stated, told, check["code"])
            self.assertIn("limit     " + limit, self.assert_runs("explain", check["code"]).stdout)

    def test_its_figures_are_the_programs_reasons(self):
        # Every number in the reason that the program gives for a limit stands on the page, too.
        for check in json.loads(self.assert_runs("list", "checks", "--json").stdout):
            ((_, body),) = self.sections()[check["code"]]
            numbers = set(re.findall(r"\d+(?:\.\d+)?", body))
            missing = set(re.findall(r"\d+(?:\.\d+)?", check["reason"])) - numbers
            self.assertEqual(missing, set(), (check["code"], check["reason"]))

    def test_its_picture_is_small_and_there(self):
        used = set()
        for name, text in self.pages().items():
            (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+)\)", text)
            content = (CHECKS / picture).read_bytes()
            self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n", name)
            self.assertLess(len(content), 60000, name)
            used.add(picture)
        self.assertEqual({path.name for path in CHECKS.glob("*.png")}, used)

    def test_the_commands_it_shows_run_and_find_what_it_says(self):
        found = {}  # by command: several pages show the same
        shutil.copy(human(), self.folder / "hero.glb")
        self.write("stray.glb", glb.with_strays((self.folder / "hero.glb").read_bytes()))
        for name, text in self.pages().items():
            self.assertRegex(text, COMMAND, name)
            for shown in COMMAND.finditer(text):
                words = words_of(shown.group(1))
                with self.subTest(page=name, command=shown.group(1)):
                    if words[0] == "render":
                        self.assert_runs(*words, "--res", "32x24", "--spp", "1", "-o", name)
                        self.assertEqual(len(list((self.folder / name).glob("*.png"))), 1)
                    elif words[0] == "check":
                        if shown.group(1) not in found:
                            done = self.backbend(*words, "--json", "-o", f"run{len(found)}")
                            self.assertIn(done.returncode, (0, 1, 5), done.stderr)
                            found[shown.group(1)] = {f["code"] for f in json.loads(done.stdout)["findings"]}
                        said = re.match(r"\n\nfinds (nothing|BB\d{3}(?:, BB\d{3})*)", text[shown.end():])
                        if said and said.group(1) == "nothing":
                            self.assertEqual(found[shown.group(1)], set())
                        elif said:
                            self.assertLessEqual(set(said.group(1).split(", ")), found[shown.group(1)])
                    else:
                        self.assert_runs(*words)

    def test_what_it_says_of_pictures_is_what_a_run_asks_of_them(self):
        rows = re.findall(r"^\| (BB[^|]*) \| `(\w+)`.*\| ([\d.]+)[^|]*\|$", self.pages()["pictures"], re.M)
        told = {code: (metric, float(limit)) for codes, metric, limit in rows for code in codes.split(", ")}
        shutil.copy(human(1500), self.folder / "human.glb")
        self.write("night.toml", PICTURED)
        done = self.backbend("nightly", "night.toml", "--json", "-o", "run")
        seen = {}
        for finding in json.loads(done.stdout)["findings"]:
            image = finding["image"]
            if image != "not_measured" and image["measured"]:
                seen[finding["code"]] = (image["metric"], image["threshold"])
        self.assertGreater(len(seen), 2)
        for code, asked in seen.items():
            self.assertEqual(asked, told.get(code), code)
