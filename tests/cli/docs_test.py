"""The pages of docs/ against the program: every rig has its page, its picture and its options."""

import json
import re
import shlex

from harness import SOURCE, CommandTest

RIGS = SOURCE / "docs/rigs"


class RigPages(CommandTest):
    def rigs(self):
        return [row["name"] for row in json.loads(self.assert_runs("list", "rigs", "--json").stdout)]

    def page(self, rig):
        return (RIGS / (rig + ".md")).read_text(encoding="utf-8")

    def test_every_rig_has_one_with_its_picture_and_none_is_left_over(self):
        rigs = self.rigs()
        self.assertEqual({path.stem for path in RIGS.glob("*.md")}, set(rigs))
        for rig in rigs:
            (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+)\)", self.page(rig))
            self.assertEqual((RIGS / picture).read_bytes()[:8], b"\x89PNG\r\n\x1a\n", rig)
            for heading in ("Controls", "Formula", "Options", "Limits", "Source"):
                self.assertIn("\n## " + heading + "\n", self.page(rig), rig)

    def test_its_options_are_the_systems_with_their_defaults(self):
        self.write("night.toml", "[suite]\ncharacters = [\"%s\"]\n[[sweep]]\nchannel = \"extension\"\nto = 10\nstep = 5\n"
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
            words = [str(SOURCE / word) if word.startswith("scenes/") else word for word in shlex.split(command)]
            self.assert_runs(*words, "--res", "32x24", "--spp", "1", "-o", rig)
            self.assertEqual(len(list((self.folder / rig).glob("*.png"))), 1, rig)
