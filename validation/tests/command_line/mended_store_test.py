"""An engine's fingerprint covers the modules beside it."""
import os
import subprocess
import sys
import tempfile
import unittest

ATWOOD, ROOT = map(os.path.abspath, sys.argv[1:3])
WORKER = os.path.join(ROOT, "reference/your_engine/worker.py")
SCENARIO = ["--scenario", "ballistic"]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.here = self.folder.name

    def tearDown(self):
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.here, name)

    def atwood(self, *words, code=0, told=()):
        result = subprocess.run([ATWOOD, *words], cwd=self.here, text=True, capture_output=True, timeout=60)
        self.assertIn(result.returncode, [code] if isinstance(code, int) else code, result.stdout + result.stderr)
        for word in told:
            self.assertIn(word, result.stdout + result.stderr)
        return result


class Template(Case):
    def test_a_module_of_the_copied_worker_counts(self):
        with open(WORKER) as file:
            text = file.read()
        with open(self.path("worker.py"), "w") as file:
            file.write(text.replace("import hashlib,", "import gain, hashlib,", 1))
        os.chmod(self.path("worker.py"), 0o755)
        gain = lambda value: open(self.path("gain.py"), "w").write(f"GAIN = {value}\n")  # noqa: E731
        run = ["run", *SCENARIO, "--engine", "./worker.py", "--no-timing"]
        gain("1.0")
        first = self.atwood(*run).stderr
        self.assertIn("python 0 of", first)
        self.assertNotIn("campaign", first)
        self.assertNotIn("python 0 of", self.atwood(*run).stderr)
        gain("1.01234")
        self.atwood(*run, told=["python 0 of"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
