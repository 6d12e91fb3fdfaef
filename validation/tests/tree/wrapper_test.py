"""The wrapper script as a new user meets it, on a machine whose apt, sudo and cmake only record their calls."""
import fcntl
import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv[1])
RECORDED = ("apt-get", "sudo", "cmake", "ninja")


class Machine:
    """A copy of the wrapper and its table of commands, and a PATH without packages, where the user is not root."""

    def __init__(self, folder, root=False):
        self.folder = pathlib.Path(folder)
        self.calls = self.folder / "calls"
        self.calls.write_text("")
        (self.folder / "docs").mkdir()
        for name in ("atwood", "docs/commands.md"):
            shutil.copy(ROOT / name, self.folder / name)
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        for name in RECORDED:
            self.script(name, f'echo "{name} $*" >> "{self.calls}"\nexit 1\n')
        self.script("dpkg-query", "exit 0\n")
        self.script("id", f"echo {0 if root else 1000}\n")

    def script(self, name, text):
        path = self.bin / name
        path.write_text("#!/bin/bash\n" + text)
        path.chmod(0o755)

    def environment(self, **more):
        kept = {key: value for key, value in os.environ.items() if not key.startswith("ATWOOD_")}
        return {**kept, "PATH": f"{self.bin}:/usr/bin:/bin", **more}

    def run(self, *words, **more):
        return subprocess.run([str(self.folder / "atwood"), *words], env=self.environment(**more), cwd="/", text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, timeout=60)

    def with_packages(self):
        """All packages are installed, cmake succeeds, and ninja fails."""
        self.script("dpkg-query", 'shift 3; for name; do printf "ii %s\\n" "$name"; done\n')
        self.script("cmake", f'echo "cmake $*" >> "{self.calls}"\ntouch "{self.folder}/build/release/build.ninja"\n')

    def configured(self, **more):
        """Whether a call of the wrapper configures the build."""
        before = self.recorded().count("cmake")
        self.run("run", **more)
        return self.recorded().count("cmake") > before

    def run_on_terminal(self, answer, *words):
        """What the wrapper writes on a terminal where `answer` is typed, and its exit code."""
        master, slave = pty.openpty()
        process = subprocess.Popen([str(self.folder / "atwood"), *words], env=self.environment(), cwd="/",
                                   stdin=slave, stdout=slave, stderr=slave, close_fds=True)
        os.close(slave)
        os.write(master, (answer + "\n").encode())
        text = b""
        while True:
            try:
                block = os.read(master, 4096)
            except OSError:  # the terminal's last writer has gone
                break
            if not block:
                break
            text += block
        os.close(master)
        return process.wait(timeout=60), text.decode()

    def recorded(self):
        return self.calls.read_text()


