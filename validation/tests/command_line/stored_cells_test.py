"""What the store keeps: cells that are stale, damaged, too many; and what `run` says that it took from it."""
import csv
import os
import signal
import sqlite3
import subprocess
import sys
import time
import unittest

from case import ATWOOD, Case, thrown_stone


# Flight under constant weight, exact but for the factor that the module beside it holds.
ENGINE = """#!/usr/bin/env -S python3 -B
import json, os, sys, time
from gain import GAIN
def say(answer):
    print(json.dumps(answer), flush=True)
for line in sys.stdin:
    r = json.loads(line)
    if r["request"] == "hello":
        say({"engine": "mine", "version": "1", "scalar": "double", "methods": [{"id": "mine/one", "doc": "one"}], **MORE})
        continue
    with open(os.environ["ENGINE_LOG"], "a") as log:
        log.write("%s %d\\n" % (r["pass"], r["steps"]))
    time.sleep(float(os.environ.get("ENGINE_SLEEP", "0")))
    for k in range(r["samples"] + 1):
        t = r["t_end_s"] * k / r["samples"]
        rows = []
        for b in r["scene"]["bodies"]:
            g = [0, 0, -9.8]
            p = [x + GAIN * v * t + 0.5 * a * t * t for x, v, a in zip(b["position_m"], b["velocity_m_per_s"], g)]
            rows.append(p + [1, 0, 0, 0] + [v + a * t for v, a in zip(b["velocity_m_per_s"], g)] + [0, 0, 0])
        say({"cell": r["cell"], "t_s": t, "bodies": rows})
    say({"cell": r["cell"], "done": {"status": "ok", "reason": "", "steps_taken": r["steps"], "rate_evaluations": 0}})
"""

SCENE = thrown_stone("[64, 128, 256, 512]")


class OwnEngine(Case):
    def setUp(self):
        super().setUp()
        self.environment = {**os.environ, "ATWOOD_CALLED_AS": "", "ENGINE_LOG": self.path("engine.log", "")}
        self.write_engine()
        self.path("gain.py", "GAIN = 1.0\n")
        self.path("mine.toml", SCENE)
        self.words = ["--engine", "./engine.py", "--no-sandbox", "--method", "mine/one", "--method", "atwood/rk4", "--scenario", "mine.toml"]

    def write_engine(self, **more):
        self.path("engine.py", ENGINE.replace("MORE", repr(more)), 0o755)

    def atwood(self, *words, code=0, told=(), **environment):
        return self.ask(*words, code=code, told=told, env={**self.environment, **environment})

    def run_all(self, *more, **how):
        return self.atwood("run", *self.words, "--no-timing", "-o", "csv:rows.csv", *more, **how)

    def error(self, method="mine/one", of=None):
        """The error of position that the last export or `report` holds."""
        if of:
            self.atwood("report", *self.words, "-o", "csv:rows.csv")
        with open(self.path("rows.csv")) as file:
            rows = [row for row in csv.DictReader(file) if row["method"] == method and row["steps"] == "512"
                    and row["metric"] == "error-position-end"]
        self.assertEqual(len(rows), 1)
        return float(rows[0]["value"])

    def runs(self):
        with open(self.path("engine.log")) as file:
            return len(file.readlines())


