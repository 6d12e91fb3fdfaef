"""The manual's links: every relative one leads to a file and a heading, in the repository and in the assembled pages;
and the pages that the program writes about itself hold what it has."""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from assembled import ATWOOD, ROOT, Assembled
import pages

MADE = ROOT / "docs/reference"  # by the program, when the site is built


class Links(Assembled):
    def test_assembled_pages_have_no_broken_link(self):
        self.assertEqual(self.faults, [])

    def test_the_repositorys_own_pages_have_none(self):
        own = [*(ROOT / name for name in ("README.md", *pages.OUTSIDE)), *(ROOT / "docs").rglob("*.md")]
        own = [page for page in own if page.is_file()]
        self.assertEqual(pages.broken_links(ROOT, own), [])

    def test_the_page_that_stands_for_the_programs_pages_names_each_of_them(self):
        self.assertEqual([page.name for page in MADE.iterdir()], ["README.md"], "the others are made, not committed")
        named = set(pages.anchors((MADE / "README.md").read_text(encoding="utf-8"))) - {"reference"}
        self.assertEqual(named, {page.stem for page in (self.output / "docs/reference").glob("*.md")})
        for page in (self.output / "docs").glob("*.md"):
            self.assertNotIn("reference/README.md", page.read_text(encoding="utf-8").replace("`reference/README.md#name`", ""),
                             page.name)

    def test_every_page_stands_in_the_navigation_once(self):
        named = re.findall(r"([\w/-]+\.md)$", (ROOT / "packaging/manual/mkdocs.yml").read_text(), re.M)
        docs = self.docs
        there = [str(p.relative_to(docs)) for p in docs.rglob("*.md") if "files" not in p.relative_to(docs).parts]
        self.assertEqual(sorted(named), sorted(there))

    def test_the_readme_is_one_page(self):
        lines = (ROOT / "README.md").read_text().splitlines()
        self.assertLess(len(lines), 60)

    def made(self, name):
        return (self.output / f"docs/reference/{name}.md").read_text(encoding="utf-8")

    def test_the_programs_pages_hold_what_it_has(self):
        data = json.loads(subprocess.run([ATWOOD, "list", "--json"], check=True, capture_output=True, text=True).stdout)
        methods, metrics, scenarios = self.made("methods"), self.made("metrics"), self.made("scenarios")
        own = [m for m in data["methods"] if m["id"].startswith("atwood/")] + data["responses"]
        self.assertGreater(len(own), 50)
        for method in own:
            self.assertIn(f"## `{method['id']}`", methods)
        self.assertEqual(methods.count("\nSource: "), sum(bool(m["source"]) for m in own))
        for metric in data["metrics"]:
            self.assertIn(f"`{metric['name']}` |", metrics)
        for scene in data["scenarios"]:
            self.assertIn(f"<code>{scene['id']}</code>", scenarios)
        settings = {name for m in own for name in m["settings"]}
        for name in settings:
            self.assertIn(f"| `{name}` |", self.made("settings"))
        gates = self.made("gates")
        self.assertEqual(gates.count("\n| `"), len(data["gates"]))
        for gate in data["gates"]:
            for number in gate.get("within", [gate[bound] for bound in ("max", "min") if bound in gate]):
                self.assertIn(f" {number:g} ", gates)
        for code in ("0", "1", "2", "3", "4", "5", "130, 143"):
            self.assertIn(f"\n| {code} |", self.made("exit-codes"))
        for command in ("run", "gate", "describe", "play"):
            self.assertIn(f"\n## {command}\n", self.made("options"))
        self.assertIn("| `run.t_end_s` | number (required) |", self.made("schema"))

    def test_a_command_of_the_program_has_a_row_in_the_table(self):
        table = (ROOT / "docs/commands.md").read_text()
        for command in re.findall(r"^## (\w+)$", self.made("options"), re.M):
            self.assertRegex(table, rf"`atwood {command}\b")


class Faults(unittest.TestCase):
    """What is wrong is seen."""

    def check(self, text, more=None):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "page.md").write_text(text)
            (folder / "other.md").write_text(more or "# Two words\n\n## `code` and *more*\n\n## Two words\n")
            return [fault.split(": ", 1)[1] for fault in pages.broken_links(folder)]

    def test_of_links(self):
        self.assertEqual(self.check("[a](other.md#two-words) [b](other.md#code-and-more) [c](https://x)"), [])
        self.assertEqual(self.check("[a](other.md#two-words_1)"), [])
        self.assertEqual(self.check("[a](nowhere.md)"), ["nowhere.md: no such file"])
        self.assertEqual(self.check("[`a`](other.md#three)"), ["other.md#three: no such heading"])
        self.assertEqual(self.check("# Here\n[a](#here) [b](#there)"), ["#there: no such heading"])
        self.assertEqual(self.check("![a picture of\nseveral lines](no.svg)"), ["no.svg: no such file"])
        self.assertEqual(self.check("`[a](no.md)`\n\n```sh\n[b](no.md)\n# not a heading\n```\n[c](#not-a-heading)"),
                         ["#not-a-heading: no such heading"])

    def test_bars_in_tables(self):
        self.assertEqual(pages.for_mkdocs("| `a\\|b` | c \\| d |\n\n`e\\|f`\n"), "| `a|b` | c \\| d |\n\n`e\\|f`\n")

    def test_of_files_outside_the_manual(self):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name) / "root"
            docs = pathlib.Path(name) / "docs"
            for folder in (root / "docs", root / "src", docs):
                folder.mkdir(parents=True)
            (root / "src/a.py").write_text("pass\n")
            (docs / "page.md").write_text("[a](../src/a.py) [b](../src/b.py) [c](../../outside.md)")
            faults = pages.bring_in(root, docs)
            self.assertEqual(faults, ["docs/page.md: ../src/b.py: no such file",
                                      "docs/page.md: ../../outside.md: no such file"])
            self.assertIn("[a](files/src/a.py)", (docs / "page.md").read_text())
            self.assertTrue((docs / "files/src/a.py").is_file())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
