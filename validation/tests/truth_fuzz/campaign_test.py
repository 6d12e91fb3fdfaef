"""Exit codes of atwood-truth-fuzz, and where a campaign goes on: arguments: the program."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1)
PAIR = "closed-form/sphere-impact"


def ask(*arguments):
    return subprocess.run([PROGRAM, "--pair", PAIR, *arguments], text=True, capture_output=True, timeout=300)


class Campaign(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.log = pathlib.Path(folder.name, "fuzz.tsv")

    def test_fewer_answered_scenes_than_asked_are_incomplete(self):
        short = ask("--answered", "1000000", "--most-seconds", "0.01")
        self.assertEqual(short.returncode, 3)
        self.assertIn("INCOMPLETE, 1000000 asked", short.stdout)
        self.assertEqual(ask("--answered", "1000000", "--most-seconds", "0.01", "--may-be-incomplete").returncode, 0)
        self.assertEqual(ask("--answered", "3").returncode, 0)

    def test_a_campaign_goes_on_where_its_log_ends_with_the_same_build(self):
        self.assertEqual(ask("--answered", "3", "--log", self.log).returncode, 0)
        self.assertEqual(ask("--answered", "5", "--log", self.log).returncode, 0)
        lines = [line.split("\t") for line in self.log.read_text().splitlines()]
        self.assertEqual([line[2] for line in lines], list("01234"))
        build = lines[0][5]
        self.assertRegex(build, "^[0-9a-f]{16}$")
        self.log.write_text(self.log.read_text().replace(build, "0" * 16))
        self.assertEqual(ask("--answered", "2", "--log", self.log).returncode, 0)  # of another build: from the start
        self.assertEqual([line.split("\t")[2] for line in self.log.read_text().splitlines()], list("0123401"))

    def test_a_breach_and_too_many_refusals_fail(self):
        ask("--answered", "1", "--log", self.log)
        one = self.log.read_text()
        line = one.split("\t")
        for outcome, words in (("breach", "20 breached"), ("refused", ": more than 0.2 %")):
            entries = ["\t".join([*line[:2], str(k), outcome, *line[4:]]) for k in range(20)]
            self.log.write_text("".join(entries))
            ended = ask("--answered", "10", "--log", self.log)
            with self.subTest(outcome=outcome):
                self.assertEqual(ended.returncode, 1)
                self.assertIn(words, ended.stdout)


if __name__ == "__main__":
    unittest.main()
