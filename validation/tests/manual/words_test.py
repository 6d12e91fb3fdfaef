"""The commands, options and methods that the manual names are the program's: a page that names one that
is gone fails."""
import json
import pathlib
import re
import subprocess
import sys
import unittest

from assembled import ATWOOD, ROOT
PAGES = [*(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "reference/your_engine/README.md")),
         *sorted((ROOT / "docs").glob("*.md"))]
CODE = re.compile(r"^```(?:sh|console|yaml)\n(.*?)^```$|(?<!`)`([^`]+)`(?!`)", re.M | re.S)
CALL = re.compile(r"(?<![\w/.-])(?:\./)?atwood ([a-z][a-z-]*)((?:[^\n|&;'`]|'[^'\n]*')*)")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
METHOD = re.compile(r"(?<![\w/.-])atwood/([a-z][a-z0-9-]*)")
NO_METHOD = {"atwood/box-edges"}  # an engine of `contacts`


def code(page):
    """Blocks of commands and spans of code, lines that end in a backslash joined."""
    for block, span in CODE.findall(page.read_text(encoding="utf-8")):
        yield re.sub(r"\s*\\\n\s*", " ", block) if block else " ".join(span.split())


def calls(text):
    """(command, options) of each call of the program."""
    return [(command, OPTION.findall(re.sub(r"\s#.*", "", words))) for command, words in CALL.findall(text)]


class Words(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        def ask(*words):
            return subprocess.run([ATWOOD, *words], check=True, capture_output=True, text=True).stdout
        listed = ask("help").split("Commands:\n", 1)[1].split("\n\n", 1)[0]
        names = re.findall(r"^  ([a-z]+)(?: |$)", listed, re.M)
        cls.options = {name: set(OPTION.findall(ask("help", name))) | {"--help"} for name in names}
        for name in re.findall(r'"\$\{1:-\}" = (\w+)', (ROOT / "atwood").read_text()):  # the wrapper's own
            cls.options.setdefault(name, {"--help"})
        cls.methods = {m["id"] for m in json.loads(ask("list", "methods", "--json"))["methods"]} | NO_METHOD

    def wrong(self, text):
        for command, options in calls(text):
            if command not in self.options:
                yield f"no command {command}"
            else:
                yield from (f"{command} has no option {o}" for o in options if o not in self.options[command])
        named = [f"atwood/{name}" for name in METHOD.findall(text)]
        yield from (f"no method {method}" for method in named if method not in self.methods)

    def test_what_pages_name_exists(self):
        found = [f"{page.relative_to(ROOT)}: {fault}" for page in PAGES for text in code(page)
                 for fault in self.wrong(text)]
        self.assertEqual(found, [])

    def test_the_version_to_cite_is_the_programs(self):
        shown = subprocess.run([ATWOOD, "--version"], check=True, capture_output=True, text=True).stdout.split()[1]
        self.assertIn(f"version = {{{shown}}}", (ROOT / "docs/cite.md").read_text())

    def test_enough_is_read(self):
        read = [call for page in PAGES for text in code(page) for call in calls(text)]
        self.assertGreater(len(read), 100)
        self.assertGreater(sum(len(options) for _, options in read), 80)

    def test_what_is_gone_is_seen(self):
        self.assertEqual(list(self.wrong("./atwood run x.toml --method atwood/rk4 && atwood gate --quiet  # --no")), [])
        self.assertEqual(list(self.wrong("./atwood runs")), ["no command runs"])
        self.assertEqual(list(self.wrong("srun atwood run --shards 1/2 | head --x")), ["run has no option --shards"])
        self.assertEqual(list(self.wrong("--method atwood/rk5+event")), ["no method atwood/rk5"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