class Wrapper(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.machine = Machine(self.folder.name)

    def test_help_installs_and_builds_nothing(self):
        for words in (["--help"], ["bench", "--help"], ["run", "-h"], ["help"], [], ["test", "--help"]):
            with self.subTest(words=words):
                ended = self.machine.run(*words)
                self.assertEqual(ended.returncode, 0, ended.stderr)
                self.assertIn("atwood", ended.stdout)
                self.assertEqual(self.machine.recorded(), "")

    def test_help_without_a_program_is_the_table_of_commands(self):
        shown = self.machine.run("--help").stdout
        for command in ("atwood run", "atwood gate", "atwood bless", "atwood doctor", "atwood check"):
            self.assertIn(command, shown)
        self.assertIn("  atwood bless [STUDY] --reason TEXT\n      make the stored rows the baseline\n", shown)

    def test_help_is_the_programs_own_where_one_is_built(self):
        program = self.machine.folder / "build/release/bin/atwood"
        program.parent.mkdir(parents=True)
        program.write_text('#!/bin/bash\necho "program: $ATWOOD_CALLED_AS: $*"\n')
        program.chmod(0o755)
        called = str(self.machine.folder / "atwood")
        self.assertEqual(self.machine.run("bench", "--help").stdout, f"program: {called}: bench --help\n")
        self.assertEqual(self.machine.run().stdout, f"program: {called}: --help\n")
        self.assertEqual(self.machine.recorded(), "")

    def test_another_build_is_waited_for_only_where_this_call_needs_a_build(self):
        """Another process holds the lock of the build until the test lets it go."""
        machine = self.machine
        machine.with_packages()
        machine.script("ninja", f'echo "ninja $*" >> "{machine.calls}"\n')
        machine.script("sleep", "exec /bin/sleep 0.01\n")
        program = machine.folder / "build/release/bin/atwood"
        program.parent.mkdir(parents=True)
        program.write_text('#!/bin/bash\necho "ran: $*"\n')
        program.chmod(0o755)
        for name in ("engine", "reference", "validation", "benchmarks", "reports", "packaging"):
            (machine.folder / name).mkdir()
        (machine.folder / "CMakeLists.txt").write_text("")
        for _ in range(2):  # the first call configures, the second finds it done
            self.assertEqual(machine.run("run", "x").stdout, "ran: run x\n")
        with open(machine.folder / "build/release/.atwood-build.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            built = machine.recorded()
            ended = machine.run("run", "y")
            self.assertEqual((ended.stdout, ended.stderr), ("ran: run y\n", ""))
            self.assertEqual(machine.recorded(), built)
            (machine.folder / "engine/new.cpp").write_text("")
            waiting = subprocess.Popen([str(machine.folder / "atwood"), "run", "z"], env=machine.environment(), cwd="/", text=True,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
            self.assertEqual(waiting.stderr.readline(), "atwood: waiting for another build of this tree\n")
            self.assertEqual(machine.recorded(), built)
        self.assertEqual(waiting.communicate(timeout=60)[0], "ran: run z\n")
        self.assertEqual(machine.recorded().count("ninja"), built.count("ninja") + 1)

    def test_on_a_terminal_it_asks_before_root_rights_are_used(self):
        code, text = self.machine.run_on_terminal("n", "run")
        self.assertEqual(code, 5, text)
        self.assertIn("[Y/n]", text)
        self.assertIn("nothing installed", text)
        self.assertEqual(self.machine.recorded(), "")
        code, text = self.machine.run_on_terminal("y", "run")
        self.assertIn("sudo env", self.machine.recorded())

    def test_without_a_terminal_the_call_is_the_consent(self):
        ended = self.machine.run("run")
        self.assertEqual(ended.returncode, 5)
        self.assertNotIn("[Y/n]", ended.stderr)
        self.assertIn("sudo env", self.machine.recorded())

    def test_only_reports_when_told_to_install_nothing(self):
        self.machine.script("id", "echo 0\n")
        ended = subprocess.run([str(self.machine.folder / "atwood"), "run"], text=True, capture_output=True, timeout=60,
                               env={**self.machine.environment(), "ATWOOD_NO_INSTALL": "1"}, stdin=subprocess.DEVNULL)
        self.assertEqual(ended.returncode, 5)
        self.assertIn("missing packages", ended.stderr)
        self.assertEqual(self.machine.recorded(), "")

    def test_a_first_build_without_optional_engines_prints_no_errors(self):
        self.machine.with_packages()
        self.assertEqual(self.machine.run("run").stderr.splitlines()[0], "atwood: configuring")

    def test_engines_that_are_not_offered_are_refused_by_name(self):
        for engine, told in (("physx", "built only for browsers"), ("havok", "no engine `havok`; expected all, or some of dart")):
            ended = self.machine.run("run", ATWOOD_ENGINES=f"rapier,{engine}")
            self.assertEqual(ended.returncode, 2)
            self.assertIn(engine, ended.stderr)
            self.assertIn(told, ended.stderr)
            self.assertEqual(self.machine.recorded(), "")

    def test_another_node_is_configured_for_where_engines_run_under_it(self):
        machine = self.machine
        machine.with_packages()
        machine.script("npm", "exit 0\n")
        machine.script("node", "echo v20.1.0\n")
        self.assertTrue(machine.configured())
        machine.script("node", "echo v20.2.0\n")
        self.assertFalse(machine.configured())  # no engine runs under it
        for lock in ("reference/node/package-lock.json", "build/release/node/installed-lock.json"):
            (machine.folder / lock).parent.mkdir(parents=True, exist_ok=True)
            (machine.folder / lock).write_text("{}")
        self.assertTrue(machine.configured(ATWOOD_ENGINES="rapier"))
        self.assertFalse(machine.configured(ATWOOD_ENGINES="rapier"))
        self.assertFalse(machine.configured())  # it stays set up
        machine.script("node", "echo v20.3.0\n")
        self.assertTrue(machine.configured(ATWOOD_ENGINES="rapier"))
        (machine.folder / "other").mkdir()
        shutil.move(machine.bin / "node", machine.folder / "other/node")
        self.assertTrue(machine.configured(ATWOOD_ENGINES="rapier", PATH=f"{machine.folder}/other:{machine.environment()['PATH']}"))

    @unittest.skipUnless(shutil.which("node"), "no Node.js")
    def test_a_package_that_is_known_and_not_installed_is_missing(self):
        self.machine.script("dpkg-query", """shift 3; for name; do s=ii; [ "$name" != patch ] || s=un; printf "%s %s\\n" $s "$name"; done\n""")
        ended = self.machine.run("run", ATWOOD_NO_INSTALL="1")
        self.assertEqual(re.search(r"missing packages: (.*)", ended.stderr)[1], "patch")

    def test_node_is_installed_where_it_is_older_than_18_3(self):
        self.machine.with_packages()
        self.machine.script("npm", "exit 0\n")
        self.machine.script("dpkg-query", "exit 0\n")
        other = self.machine.folder / "other.cjs"
        self.machine.script("node", f'exec {shutil.which("node")} --require "{other}" "$@"\n')
        for version, recent in (("18.2.9", False), ("9.11.2", False), ("18.3.0", True), ("18.20.4", True), ("20.1.0", True)):
            other.write_text(f'Object.defineProperty(process, "versions", {{ value: {{ node: "{version}" }} }});')
            ended = self.machine.run("run", ATWOOD_ENGINES="jolt", ATWOOD_NO_INSTALL="1")
            missing = re.search(r"missing packages: (.*)", ended.stderr)[1].split()
            self.assertEqual("nodejs" in missing, not recent, version)

    def test_package_takes_no_words_and_brings_the_tools_of_packages(self):
        ended = self.machine.run("package", "everything")
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertIn("found everything", ended.stderr)
        ended = self.machine.run("package", ATWOOD_NO_INSTALL="1")
        self.assertEqual(ended.returncode, 5, ended.stderr)
        self.assertIn(" dpkg-dev ", ended.stderr)
        self.assertIn(" mkdocs-material", ended.stderr)  # the manual is packed as a site
        self.assertNotIn(" dpkg-dev ", self.machine.run("run", ATWOOD_NO_INSTALL="1").stderr)

    def test_a_bare_machine_gets_what_the_build_requires(self):
        """Each find_package(... REQUIRED) of the tree has its Debian package in the wrapper's list."""
        packages = {"CLI11": "libcli11-dev", "Catch2": "catch2", "Eigen3": "libeigen3-dev", "PkgConfig": "pkg-config",
                    "Python3": "python3", "SQLiteCpp": "libsqlitecpp-dev", "Threads": "g++", "ZLIB": "zlib1g-dev",
                    "benchmark": "libbenchmark-dev", "fmt": "libfmt-dev", "nlohmann_json": "nlohmann-json3-dev",
                    "pugixml": "libpugixml-dev", "rapidcheck": "librapidcheck-dev"}
        self.machine.script("id", "echo 0\n")
        ended = subprocess.run([str(self.machine.folder / "atwood"), "run"], text=True, capture_output=True, timeout=60,
                               env={**self.machine.environment(), "ATWOOD_NO_INSTALL": "1"}, stdin=subprocess.DEVNULL)
        missing = re.search(r"missing packages: (.*)", ended.stderr)[1].split()
        required = set()
        for place in ROOT.rglob("CMakeLists.txt"):
            if "build" in place.relative_to(ROOT).parts:
                continue
            required |= set(re.findall(r"^ *find_package\((\w+)[^)]*\bREQUIRED\b", place.read_text(), re.M))
        required.discard("Atwood")  # the example of an engine, which is built against an installation
        self.assertGreater(len(required), 4)
        for name in sorted(required):
            with self.subTest(name=name):
                self.assertIn(packages[name], missing)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
