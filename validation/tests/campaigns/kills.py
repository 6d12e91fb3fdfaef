#!/usr/bin/env python3
"""Kills runs, reports and merges at random instants, and goes on: the export must equal that of an undisturbed run, no cell
that was committed runs again, no process stays behind, no lock stays.

    python3 validation/tests/campaigns/kills.py build/release/bin/atwood [--kills 1000] [--seed 1] [--seconds S]
"""
import argparse
import collections
import csv
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time

ENGINE = """#!/usr/bin/env -S python3 -B
import json, os, sys, time
def say(answer):
    print(json.dumps(answer), flush=True)
for line in sys.stdin:
    r = json.loads(line)
    if r["request"] == "hello":
        say({"engine": "slow", "version": "1", "scalar": "double", "fingerprint": "1", "methods": [{"id": "slow/one", "doc": "one"}]})
        continue
    with open(os.environ["ENGINE_LOG"], "a") as log:
        log.write("%s %d\\n" % (r["scene"]["bodies"][0]["name"], r["steps"]))
    time.sleep(0.01)
    for k in range(r["samples"] + 1):
        t = r["t_end_s"] * k / r["samples"]
        say({"cell": r["cell"], "t_s": t, "bodies": [[t * (1 + 1 / r["steps"] ** 2), 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0]]})
    say({"cell": r["cell"], "done": {"status": "ok", "reason": "", "steps_taken": r["steps"], "rate_evaluations": 0}})
"""
SCENE = """id = "NAME"
title = "A body that drifts"
claim = "It keeps its velocity."
tags = ["smooth"]
[run]
t_end_s = 1.0
steps = [8, 16, 32, 64]
samples = 8
[[body]]
name = "NAME"
mass_kg = MASS
position_m = [0, 0, 0]
velocity_m_per_s = [1, 0, 0]
[truth]
kind = "extended"
"""
SCENES = 5
MACHINE = ("commit", "compiler", "flags", "cpu", "cpu_features", "libm", "run_id")


