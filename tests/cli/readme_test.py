"""What the README says is what the program says."""

import json
import re

from harness import SOURCE, CommandTest


class Readme(CommandTest):
    def setUp(self):
        super().setUp()
        self.text = (SOURCE / "README.md").read_text(encoding="utf-8")

    def test_its_table_of_checks_is_the_programs(self):
        rows = [line.split(" | ") for line in self.text.splitlines() if re.match(r"\| BB\d{3} ", line)]
        checks = json.loads(self.assert_runs("list", "checks", "--json").stdout)
        self.assertEqual([row[0][2:] for row in rows], [check["code"] for check in checks])
        for row, check in zip(rows, checks):
            self.assertEqual(row[1], check["name"])
            self.assertEqual(row[2], check["measures"])
            self.assertIn("%g %s" % (check["limit"], check["unit"]), row[3])
            self.assertEqual(row[4].removesuffix(" |"), check["reason"])

    def test_its_list_of_rigs_is_the_programs(self):
        self.assertIn(self.assert_runs("list", "rigs").stdout.strip(), self.text)

    def test_every_command_it_shows_is_one(self):
        shown = set(re.findall(r"^\./backbend (\w+)", self.text, re.M)) - {"test"}
        self.assertGreater(len(shown), 8)
        for command in sorted(shown):
            self.assert_runs(command, "--help")

    def test_every_picture_it_shows_is_there(self):
        pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", self.text)
        self.assertGreater(len(pictures), 2)
        for picture in pictures:
            self.assertTrue((SOURCE / picture).is_file(), picture)
