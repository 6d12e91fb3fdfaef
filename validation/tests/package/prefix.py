"""An installation in an empty prefix, for the tests of one. The program is then moved: nothing may remember where it was."""
import os
import shutil
import subprocess
import sys
import tempfile

ATWOOD = os.path.abspath(sys.argv[1])
ROOT = os.path.abspath(sys.argv[2])
BUILD = os.path.dirname(os.path.dirname(ATWOOD))


def install(folder, *components):
    """Installs into `folder`, moves the prefix, and gives its path."""
    first, moved = os.path.join(folder, "first place"), os.path.join(folder, "moved here")
    for component in components:
        done = subprocess.run(["cmake", "--install", BUILD, "--prefix", first, "--component", component], text=True,
                              capture_output=True, timeout=300)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
    os.rename(first, moved)
    return moved


class Prefix:
    """The program and its workers, installed once a test module."""

    def __init__(self, *components):
        self.folder = tempfile.mkdtemp()
        self.path = install(self.folder, *components)
        self.atwood = os.path.join(self.path, "bin", "atwood")

    def remove(self):
        shutil.rmtree(self.folder)

    def run(self, *words, cwd=None, **more):
        """Calls the installed program with a nearly empty environment, in an empty folder unless `cwd` is given."""
        here = cwd or tempfile.mkdtemp(dir=self.folder)
        return subprocess.run([self.atwood, *words], **{"cwd": here, "text": True, "capture_output": True, "timeout": 300,
                                                        "env": {"PATH": "/usr/bin:/bin", "HOME": here}, **more})