class Campaign:
    def __init__(self, atwood, seed):
        self.atwood = os.path.abspath(atwood)
        self.random = random.Random(seed)
        self.tag = f"atwood-kills-{os.getpid()}-{seed}"
        self.folder = tempfile.TemporaryDirectory()
        self.here = os.path.realpath(self.folder.name)
        self.environment = {**os.environ, "KILLS_TAG": self.tag, "ENGINE_LOG": os.path.join(self.here, "engine.log")}
        self.write("engine.py", ENGINE, 0o755)
        names = [f"drift{i}" for i in range(SCENES)]
        for i, name in enumerate(names):
            self.write(name + ".toml", SCENE.replace("NAME", name).replace("MASS", str(1.0 + i)))
        self.write("study.toml", 'id = "kills"\nengines = [{ command = "./engine.py", sandbox = false }]\n'  # it writes a log
                                 '[[cells]]\nscenarios = %s\n'
                                 'methods = ["slow/one", "atwood/rk4"]\n' % [name + ".toml" for name in names])
        self.done = collections.Counter()
        self.finish("calm")
        self.expected = self.export("calm")
        assert len(self.expected) > 100, len(self.expected)

    def write(self, name, text, mode=0o644):
        with open(os.path.join(self.here, name), "w") as file:
            file.write(text)
        os.chmod(file.name, mode)

    def path(self, name):
        return os.path.join(self.here, name)

    def start(self, *words):
        return subprocess.Popen([self.atwood, *words], cwd=self.here, env=self.environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)

    def call(self, *words):
        process = self.start(*words)
        _, told = process.communicate(timeout=120)
        return process.returncode, told

    def run_words(self, out):
        return ["run", "study.toml", "--out", out, "--no-timing", "-j", "2", "-o", f"csv:{out}.csv"]

    def finish(self, out):
        for _ in range(3):  # the row of a worker that was killed ends the first of them with 3
            code, told = self.call(*self.run_words(out))
            if code == 0:
                return
        raise AssertionError(f"exit code {code}: {told}")

    def export(self, out):
        with open(self.path(out + ".csv"), newline="") as file:
            return [{name: text for name, text in row.items() if name not in MACHINE} for row in csv.DictReader(file)]

    def members(self):
        """Processes of this campaign, by the variable in their environment."""
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/environ", "rb") as file:
                    if f"KILLS_TAG={self.tag}".encode() in file.read().split(b"\0"):
                        with open(f"/proc/{pid}/cmdline", "rb") as words:
                            found.append((int(pid), words.read().replace(b"\0", b" ").decode(errors="replace")))
            except OSError:
                continue
        return found

    def require_no_orphans(self):
        limit = time.time() + 10
        while self.members():
            assert time.time() < limit, f"processes that stay: {self.members()}"
            time.sleep(0.02)

    def committed(self, store):
        if not os.path.exists(store):
            return set()
        with sqlite3.connect(store) as database:
            try:
                cells = set(database.execute("SELECT scenario, steps FROM cells WHERE method='slow/one' AND killed_from_outside=0"))
            except sqlite3.OperationalError:  # killed before it had tables
                cells = set()
        database.close()
        return cells

    def log(self):
        if not os.path.exists(self.path("engine.log")):
            return []
        with open(self.path("engine.log")) as file:
            return [(line.split()[0], int(line.split()[1])) for line in file]

    def victim(self, parent, kind):
        if kind == "parent":
            return parent.pid
        wanted = {"worker": "engine.py", "truth": "atwood-truth"}[kind]
        some = [pid for pid, words in self.members() if wanted in words and pid != parent.pid]
        return self.random.choice(some) if some else None

    def disturb(self, words, kinds, seconds):
        """Starts a call and kills something of it after a random while. Which; None: it had ended."""
        process = self.start(*words)
        time.sleep(self.random.uniform(0, seconds))
        kind = self.random.choice(kinds)
        sent = self.random.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT]) if kind == "parent" else signal.SIGKILL
        victim = self.victim(process, kind) if process.poll() is None else None
        if victim:
            try:
                os.kill(victim, sent)
            except ProcessLookupError:
                victim = None
        _, told = process.communicate(timeout=120)
        allowed = {-signal.SIGKILL, 0, 3, 128 + signal.SIGTERM, 128 + signal.SIGINT, -signal.SIGTERM, -signal.SIGINT}
        if not victim or kind != "truth":
            assert process.returncode in allowed, (kind, sent, process.returncode, told)
        self.require_no_orphans()
        return f"{kind} by {sent.name}" if victim else None

    def one_run(self, kills):
        shutil.rmtree(self.path("out"), ignore_errors=True)
        took = self.calm_seconds
        for _ in range(kills):
            before = self.committed(self.path("out/store.db"))
            lines = len(self.log())
            kind = self.disturb(self.run_words("out"), ["parent", "parent", "worker", "truth"], took)
            again = before & set(self.log()[lines:])
            assert not again, f"committed cells that ran again: {again}"
            if kind:
                self.done[kind] += 1
        before, lines = self.committed(self.path("out/store.db")), len(self.log())
        self.finish("out")
        assert not before & set(self.log()[lines:])
        assert self.export("out") == self.expected, "the export differs"
        code, told = self.call("doctor", "--check-store", "--out", "out")
        assert code == 0, told

    def one_report(self):
        kind = self.disturb(["report", "study.toml", "--out", "out", "-o", "csv:report.csv"], ["parent"], self.calm_seconds / 2)
        page = self.path("out/report.html")
        with open(page) as file:
            assert file.read().rstrip().endswith("</html>"), "half a page"
        assert not [name for name in os.listdir(self.path("out")) if name.startswith("report.html.")] or kind, "a temporary file"
        if kind:
            self.done["report: " + kind] += 1

    def one_merge(self):
        for share in ("1/2", "2/2"):
            if not os.path.exists(self.path(f"shards/shard-{share[0]}-of-2.db")):
                assert self.call("run", "study.toml", "--out", "shards", "--no-timing", "--shard", share)[0] == 0
        shutil.rmtree(self.path("all"), ignore_errors=True)
        stores = [f"shards/shard-{i}-of-2.db" for i in (1, 2)]
        kind = self.disturb(["merge", *stores, "-o", "all/store.db"], ["parent"], 0.1)
        if not os.path.exists(self.path("all/store.db")):
            code, told = self.call("merge", *stores, "-o", "all/store.db")
            assert code == 0, told
        # A merge that was killed after it wrote the store may lack its entry in the history, or leave SQLite's journal of it.
        left = set(os.listdir(self.path("all")))
        assert left == {"store.db", "history.db"} or kind and {"store.db"} <= left <= {"store.db", "history.db", "history.db-journal"}, left
        code, told = self.call("report", "study.toml", "--out", "all", "-o", "csv:all.csv")
        assert code == 0, told
        assert self.export("all") == self.expected, "the merged export differs"
        if kind:
            self.done["merge: " + kind] += 1

    def go_on(self, kills, seconds):
        end = time.time() + seconds
        started = time.time()
        shutil.rmtree(self.path("calm"))
        self.finish("calm")
        self.calm_seconds = time.time() - started
        told = 0
        while sum(self.done.values()) < kills and time.time() < end:
            self.one_run(self.random.randint(1, 6))
            self.one_report()
            self.one_merge()
            so_far = sum(self.done.values())
            if sys.stderr.isatty():
                print(f"\r{so_far} kills", end="", file=sys.stderr)
            elif so_far >= told + 50:  # a log keeps what a campaign that is interrupted has covered
                told = so_far
                print(f"{so_far} kills", flush=True)
        return sum(self.done.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("atwood")
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1e9)
    asked = parser.parse_args()
    campaign = Campaign(asked.atwood, asked.seed)
    kills = campaign.go_on(asked.kills, asked.seconds)
    for kind, count in sorted(campaign.done.items()):
        print(f"{count:6} {kind}")
    print(f"{kills} kills; every export equals the undisturbed one")
    if kills < asked.kills:
        sys.exit(f"{asked.kills} kills were asked for, and the time was up after {kills}")


if __name__ == "__main__":
    main()
