"""The tutorial, followed to the letter: its files are written, its commands run in order, and what they print is
compared with the page, whatever the widths of columns; `...` on the page stands for anything."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from assembled import ATWOOD, ROOT
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)


def blocks(page):
    """(kind, text) of the blocks of code; a file's first line is a comment with its name."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


def plain(text, folder):
    return " ".join(text.replace(str(folder) + "/", "").split())


def differs(shown, printed):
    """Where the page's text departs from what was printed; None where it does not."""
    at, pieces = 0, [piece.strip() for piece in shown.split("...")]
    for k, piece in enumerate(pieces):
        found = printed.find(piece, at)
        if found < 0 or (k == 0 and found != 0):
            return piece
        at = found + len(piece)
    return printed[at:] if pieces[-1] and at != len(printed) else None


class Tutorial(unittest.TestCase):
    def test_its_commands_print_what_it_says(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(os.path.realpath(name))
            (folder / "reference").symlink_to(ROOT / "reference")
            wrapper = folder / "atwood"
            wrapper.write_text(f'#!/bin/sh\nATWOOD_CALLED_AS=./atwood exec "{ATWOOD}" "$@"\n')
            wrapper.chmod(0o755)
            printed, compared = None, 0
            for kind, text in blocks(ROOT / "docs/tutorial.md"):
                if kind == "toml":
                    path = folder / re.match(r"# (\S+)\n", text).group(1)
                    path.parent.mkdir(exist_ok=True)
                    path.write_text(text)
                elif kind == "sh":
                    ended = subprocess.run(["bash", "-c", text], cwd=folder, capture_output=True, text=True,
                                           timeout=300,
                                           stdin=subprocess.DEVNULL)
                    printed = plain(ended.stdout, folder)
                    self.assertEqual(ended.returncode, 0, text + printed + ended.stderr)
                elif kind == "text":
                    wrong = differs(plain(text, folder), printed)
                    self.assertIsNone(wrong, f"the page says\n{plain(text, folder)}\nprinted was\n{printed}")
                    compared += 1
            self.assertGreaterEqual(compared, 8)

    def test_a_difference_is_seen(self):
        self.assertIsNone(differs("a ... c", "a b c"))
        self.assertIsNone(differs("a b ...", "a b c"))
        self.assertEqual(differs("b ...", "a b"), "b")
        self.assertEqual(differs("a ... d", "a b c"), "d")
        self.assertEqual(differs("a b", "a b c"), " c")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
