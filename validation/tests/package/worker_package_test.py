"""The CMake package: a C++ engine configured and built in an empty folder against an installation that has been moved."""
import csv
import os
import subprocess
import sys
import unittest

from prefix import ROOT, Prefix

SOURCE = os.path.join(ROOT, "reference", "your_engine", "cpp")


class WorkerPackage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.prefix = Prefix("program", "dev")
        cls.build = os.path.join(cls.prefix.folder, "build of my engine")
        for words in (["cmake", "-S", SOURCE, "-B", cls.build, "-G", "Ninja", "-DCMAKE_PREFIX_PATH=" + cls.prefix.path,
                       "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror"], ["cmake", "--build", cls.build]):
            done = subprocess.run(words, text=True, capture_output=True, timeout=300)
            if done.returncode != 0:
                raise AssertionError(done.stdout + done.stderr)
        cls.engine = os.path.join(cls.build, "my-engine")

    @classmethod
    def tearDownClass(cls):
        cls.prefix.remove()

    def test_its_run_ends_where_the_recurrence_does(self):
        steps, t_end_s = 120, 3
        done = self.prefix.run("trace", os.path.join(self.scene(t_end_s)), "--engine", self.engine, "--method",
                               "cpp/symplectic-euler", "--steps", str(steps), "--samples", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        last = list(csv.DictReader(done.stdout.splitlines()))[-1]
        # v_n = v_0 - n h g, x_n = x_0 + n h v_0 - h^2 g n (n + 1) / 2
        h, v0, g = t_end_s / steps, 4, 10
        self.assertAlmostEqual(float(last["pz_m"]), 1 + t_end_s * v0 - h * h * g * steps * (steps + 1) / 2, delta=1e-11)
        self.assertAlmostEqual(float(last["vz_m_per_s"]), v0 - t_end_s * g, delta=1e-11)

    def scene(self, t_end_s, more=""):
        path = os.path.join(self.prefix.folder, "scene.toml")
        with open(path, "w") as file:
            file.write(f"""id = "thrown"
title = "A stone"
claim = "None."
source = "This test."
tags = []
[run]
t_end_s = {t_end_s}
steps = [120, 240]
samples = 1
[world]
gravity_m_per_s2 = [0, 0, -10]
[[body]]
name = "stone"
mass_kg = 2
position_m = [0, 0, 1]
velocity_m_per_s = [0, 0, 4]
{more}
[truth]
kind = "extended"
""")
        return path

    def test_it_is_measured_and_what_it_cannot_do_is_refused_by_name(self):
        done = self.prefix.run("run", "--engine", self.engine, "--scenario", "ballistic", "--steps", "120", "-o", "csv:rows.csv", cwd=self.prefix.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open(os.path.join(self.prefix.folder, "rows.csv")) as file:
            rows = {row["metric"]: row for row in csv.DictReader(file)}
        self.assertEqual(rows["step-time"]["status"], "ok")
        self.assertGreater(float(rows["step-time"]["value"]), 0)
        done = self.prefix.run("run", "--engine", self.engine, "--scenario", "kepler-e0.6", "--no-timing")
        self.assertIn("cpp has no forces beside uniform gravity", done.stdout + done.stderr)

    def test_the_headers_need_the_standard_library_alone(self):
        done = subprocess.run(["g++", "-std=c++20", "-I", os.path.join(self.prefix.path, "include"), "-M", os.path.join(SOURCE, "worker.cpp")],
                              text=True, capture_output=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        headers = done.stdout.replace("\\\n", " ").replace("\\ ", "\0").split()[2:]
        own = [path.replace("\0", " ") for path in headers if "/atwood/" in path]
        self.assertGreater(len(own), 10)
        for path in headers:
            path = path.replace("\0", " ")
            standard = path.startswith(("/usr/include/c++/", "/usr/lib/gcc/", "/usr/include/x86_64-linux-gnu/", "/usr/include/aarch64-linux-gnu/"))
            plain_c = os.path.dirname(path) in ("/usr/include", "/usr/include/linux", "/usr/include/asm-generic")
            self.assertTrue(path in own or standard or plain_c, path)

    def test_headers_need_no_order(self):
        include = os.path.join(self.prefix.path, "include")
        lines = sorted(f"#include <{os.path.relpath(os.path.join(folder, name), include)}>\n" for folder, _, names in os.walk(include)
                       for name in names)
        self.assertGreater(len(lines), 15)
        for order in (lines, lines[::-1]):
            done = subprocess.run(["g++", "-std=c++20", "-fsyntax-only", "-I", include, "-x", "c++", "-"], input="".join(order), text=True,
                                  capture_output=True, timeout=100)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_another_version_is_refused(self):
        project = os.path.join(self.prefix.folder, "wants another")
        os.mkdir(project)
        with open(os.path.join(project, "CMakeLists.txt"), "w") as file:
            file.write("cmake_minimum_required(VERSION 3.25)\nproject(p LANGUAGES CXX)\nfind_package(Atwood 9.0 REQUIRED)\n")
        done = subprocess.run(["cmake", "-S", project, "-B", project + " built", "-DCMAKE_PREFIX_PATH=" + self.prefix.path], text=True,
                              capture_output=True, timeout=100)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("compatible with requested version \"9.0\"", " ".join(done.stderr.split()))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
