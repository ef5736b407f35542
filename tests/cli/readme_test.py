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
            self.assertIn("%s %g %s" % (check["sense"], check["limit"], check["unit"]), row[3])
            self.assertEqual(row[4].removesuffix(" |"), check["reason"])

    def test_its_list_of_rigs_is_the_programs(self):
        self.assertIn(self.assert_runs("list", "rigs").stdout.strip(), self.text)

    def test_every_command_line_that_it_or_a_page_shows_is_one_that_the_program_takes(self):
        # Command, options and words to choose from, by the one table that manual and completions are made of;
        # what the commands do is run by each command's own tests.
        table = self.table()
        pages = [SOURCE / "README.md", *sorted((SOURCE / "docs").rglob("*.md"))]
        lines = {(page.name, line) for page in pages for line in re.findall(
            r"^(?:\./|    )backbend +([a-z].*?)(?: +#.*)?$|`(?:\./)?backbend ([a-z][^`]*)`", page.read_text(encoding="utf-8"),
            re.M) for line in line if line}
        self.assertGreater(len([line for page, line in lines if page == "README.md"]), 40)
        self.assertGreater(len(lines), 80)
        for page, line in sorted(lines):
            with self.subTest(page=page, line=line):
                command, *words = re.split(r"\s+", line.strip())
                if command == "test":  # the launcher's
                    continue
                self.assertIn(command, table)
                options = table[""] | table[command]
                if command == "config":  # what follows may be another command's line
                    options |= table.get(words[0] if words else "", {})
                for word, after in zip(words, [*words[1:], ""]):
                    if word.startswith("-"):
                        self.assertIn(word.rstrip(".,"), options)
                        choices = options[word.rstrip(".,")]
                        if choices:
                            self.assertIn(after, choices)

    def table(self):
        """Command, or "" for all of them -> option -> the words that it takes; empty: any, or none."""
        table, command, names = {"": {}}, None, False
        for line in self.assert_runs("completions", "man").stdout.replace("\\-", "-").splitlines():
            if line == ".SH OPTIONS":
                command = ""
            elif line.startswith(".SS "):
                command = line.split('"')[1].split()[0]
                table[command] = {}
            elif line.startswith(".SH "):
                command = None
            elif names and command is not None:
                value = re.search(r"\\fI([a-z][^\\]*)\\fR$", line)
                for option in re.findall(r"\\fB(-[^\\]+)\\fR", line):
                    table[command][option] = set(value.group(1).split("|")) if value else set()
            names = line == ".TP"
        return table

    def test_every_picture_it_shows_is_there(self):
        pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", self.text)
        self.assertGreater(len(pictures), 2)
        for picture in pictures:
            self.assertTrue((SOURCE / picture).is_file(), picture)
