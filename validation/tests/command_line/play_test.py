"""Pages of motion: what they hold against what `trace` prints, their size, and what is refused."""
import base64
import csv
import io
import json
import os
import re
import struct
import sys
import unittest
import zlib

from case import Case

SIX = ("atwood/rk4", "atwood/symplectic-euler", "atwood/velocity-verlet", "atwood/heun", "atwood/midpoint", "atwood/explicit-euler")
HOSTILE = "</script><img src=x onerror=alert(1)>"
BALL = """id = "ball"
title = "%s"
[run]
t_end_s = 1.0
steps = [64]
samples = 64
[world]
gravity_m_per_s2 = [0, 0, -9.81]
[[body]]
name = "ball"
mass_kg = 1
shape.sphere = { radius_m = 0.1 }
velocity_m_per_s = [1, 0, 0]
[truth]
kind = "%s"
"""


def parts(path):
    with open(path) as file:
        text = file.read()
    inflated = [zlib.decompress(base64.b64decode(re.search(f'<script type="text/plain" id="{name}">([^<]*)<', text)[1]), -15)
                for name in ("data", "motion")]
    return text, json.loads(inflated[0]), inflated[1]


def numbers(blob, entry, count, about=0):
    """A list of words that are stored as second differences modulo 2^16, low bytes first."""
    low, step, at = entry
    value = difference = 0
    found = []
    for i in range(count):
        difference = (difference + blob[at + i] + 256 * blob[at + count + i]) % 65536
        value = (value + difference) % 65536
        found.append(low + step * (value - about))
    return found


class Play(Case):
    def traced(self, *words):
        return list(csv.DictReader(io.StringIO(self.ask("trace", *words).stdout)))

    def test_the_page_holds_what_trace_prints(self):
        scene = self.path("ball.toml", BALL % ("A ball", "closed-form\"\nsolution = \"ballistic"))
        told = json.loads(self.ask("play", scene, "--method", "atwood/explicit-euler", "-o", "html:ball.html", "--json").stdout)
        self.assertEqual([run["name"] for run in told["runs"]], ["truth", "atwood/explicit-euler"])
        self.assertEqual((told["file"], told["frames"], told["bytes"]), ("ball.html", 65, os.path.getsize(self.path("ball.html"))))
        text, page, blob = parts(self.path("ball.html"))
        self.assertIn("default-src 'none'", text)
        self.assertEqual((page["truth"], page["samples"], page["motion"]["moving"]), (True, 64, [0]))
        truth, run = page["motion"]["runs"]
        exact, euler = self.traced(scene, "--method", "truth"), self.traced(scene, "--method", "atwood/explicit-euler")
        for axis, column in enumerate(("px_m", "py_m", "pz_m")):
            entry = truth["poses"][0]["p"][axis]
            for found, row in zip(numbers(blob, entry, 65), exact, strict=True):
                self.assertLessEqual(abs(found - float(row[column])), 0.51 * entry[1] + 1e-15)
            entry = run["differences"][0]["p"][axis]
            for found, row, true in zip(numbers(blob, entry, 65, 32768), euler, exact, strict=True):
                self.assertLessEqual(abs(found - (float(row[column]) - float(true[column]))), 0.51 * entry[1] + 1e-15)

    def test_energy_is_played_where_the_scene_does_not_conserve_it(self):
        scene = self.path("ball.toml", BALL % ("A ball", "closed-form\"\nsolution = \"ballistic"))
        for name, words, title, runs in (
                (scene, ["--method", "atwood/explicit-euler"], "mechanical energy, difference from the truth's", [False, True]),
                ("kepler-e0.3", ["--method", "atwood/explicit-euler", "--hz", "24"], "change of energy", [True, True]),
                ("bouncing-49", ["--method", "bullet64/default", "--hz", "60"], "change of mechanical energy", [True]),
                ("drifting-block", ["--method", "atwood/rk4+sph"], "change of kinetic energy", [True])):
            with self.subTest(name):
                self.ask("play", name, *words, "-o", "html:energy.html")
                _, page, blob = parts(self.path("energy.html"))
                self.assertEqual(page["energy_title"], title)
                self.assertEqual(["energy" in run for run in page["motion"]["runs"]], runs)
                if name != scene:
                    continue
                at, count = page["motion"]["runs"][1]["energy"]
                energies = struct.unpack(f"<{count}f", blob[at:at + 4 * count])
                exact, euler = self.traced(scene, "--method", "truth"), self.traced(scene, "--method", "atwood/explicit-euler")
                def energy(row):
                    return sum(float(row[v]) ** 2 for v in ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s")) / 2 + 9.81 * float(row["pz_m"])
                for found, row, true in zip(energies, euler, exact, strict=True):
                    self.assertAlmostEqual(found, energy(row) - energy(true), delta=1e-6 * (1 + abs(found)))

    def test_six_methods_are_a_small_page(self):
        self.ask("play", "free-box-complex", *sum((["--method", method] for method in SIX), []), "-o", "html:box.html")
        self.assertLess(os.path.getsize(self.path("box.html")), 1_500_000)
        self.assertEqual(len(parts(self.path("box.html"))[1]["motion"]["runs"]), 7)

    def test_a_hostile_title_is_text(self):
        scene = self.path("ball.toml", BALL % (HOSTILE, "none"))
        self.ask("play", scene, "--method", "atwood/rk4", "-o", "html:ball.html")
        text, page, _ = parts(self.path("ball.html"))
        self.assertNotIn(HOSTILE, text)
        self.assertEqual((page["title"], page["truth"]), (HOSTILE, False))

    def test_refusals(self):
        scene = self.path("ball.toml", BALL % ("A ball", "none"))
        self.ask("play", scene, code=2, told=["no truth", "expected --method"])
        for words, told in ((["-o", "csv:x"], "expected html:FILE"), (["-o", "html:"], "expected html:FILE"), (["--samples", "7"], "a multiple of the 7 samples"),
                            (["--samples", "0"], "expected a whole number of samples"), (["--steps", "0"], "expected a whole number"), (["--spacing", "0.1"], "has no fluid"),
                            (["--method", "atwood/*"], "found a glob"), (["--method", "atwood/rk9"], "no available engine provides")):
            self.ask("play", scene, "--method", "atwood/rk4", *words, code=2, told=[told])
        self.ask("play", "frame-rate-jitter", "--method", "atwood/rk4", code=2, told=["recorded frames"])
        # A truth that answers nothing writes nothing.
        self.ask("play", self.path("held.toml", BALL.replace("[truth]", "release_s = 0.5\n[truth]") % ("A ball", "closed-form\"\nsolution = \"kepler")), code=1,
                 told=["unsupported", "nothing was written"])
        self.assertEqual(sorted(os.listdir(self.here)), ["ball.toml", "held.toml"])

    def test_a_run_that_is_refused_is_named(self):
        self.ask("play", "double-pendulum-regular", "--method", "atwood/symplectic-euler", "-o", "html:page.html", code=1,
                 told=["unsupported: atwood/symplectic-euler: ", "cannot step a mechanism"])
        runs = parts(self.path("page.html"))[1]["motion"]["runs"]
        self.assertEqual([run["status"] for run in runs], ["ok", "unsupported"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
