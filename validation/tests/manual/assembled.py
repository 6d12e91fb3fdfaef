"""What the tests of the manual share: the program, the project, the modules that build the manual, and its pages, assembled."""
import pathlib
import sys
import tempfile
import unittest

ATWOOD, ROOT = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
sys.path[:0] = [str(ROOT / "packaging/manual"), str(ROOT / "validation/tests/reports")]
import build  # noqa: E402


class Assembled(unittest.TestCase):
    """`output`/docs holds the pages as mkdocs reads them; `faults`: what is wrong with their links."""
    drawn = False  # scenes whose pictures are drawn

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.output = pathlib.Path(cls.folder.name)
        cls.docs = cls.output / "docs"
        cls.faults = build.assemble(ATWOOD, cls.output, pictures=cls.drawn)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
