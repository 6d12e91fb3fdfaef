"""What the tests of the commands share: the program, a folder of its own for each test, files in it, and calls from there.
The first word of a test's call is the program, the second, where a test needs it, the project's root."""
import os
import subprocess
import sys
import tempfile
import unittest

ATWOOD = os.path.abspath(sys.argv[1])
ROOT = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 and os.path.isdir(sys.argv[2]) else None


def thrown_stone(steps):
    """The text of a scene."""
    return """id = "mine"
title = "A thrown stone"
claim = "It falls."
tags = ["smooth"]
[run]
t_end_s = 1.0
steps = STEPS
samples = 64
[world]
gravity_m_per_s2 = [0, 0, -9.8]
[[body]]
name = "stone"
mass_kg = 2.0
position_m = [0, 0, 1]
velocity_m_per_s = [1, 0, 2]
[truth]
kind = "extended"
""".replace("STEPS", steps)


class Case(unittest.TestCase):
    environment = None  # of the calls; None: this process's own

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.here = os.path.realpath(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def path(self, name, text=None, mode=0o644):
        """The path of a file in the test's folder, which is written first where `text` is given."""
        path = os.path.join(self.here, name)
        if text is not None:
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w") as file:
                file.write(text)
            os.chmod(path, mode)
        return path

    def run_in(self, *words, cwd=None, **more):
        """Calls the program in the test's folder; any exit code."""
        return subprocess.run([ATWOOD, *words], **{"cwd": cwd or self.here, "text": True, "capture_output": True, "timeout": 300,
                                                   "env": self.environment, **more})

    def expect(self, result, code, *words):
        """The exit code (or one of several), and words that are printed; a line break counts as a space."""
        text = result.stdout + result.stderr
        self.assertIn(result.returncode, code if isinstance(code, (list, tuple, set)) else [code], text)
        for word in words:
            if word not in " ".join(text.split()):
                self.assertIn(word, text)
        return result

    def ask(self, *words, code=0, told=(), **more):
        """Calls the program and expects this exit code and these words."""
        return self.expect(self.run_in(*words, **more), code, *told)
