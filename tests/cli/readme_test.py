"""What the README and the pages of docs/ say is what the program says: commands, output, tables, links."""

import json
import re
import shutil

from harness import SOURCE, CommandTest, human


README = SOURCE / "README.md"
PAGES = [README, SOURCE / "CONTRIBUTING.md", *sorted((SOURCE / "docs").rglob("*.md"))]
LINK = re.compile(r"!?\[[^]]*\]\(([^)]+)\)")


def masked(line):
    """A line of output without what another version may print otherwise: numbers, bars, columns' widths."""
    return " ".join(re.sub(r"\d+(?:[ .]\d+)*|[#.]{4,}", "0", line).split())


class Readme(CommandTest):
    def setUp(self):
        super().setUp()
        self.text = README.read_text(encoding="utf-8")

    def test_it_is_short(self):
        self.assertLessEqual(len(self.text.splitlines()), 150)

    def test_the_commands_it_shows_print_what_it_shows(self):
        shutil.copy(human(), self.folder / "hero.glb")
        self.assert_runs("bake", "hero.glb", "--rig", "isner", "--sweep", "extension", "-o", "hero_anim.glb")
        quick = {"turntable": ("--views", "1", "--res", "48x36", "--spp", "1")}
        shown = re.findall(r"^```\n\$ \./backbend (.*)\n((?:.*\n)*?)```$", self.text, re.M)
        self.assertEqual([line.split()[0] for line, _ in shown],
                         ["inspect", "check", "check", "compare", "explain", "turntable"])
        for line, excerpt in shown:
            with self.subTest(line):
                words = line.split()
                done = self.backbend(*words, *quick.get(words[0], ()))
                self.assertIn(done.returncode, (0, 1), done.stderr)
                printed = {masked(each) for each in done.stdout.splitlines()}
                for each in excerpt.splitlines():
                    self.assertIn(masked(each), printed, done.stdout)

    def test_every_command_line_that_it_or_a_page_shows_is_one_that_the_program_takes(self):
        # Command, options and words to choose from, by the one table that manual and completions are made of;
        # what the commands do is run by each command's own tests.
        table = self.table()
        lines = {(str(page.relative_to(SOURCE)), line) for page in PAGES for line in re.findall(
            r"^(?:(?:\$ )?\./|    )backbend +([a-z].*?)(?: +#.*)?$|`(?:\./)?backbend ([a-z][^`]*)`", page.read_text(encoding="utf-8"),
            re.M) for line in line if line}
        self.assertGreater(len([line for page, line in lines if page == "README.md"]), 6)
        self.assertGreater(len([line for page, line in lines if page == "docs/commands.md"]), 25)
        self.assertGreater(len(lines), 120)
        commands = {line.split()[0] for page, line in lines if page == "docs/commands.md"} - {"test"}
        self.assertEqual(commands, set(table) - {""})
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
                    if word.startswith("-") and word != "-":  # that is standard output
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

    def test_every_link_of_every_page_leads_somewhere(self):
        for page in PAGES:
            for link in LINK.findall(page.read_text(encoding="utf-8")):
                place, _, heading = link.partition("#")
                target = (page.parent / place).resolve() if place else page
                with self.subTest(page=page.name, link=link):
                    self.assertTrue(target.is_file())
                    if heading:
                        headings = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.M)
                        self.assertIn(heading, [re.sub(r"[^\w -]", "", each.lower()).replace(" ", "-") for each in headings])

    def test_the_table_of_contents_leads_to_every_page(self):
        contents = SOURCE / "docs/README.md"
        linked, todo = set(), [contents]
        while todo:  # tables of rigs and checks are contents, too
            page = todo.pop()
            for link in LINK.findall(page.read_text(encoding="utf-8")):
                target = (page.parent / link.partition("#")[0]).resolve()
                if target not in linked:
                    linked.add(target)
                    if target.name == "README.md":
                        todo.append(target)
        self.assertEqual([page for page in PAGES if page not in (README, contents) and page.resolve() not in linked], [])

    def test_it_shows_pictures(self):
        self.assertGreaterEqual(self.text.count("!["), 2)


class Tables(CommandTest):
    def test_the_table_of_checks_is_the_programs_row_by_row(self):
        text = (SOURCE / "docs/checks/README.md").read_text(encoding="utf-8")
        rows = [line for line in text.splitlines() if re.match(r"\| BB\d{3} ", line)]
        checks = json.loads(self.assert_runs("list", "checks", "--json").stdout)
        self.assertEqual(rows, ["| %s | %s | %s | %s %g %s%s | %s |" % (
            check["code"], check["name"], check["measures"], check["sense"], check["limit"], check["unit"],
            "" if check["decides"] else " (advisory)", check["reason"]) for check in checks])

    def test_the_list_of_rigs_is_the_programs(self):
        self.assertIn(self.assert_runs("list", "rigs").stdout.strip(),
                      (SOURCE / "docs/rigs/README.md").read_text(encoding="utf-8"))

    def test_every_exit_code_is_listed(self):
        text = (SOURCE / "docs/exit_codes.md").read_text(encoding="utf-8")
        header = (SOURCE / "validate/verdicts/exit_code.h").read_text(encoding="utf-8")
        codes = re.findall(r"= (\d+)[,;\n]", header)
        self.assertGreater(len(codes), 8)
        for code in codes:
            self.assertRegex(text, r"(?m)^\| (?:\d+, )*%s\b" % code)
