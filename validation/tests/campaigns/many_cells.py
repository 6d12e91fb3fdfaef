#!/usr/bin/env python3
"""Measures a study of N synthetic cells through the real path: planning, cells stored a second, resuming, gate, report, 16
shards, one process that leases all chunks, and the merge of the shards, each with its peak memory, and the store's bytes a
cell. Several N: how each figure grows, as N to which power (least squares over all N, in logarithms). Times of the processor
are of all cores and of the workers.

    python3 validation/tests/campaigns/many_cells.py build/release/bin/atwood [N ...]
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
SCENE = """id = "drift"
title = "A body that drifts"
claim = "It keeps its velocity."
tags = ["smooth"]
[run]
t_end_s = 1.0
steps = [8, 16, 32, 64]
samples = 4
[[body]]
name = "body"
mass_kg = 1.0
position_m = [0, 0, 0]
velocity_m_per_s = [1, 0, 0]
[truth]
kind = "extended"
"""
GATES = """[[gate]]
scenario = "drift"
method = "instant/*"
metric = "error-position-end"
max = 1
reason = "Synthetic."
"""


class Bench:
    def __init__(self, atwood, cells):
        self.atwood, self.cells = os.path.abspath(atwood), cells
        self.folder = tempfile.TemporaryDirectory(dir=os.environ.get("ATWOOD_SCRATCH"))
        self.here = self.folder.name
        self.figures = {"cells": cells}
        a = max(1, round(math.sqrt(cells / 4)))
        b = max(1, cells // (4 * a))
        self.planned = 4 * a * b
        for name, text in (("drift.toml", SCENE), ("gates.toml", GATES),
                           ("many.toml", 'id = "many"\nengines = [["./instant"]]\n[[cells]]\nscenarios = ["drift.toml"]\n'
                                         'methods = ["instant/one"]\nsweep = { a = %s, b = %s }\n'
                                         % (list(range(1, a + 1)), list(range(1, b + 1))))):
            with open(os.path.join(self.here, name), "w") as file:
                file.write(text)
        subprocess.run(["cc", "-O2", os.path.join(HERE, "instant_engine.c"), "-o", os.path.join(self.here, "instant")], check=True)

    def call(self, name, *words):
        command = [self.atwood, *words] + (["--max-cells", str(4 * self.planned)] if words[0] != "merge" else [])
        started = time.time()
        with open(os.path.join(self.here, name + ".log"), "w") as log:
            process = subprocess.Popen(command, cwd=self.here, stdout=log, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(process.pid, 0)
        seconds = time.time() - started
        # Of several calls of one name: their times together, and the largest memory.
        for figure, value in ((" s", seconds), (" cpu s", usage.ru_utime + usage.ru_stime)):
            self.figures[name + figure] = round(self.figures.get(name + figure, 0) + value, 3)
        self.figures[name + " MB"] = max(self.figures.get(name + " MB", 0), round(usage.ru_maxrss / 1024, 1))
        code = os.waitstatus_to_exitcode(status)
        if code not in ((0, 1) if name == "gate" else (0,)):  # 1: a gate is not met
            with open(os.path.join(self.here, name + ".log")) as log:
                sys.exit(f"{name}: exit code {code}\n{log.read()[-2000:]}")
        return seconds

    def measure(self, shards=16):
        study = ["many.toml", "--tolerances", "gates.toml"]
        self.call("plan", "run", "many.toml", "--dry-run")
        seconds = self.call("run", "run", *study, "--no-timing", "--keep", "none", "--quiet", "--shard", "1/1", "--out", "one")
        self.figures["cells a second"] = round(self.planned / seconds)
        self.call("resume", "run", *study, "--no-timing", "--keep", "none", "--quiet", "--shard", "1/1", "--out", "one")
        os.makedirs(os.path.join(self.here, "atwood-out"))
        os.rename(os.path.join(self.here, "one/shard-1-of-1.db"), os.path.join(self.here, "atwood-out/store.db"))
        self.figures["bytes a cell"] = round(os.path.getsize(os.path.join(self.here, "atwood-out/store.db")) / self.planned)
        self.call("gate", "gate", *study, "--quiet")
        self.call("report", "report", *study)
        self.figures["page MB"] = round(os.path.getsize(os.path.join(self.here, "atwood-out/report.html")) / 1e6, 2)
        for shard in range(1, shards + 1):
            self.call("shard", "run", *study, "--no-timing", "--keep", "none", "--quiet", "--shard", f"{shard}/{shards}", "--out", "shards")
        self.call("lease", "run", *study, "--no-timing", "--keep", "none", "--quiet", "--lease", "chunks", "--out", "leased")
        self.call("merge", "merge", *[f"shards/shard-{i}-of-{shards}.db" for i in range(1, shards + 1)], "-o", "all.db")
        self.folder.cleanup()
        return self.figures


def power(points):
    """The slope of the line of least squares through (N, figure), in logarithms."""
    logs = [(math.log(n), math.log(figure)) for n, figure in points]
    x, y = (sum(values) / len(logs) for values in zip(*logs))
    return sum((a - x) * (b - y) for a, b in logs) / sum((a - x) ** 2 for a, _ in logs)


def main():
    atwood, sizes = sys.argv[1], [int(float(word)) for word in sys.argv[2:]] or [1000, 4000, 16000]
    all_figures = []
    for size in sizes:
        all_figures.append(Bench(atwood, size).measure())
        print(json.dumps(all_figures[-1]), flush=True)
    if len(sizes) > 1:
        for name in all_figures[0]:
            if name.endswith((" s", " MB")) and all(figures[name] > 0 for figures in all_figures):
                print(f"{name}: N^{power([(figures['cells'], figures[name]) for figures in all_figures]):.2f}")


if __name__ == "__main__":
    main()