class Stale(OwnEngine):
    def test_a_module_that_changes_behind_a_script_is_seen(self):
        self.run_all(told=["mine 0 of 4 cells", "atwood 0 of 4 cells", "truth 0 of 1 scenes", "mine: a new campaign"])
        self.assertLess(self.error(), 1e-12)
        self.path("gain.py", "GAIN = 1.01\n")
        self.run_all(told=["mine 0 of 4 cells", "atwood 4 of 4 cells", "truth 1 of 1 scenes", "--reuse takes the last one"])
        self.assertGreater(self.error(), 0.01)
        self.assertGreater(self.error(of="report"), 0.01)
        self.assertEqual(self.runs(), 8)
        self.run_all("--reuse", told=["mine 4 of 4 cells"])
        self.assertEqual(self.runs(), 8)
        self.run_all("--fresh", told=["mine 0 of 4 cells", "atwood 0 of 4 cells", "truth 0 of 1 scenes"])
        self.atwood("run", *self.words, "--fresh", "--reuse", code=2, told=["--reuse"])

    def test_the_gates_read_the_latest_campaign(self):
        self.path("gates.toml", "[[gate]]\nscenario = 'mine'\nmethod = 'mine/one'\nmetric = 'error-position-end'\n"
                                "max = 1e-9\nreason = 'it is exact'\n")
        gate = ["gate", *self.words, "--tolerances", "gates.toml"]
        self.run_all("--tolerances", "gates.toml")
        self.atwood(*gate)
        self.path("gain.py", "GAIN = 1.01\n")
        self.run_all("--tolerances", "gates.toml", code=1)
        self.atwood(*gate, code=1)
        # Another command's measurements are not a run's.
        self.path("gain.py", "GAIN = 1.0\n")
        self.atwood("compare", "mine/one", "atwood/rk4", "--engine", "./engine.py", "--no-sandbox", "--scenario", "mine.toml", "--no-timing")
        self.atwood(*gate, code=1)

    def test_a_fingerprint_answers_for_all_of_the_code(self):
        self.write_engine(fingerprint="first")
        self.run_all(told=["mine 0 of 4 cells"])
        self.assertNotIn("campaign", self.run_all(told=["mine 4 of 4 cells"]).stderr)
        self.write_engine(fingerprint="second")
        self.run_all(told=["mine 0 of 4 cells"])

    def test_files_that_an_engine_lists_count(self):
        self.write_engine(fingerprint="one", files=["gain.py"])
        self.run_all(told=["mine 0 of 4 cells"])
        self.run_all(told=["mine 4 of 4 cells"])
        self.path("gain.py", "GAIN = 1.01\n")
        self.run_all(told=["mine 0 of 4 cells"])
        self.assertGreater(self.error(), 0.01)
        self.write_engine(fingerprint="one", files=["gian.py"])
        self.run_all(code=3, told=["hello lists the file `gian.py`, which does not exist"])

    def test_an_interrupted_run_goes_on_with_its_campaign(self):
        words = [ATWOOD, "run", *self.words, "--no-timing", "-j", "1"]
        with subprocess.Popen(words, cwd=self.here, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              env={**self.environment, "ENGINE_SLEEP": "0.3"}) as run:
            while self.runs() < 3:
                self.assertIsNone(run.poll(), "the process ended before it ran three cells")
                time.sleep(0.02)
            run.send_signal(signal.SIGINT)
            self.assertEqual(run.wait(30), 130)
        before = self.runs()
        self.assertLess(before, 4 + 1)
        self.run_all(told=["the campaign of an interrupted run goes on", "mine 2 of 4 cells"])
        self.assertEqual(self.runs(), before + 2)
        self.run_all(told=["mine 0 of 4 cells", "measured anew in its last campaign"])


