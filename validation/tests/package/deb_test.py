"""The Debian packages `atwood` and `atwood-dev`: made twice they are the same bytes, and unpacked they run."""
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from prefix import BUILD, ROOT

FOLDER = tempfile.mkdtemp()


def cpack(to, umask, **environment):
    return subprocess.run(["cpack", "--config", os.path.join(BUILD, "CPackConfig.cmake"), "-B", to, "-D", "CPACK_COMPONENTS_ALL=program;dev"],
                          text=True, capture_output=True, timeout=500, cwd=FOLDER, umask=umask, env={**os.environ, **environment})


def packages(name, **environment):
    """Makes the packages in a folder of FOLDER; {name of the package: path}."""
    to = os.path.join(FOLDER, name)
    done = cpack(to, 0o022, **environment)
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return {file.partition("_")[0]: os.path.join(to, file) for file in os.listdir(to) if file.endswith(".deb")}


def field(deb, name):
    return subprocess.run(["dpkg-deb", "-f", deb, name], text=True, capture_output=True, check=True).stdout.strip()


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.first = packages("one")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(FOLDER)

    def test_made_twice_they_are_the_same_bytes(self):
        again = packages("another", TZ="Pacific/Auckland", LC_ALL="C", HOME=FOLDER)
        self.assertEqual(sorted(again), ["atwood", "atwood-dev"])
        for name, path in self.first.items():
            digests = []
            for each in (path, again[name]):
                with open(each, "rb") as file:
                    digests.append(hashlib.sha256(file.read()).hexdigest())
            self.assertEqual(*digests, name)

    def test_no_file_names_the_place_where_it_was_built(self):
        """So that a build of the same commit elsewhere has the same bytes: `.ci/nightly reproducible` makes one."""
        places = [os.path.realpath(place).encode() for place in (BUILD, ROOT)]
        for name, path in self.first.items():
            root = os.path.join(FOLDER, "searched", name)
            os.makedirs(root)
            subprocess.run(["dpkg-deb", "-R", path, root], check=True)
            files = [os.path.join(folder, file) for folder, _, names in os.walk(root) for file in names]
            self.assertGreater(len(files), 20)
            for each in files:
                if os.path.islink(each):
                    continue
                with open(each, "rb") as file:
                    content = file.read()
                for place in places:
                    self.assertNotIn(place, content, each)

    def test_a_umask_that_others_could_not_read_is_refused(self):
        done = cpack(os.path.join(FOLDER, "private"), 0o077)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("packages need the umask 022, found 0077", done.stdout + done.stderr)

    def test_apt_is_told_of_the_libraries_and_of_no_heavy_engine(self):
        depends = field(self.first["atwood"], "Depends")
        for library in ("libc6", "libstdc++6", "libquadmath0", "libsqlite3-0", "libfmt9", "libbullet3.24", "libode8", "libfcl0.7",
                        "libsundials-cvode6"):
            self.assertRegex(depends, rf"(^|, ){re.escape(library)}\b", depends)
        for heavy in ("dart", "mujoco", "simbody", "nodejs", "-dev"):
            self.assertNotIn(heavy, depends)
            if heavy != "-dev":
                self.assertIn(heavy.removesuffix("js"), field(self.first["atwood"], "Suggests"))

    def test_its_files_are_root_s_and_readable_by_all(self):
        listed = subprocess.run(["dpkg-deb", "-c", self.first["atwood"]], text=True, capture_output=True, check=True).stdout
        for line in listed.splitlines():
            mode, owner = line.split()[:2]
            self.assertEqual(owner, "root/root", line)
            self.assertIn(mode, ("drwxr-xr-x", "-rw-r--r--", "-rwxr-xr-x"), line)
            self.assertTrue(line.split()[5].startswith("./"), line)
        self.assertIn("./usr/bin/atwood\n", listed)
        self.assertIn("./usr/share/doc/atwood/copyright", listed)

    def test_unpacked_it_runs(self):
        root = os.path.join(FOLDER, "root")
        subprocess.run(["dpkg-deb", "-x", self.first["atwood"], root], check=True)
        done = subprocess.run([os.path.join(root, "usr/bin/atwood"), "run", "--scenario", "ballistic", "--method", "atwood/rk4", "--steps", "120",
                               "--no-timing"], cwd=FOLDER, text=True, capture_output=True, timeout=300, env={"PATH": "/usr/bin:/bin"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        version = subprocess.run([os.path.join(root, "usr/bin/atwood"), "--version"], text=True, capture_output=True, timeout=60).stdout
        self.assertEqual(field(self.first["atwood"], "Version"), version.split()[1])


if __name__ == "__main__":
    for tool in ("dpkg-deb", "dpkg-shlibdeps", "file"):
        if not shutil.which(tool):
            print(f"skipped: {tool} is not here (dpkg-dev, file)")
            sys.exit(77)
    unittest.main(argv=sys.argv[:1])
