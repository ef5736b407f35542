"""Plain words: idioms that readers tripped over must not come back. What each should say instead stands beside it.

In pages, help and messages all of them count; in comments only those that obscure what the code does."""

import re

from harness import SOURCE, CommandTest

# Pattern -> what to write. Patterns ignore case, and a line break counts as a space.
EVERYWHERE = {
    r"\bas it must\b": "(expected)",
    r"\b(canaries|canary) (did|does|do) (its|their) duty|\bsang\b": "self-tests passed",
    r"\bon its duty\b": "run a canary",
    r"\bwhat of (a|an|the)\b": "the parts of ... that",
    r"\btakes? away, at its end\b": "on destruction, removes",
    r"\btake the folder along\b": "delete the folder",
    r"\bnobody's (concern|fault|pass)\b": "not a fault, not a pass",
    r"\bnothing changed for good\b": "no lasting change",
    r"\bmay be believed\b": "tool self-check",
    r"\baccept as it is\b": "waive",
    r"\bhow a command goes about\b": "options that do not affect results",
    r"\bmade anew\b": "rebuilt, repeated",
    r"\bhonest (file|sum|character)": "real, valid",
    r"\bsettles? it\b": "specify ...",
    r"\bsinging\b|\bdeaf\b": "missed its target",
    r"\bkManners\b|\bTailor\b|\bShooting\b": "name the thing: kGlobalOptions, WeightRepair, FrameRenderer",
}
IN_PRINT = EVERYWHERE | {
    r"(?<!there )\b(is|are) no (?!longer\b|more\b|fault\b|tolerance\b|upper\b|lower\b)[a-z]+": "is not a ..., or: invalid X; expected Y",
    r"\bthat there (is|are) not\b": "unknown",
    r"\bstands? otherwise\b": "differs",
    r"\bfor good\b": "to keep it",
    r"\banew\b": "again",
    r"\bas asked for\b": "requested",
    r"\bfound by itself\b": "automatic",
    r"\bjoints bear\b": "naming convention of the joints",
    r"\bonly say what there is to do\b": "print the plan and the estimated time, then exit",
    r"\bwhat there is\b": "list ...",
    r"\btakes? up what\b": "continue",
    r"\bweighs? \d+ places\b": "vertices with stray influence",
    r"\bno neighbour knows\b": "influence not shared by neighbours",
    r"\bbeyond the envelope\b": "outside the required range",
}
LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"(?:\s*\n\s*"((?:[^"\\\n]|\\.)*)")*')


def code():
    for layer in ("solver", "skin", "render", "validate", "cli"):
        for path in sorted((SOURCE / layer).rglob("*")):
            if path.suffix in (".h", ".cpp", ".js", ".py"):
                yield path


def one_line(text):
    return re.sub(r"\s+(?:///?|\*)?\s*", " ", text)


def pages():
    yield from (SOURCE / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"))
    yield from sorted((SOURCE / "docs").rglob("*.md"))


class Words(CommandTest):
    def assert_plain(self, where, text, rules):
        for pattern, better in rules.items():
            found = re.search(pattern, text, re.I)
            if found:
                around = text[max(0, found.start() - 40):found.end() + 40]
                self.fail(f"{where}: '{found.group()}' in '...{around}...'; write: {better}")

    def test_pages_are_plain(self):
        for page in pages():
            with self.subTest(page=str(page.relative_to(SOURCE))):
                self.assert_plain(page.name, one_line(page.read_text(encoding="utf-8")), IN_PRINT)

    def test_comments_and_names_are_plain(self):
        for path in code():
            with self.subTest(path=str(path.relative_to(SOURCE))):
                self.assert_plain(path.name, one_line(path.read_text(encoding="utf-8")), EVERYWHERE)

    def test_messages_are_plain(self):
        count = 0
        for path in code():
            if path.suffix not in (".h", ".cpp"):
                continue
            for literal in LITERAL.finditer(path.read_text(encoding="utf-8")):
                text = "".join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', literal.group()))
                if " " in text:
                    count += 1
                    with self.subTest(path=str(path.relative_to(SOURCE))):
                        self.assert_plain(path.name, text, IN_PRINT)
        self.assertGreater(count, 1000)  # that the search for literals works

    def test_help_is_plain(self):
        text = self.assert_runs("completions", "man").stdout.replace("\\-", "-")
        self.assertGreater(len(text), 10000)
        self.assert_plain("help", one_line(text), IN_PRINT)

    def test_every_rule_finds_something(self):
        for sentence in ("found at 114.274 as it must", "'x' is no picture size", "a key that there is not",
                         "takes away, at its end, what of a folder's path", "both canaries did their duty"):
            with self.subTest(sentence):
                with self.assertRaises(AssertionError):
                    self.assert_plain("here", sentence, IN_PRINT)
        self.assert_plain("here", "there is no neck; it is no longer tilted", IN_PRINT)


class LeaksAreChecked(CommandTest):
    def test_the_address_sanitizers_run_looks_for_leaks_but_those_of_the_list(self):
        presets = (SOURCE / "CMakePresets.json").read_text(encoding="utf-8")
        self.assertIn("detect_leaks=1", presets)
        self.assertNotIn("detect_leaks=0", presets)
        (listed,) = re.findall(r"suppressions=\$\{sourceDir\}/(tests/leak_sanitizer\.supp)", presets)
        lines = (SOURCE / listed).read_text(encoding="utf-8").splitlines()
        rules = [line for line in lines if line and not line.startswith("#")]
        self.assertTrue(rules)
        for rule in rules:
            self.assertTrue(rule.startswith("leak:") and "backbend" not in rule, rule)