class Damage(OwnEngine):
    def damage(self, statement):
        with sqlite3.connect(self.path("atwood-out/store.db")) as database:
            database.execute(statement)
        database.close()

    def test_damage_is_told_by_name_and_run_again(self):
        self.words = ["--method", "atwood/rk4", "--scenario", "mine.toml"]
        self.run_all()
        with open(self.path("rows.csv")) as file:
            expected = file.read()
        self.atwood("doctor", "--check-store", told=["sound"])
        self.damage("UPDATE measured SET rows = zeroblob(length(rows)) WHERE cell = (SELECT hash FROM cells WHERE steps = 128)")
        name = "mine, atwood/rk4, 128 steps"
        self.atwood("report", *self.words, code=5, told=[name, "atwood run"])
        self.atwood("gate", *self.words, code=5, told=[name])
        self.atwood("bless", *self.words, "--reason", "why", code=5, told=[name])
        self.atwood("doctor", "--check-store", code=5, told=[name])
        self.atwood("doctor", "--check-store", "--json", code=5, told=['"sound": false'])
        self.run_all(told=[f"the rows of the cell {name} are damaged; the cell runs again", "atwood 3 of 4 cells"])
        self.atwood("doctor", "--check-store", told=["sound"])
        with open(self.path("rows.csv")) as file:
            self.assertEqual([row[:15] for row in csv.reader(file)], [row[:15] for row in csv.reader(expected.splitlines())])
        self.damage("DELETE FROM cells WHERE steps = 64")
        for words, then in ((["run"], "move it away"), (["report"], "to move the file away"), (["gate"], "to move the file away")):
            self.atwood(*words, *self.words, code=5, told=["3 entries of `cells`, where 4 were written", then])
        self.atwood("doctor", "--check-store", code=5)

    def test_a_store_of_a_newer_atwood_is_not_called_damaged(self):
        self.atwood("run", "--method", "atwood/rk4", "--scenario", "mine.toml", "--no-timing")
        self.damage("PRAGMA user_version = 99")
        for words in (["doctor", "--check-store"], ["doctor", "--check-store", "--json"]):
            said = self.atwood(*words, code=2, told=["store.db: a newer atwood wrote it (schema 99; this one reads up to schema"])
            self.assertNotIn("damage", said.stdout + said.stderr)

    def test_a_store_that_is_none(self):
        out, store = self.path("atwood-out"), self.path("atwood-out/store.db")
        words = ["--method", "atwood/rk4", "--scenario", "mine.toml"]
        os.mkdir(out)
        self.path("atwood-out/store.db", "")
        self.atwood("gate", "--method", "atwood/rk4", "--scenario", "kepler-e0.6", code=1)  # gates, and no rows
        self.atwood("report", *words, code=2)
        self.atwood("bless", *words, "--reason", "why", code=2)
        self.atwood("doctor", "--check-store")
        self.atwood("run", *words, "--no-timing")
        self.damage("DROP TABLE measured")
        for command in ("gate", "report", "run"):
            self.atwood(command, *words, code=5, told=["no table `measured`"])
        os.remove(store)
        os.mkdir(store)
        for command in ("gate", "report", "run"):
            self.atwood(command, *words, code=5, told=["is a folder; expected a file"])
        os.rmdir(store)
        os.mkfifo(store)
        for command in ("gate", "report", "run"):
            self.atwood(command, *words, code=5, told=["not a regular file"])


class Bounds(OwnEngine):
    def test_a_study_of_too_many_cells_is_refused_at_once(self):
        values = ", ".join(str(i + 1) for i in range(300))
        study = self.path("wide.toml", "id = 'wide'\n[[cells]]\nscenarios = ['ballistic']\nsteps = [120]\n"
                          "methods = ['atwood/symplectic-euler+impulse']\n"
                          "sweep = { direct_points = [%s], iterations = [%s], substeps = [%s] }\n" % (values, values, values))
        self.atwood("run", study, code=2, told=["study `wide` plans up to 27000000 cells; at most 100000"])
        self.atwood("run", "--method", "atwood/rk4", "--scenario", "mine.toml", "--max-cells", "3", code=2,
                    told=["up to 4 cells", "at most 3", "--max-cells"])
        self.atwood("run", "--method", "atwood/rk4", "--scenario", "mine.toml", "--max-cells", "4", "--no-timing")

    def test_features_of_the_processor_are_part_of_a_cell(self):
        words = ["run", "--method", "atwood/rk4", "--scenario", "mine.toml", "--no-timing"]
        masked = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2_Usable"}
        self.atwood(*words, told=["atwood 0 of 4 cells"])
        self.atwood(*words, told=["atwood 0 of 4 cells", "truth 0 of 1"], **masked)
        self.atwood(*words, told=["atwood 4 of 4 cells"])
        self.atwood("doctor", told=["features", "glibc.cpu.hwcaps=-AVX2_Usable", "libm      glibc"], **masked)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
