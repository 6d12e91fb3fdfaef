"""An installation: complete, independent of the place where it was built, and with the results of the build."""
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import unittest

from prefix import ATWOOD, BUILD, ROOT, Prefix

ONE_CELL = ["run", "--scenario", "ballistic", "--method", "atwood/rk4", "--method", "bullet64/default", "--steps", "120", "--no-timing",
            "--quiet", "-o", "csv:rows.csv"]


class Installation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.prefix = Prefix("program")

    @classmethod
    def tearDownClass(cls):
        cls.prefix.remove()

    def files(self):
        for folder, _, names in os.walk(self.prefix.path):
            for name in names:
                yield os.path.join(folder, name)

    def rows_of(self, program_run):
        here = os.path.join(self.prefix.folder, program_run)
        os.mkdir(here)
        program = self.prefix.atwood if program_run == "installed" else ATWOOD
        done = subprocess.run([program, *ONE_CELL], cwd=here, text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(os.path.exists(os.path.join(here, "atwood-out", "report.html")))
        with open(os.path.join(here, "rows.csv")) as file:
            return [{key: value for key, value in row.items() if key != "run_id"} for row in csv.DictReader(file)]

    def test_a_run_gives_the_rows_of_the_build(self):
        rows = self.rows_of("installed")
        self.assertEqual(rows, self.rows_of("built"))
        self.assertEqual({row["status"] for row in rows}, {"ok"})

    def test_every_worker_is_found_in_the_prefix(self):
        done = self.prefix.run("doctor", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        self.assertTrue(told["truth"])
        engines = {os.path.basename(engine["path"]): engine for engine in told["engines"]}
        for name in ("engine", "cvode", "bullet64", "bullet32", "ode", "arkode", "ida", "odeint", "fcl", "libccd"):
            engine = engines["atwood-" + name]
            self.assertEqual(engine["status"], "ok", engine)
            self.assertEqual(os.path.dirname(engine["path"]), os.path.join(self.prefix.path, "libexec", "atwood"))
        self.assertEqual(engines["atwood-engine"]["version"], self.version())

    def test_the_worker_in_javascript_answers_with_what_is_installed(self):
        node = shutil.which("node")
        told = subprocess.run([node, "-p", "process.versions.node"], text=True, capture_output=True).stdout if node else ""
        if not told or [int(part) for part in told.split(".")[:2]] < [18, 3]:
            self.skipTest("no Node.js of version 18.3 or newer")
        worker = os.path.join(self.prefix.path, "share", "atwood", "reference", "your_engine", "worker.mjs")
        done = subprocess.run(["node", worker], input='{"request":"hello"}\n', text=True, capture_output=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["engine"], "javascript")

    def test_an_engine_that_is_not_installed_says_which_package_brings_it(self):
        said = self.prefix.run("doctor").stdout
        for engine, package in (("dart", "atwood-dart"), ("mujoco", "atwood-mujoco"), ("rapier", "atwood-node-engines")):
            self.assertRegex(said, f"atwood-{engine} .*not built: .* the package {package} brings it")
        refused = self.prefix.run("bench")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("in a copy of the sources", refused.stderr)

    def test_catalogue_studies_and_gates_are_those_of_the_sources(self):
        for what in ("scenarios", "studies", "gates", "metrics"):
            here, there = (subprocess.run([program, "list", what], text=True, capture_output=True, timeout=60).stdout
                           for program in (self.prefix.atwood, ATWOOD))
            self.assertEqual(here, there)
            self.assertGreater(len(here.splitlines()), 5)
        share = os.path.join(self.prefix.path, "share", "atwood")
        for room in ("validation/scenarios", "docs"):
            for folder, _, names in os.walk(os.path.join(ROOT, room)):
                for name in names:
                    path = os.path.relpath(os.path.join(folder, name), ROOT)
                    self.assertTrue(os.path.exists(os.path.join(share, path)), path)

    def test_nothing_installed_names_the_place_where_it_was_built(self):
        # The sources' folder may be as short as /atwood: only a path that begins there counts, also as -I/atwood/x.
        source = re.compile(rb"(?:(?<![\w.+~@%$)}>*-])|(?<=-[IL]))" + re.escape(ROOT.encode() + b"/"))
        for text, named in ((b"\0%s/engine", True), (b"-I%s/engine", True), (b"=%s/x", True),
                            (b"file://%s/x", True), (b"share%s/docs", False), (b"${prefix}%s/docs", False),
                            (b"%s-engine", False), (b'"%s"', False)):
            self.assertEqual(bool(source.search(text % ROOT.encode())), named, text)
        count = 0
        for path in self.files():
            with open(path, "rb") as file:
                content = file.read()
            if ROOT.encode() in content:
                self.assertIsNone(source.search(content), path)
            for place in (BUILD, os.path.join(self.prefix.folder, "first place")):
                self.assertNotIn(place.encode(), content, path)
            count += 1
        self.assertGreater(count, 300)

    def test_what_the_program_prints_of_itself_is_installed(self):
        for path, words in (("share/atwood/schema/scenario.schema.json", ["schema", "scenario"]),
                            ("share/atwood/schema/rows.schema.json", ["schema", "rows"]),
                            ("share/man/man1/atwood.1", ["help", "--man"]),
                            ("share/bash-completion/completions/atwood", ["completion", "bash"])):
            with open(os.path.join(self.prefix.path, path)) as file:
                self.assertEqual(file.read(), self.prefix.run(*words).stdout, path)

    def test_the_worker_in_python_takes_part(self):
        worker = os.path.join(self.prefix.path, "share/atwood/reference/your_engine/worker.py")
        done = self.prefix.run("run", "--engine", worker, "--scenario", "ballistic", "--steps", "120", "--no-timing")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("python/symplectic-euler", done.stdout)

    def version(self):
        return re.fullmatch(r"atwood (\S+) \(protocol \d+\)\n", self.prefix.run("--version").stdout)[1]

    def test_the_version_is_that_of_the_changelog(self):
        with open(os.path.join(self.prefix.path, "share/atwood/CHANGELOG.md")) as file:
            self.assertEqual(re.search(r"^## (\S+)", file.read(), re.M)[1], self.version())

    def test_a_program_without_its_data_says_so(self):
        alone = os.path.join(self.prefix.folder, "alone")
        os.mkdir(alone)
        with open(self.prefix.atwood, "rb") as program, open(os.path.join(alone, "atwood"), "wb") as copy:
            copy.write(program.read())
        os.chmod(os.path.join(alone, "atwood"), 0o755)
        done = subprocess.run([os.path.join(alone, "atwood"), "list", "scenarios"], text=True, capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("ATWOOD_ROOT", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
