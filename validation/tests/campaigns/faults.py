#!/usr/bin/env python3
"""Lets the n-th call to the system fail, for every n of a study of two cells until it passes: each run must end with a
message and a documented exit code, leave nothing half-written, and the same command must then go on to the same export.

    python3 validation/tests/campaigns/faults.py build/release/bin/atwood [--kinds write,sync,rename,open,map]
        [--every 1] [--allocations 1000] [--seed 1]
"""
import argparse
import collections
import csv
import errno
import os
import random
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SCENE = """id = "drift"
title = "A body that drifts"
claim = "It keeps its velocity."
tags = ["smooth"]
[run]
t_end_s = 1.0
steps = [8, 16]
samples = 4
[[body]]
name = "body"
mass_kg = 1.0
position_m = [0, 0, 0]
velocity_m_per_s = [1, 0, 0]
[truth]
kind = "extended"
"""
STUDY = """id = "two"
[[cells]]
scenarios = ["drift.toml"]
methods = ["atwood/rk4"]
"""
MACHINE = ("commit", "compiler", "flags", "cpu", "run_id")
# write: also those of which the store is told that the disk is full.
ERRORS = {"write": (errno.EIO, errno.ENOSPC), "sync": (errno.EIO,), "rename": (errno.EACCES,), "open": (errno.EMFILE, errno.EACCES),
          "map": (errno.ENOMEM,), "memory": (errno.ENOMEM,)}


class Campaign:
    def __init__(self, atwood):
        self.folder = tempfile.TemporaryDirectory()
        self.here = os.path.realpath(self.folder.name)
        # The program beside few workers: each of its runs begins by asking them all.
        os.mkdir(self.path("bin"))
        for name in ("atwood", "atwood-engine", "atwood-truth"):
            shutil.copy(os.path.join(os.path.dirname(os.path.abspath(atwood)), name), self.path("bin"))
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", os.path.join(HERE, "fault_shim.c"), "-o", self.path("shim.so"), "-ldl"], check=True)
        for name, text in (("drift.toml", SCENE), ("two.toml", STUDY)):
            with open(self.path(name), "w") as file:
                file.write(text)
        self.ended = collections.Counter()
        self.expected = None
        code, told, _, _ = self.call()
        assert code == 0, told
        self.expected = self.export()
        assert len(self.expected) > 20, len(self.expected)

    def path(self, name):
        return os.path.join(self.here, name)

    def call(self, kind="", at=0, error=errno.EIO):
        """The exit code, what was told, how many calls were counted, and whether one of them failed."""
        # The copied program has no catalogue beside it.
        environment = {"ATWOOD_ROOT": os.path.join(HERE, "../../.."), **os.environ}
        if kind:
            environment.update(LD_PRELOAD=self.path("shim.so"), FAULT_PROGRAM="atwood", FAULT_CALLS=kind, FAULT_AT=str(at),
                               FAULT_ERRNO=str(error), FAULT_TOLD=self.path("told"))
        if os.path.exists(self.path("told")):
            os.unlink(self.path("told"))
        ended = subprocess.run([self.path("bin/atwood"), "run", "two.toml", "--no-timing", "-j", "1", "--out", "out", "-o", "csv:rows.csv"],
                               cwd=self.here, env=environment, capture_output=True, text=True, errors="replace", timeout=300)
        counted = failed = 0
        if kind and os.path.exists(self.path("told")):
            with open(self.path("told")) as file:
                words = file.read().split()
            counted, failed = (int(words[0]), int(words[1])) if words else (0, 1)  # none: it was ended by a signal
        # Of a cell that failed the table on standard output tells.
        return ended.returncode, ended.stderr + (ended.stdout if ended.returncode == 3 else ""), counted, failed

    def export(self):
        with open(self.path("rows.csv"), newline="") as file:
            return [{name: text for name, text in row.items() if name not in MACHINE} for row in csv.DictReader(file)]

    def clean(self):
        shutil.rmtree(self.path("out"), ignore_errors=True)
        if os.path.exists(self.path("rows.csv")):
            os.unlink(self.path("rows.csv"))

    def require_whole(self, what):
        """Each document is there whole, or not at all; nothing temporary stays."""
        allowed = {"report.html", "index.html", "reports"}
        for base in ("store", "history"):
            allowed |= {base + end for end in (".db", ".db-wal", ".db-shm", ".db-journal")}
        if os.path.isdir(self.path("out")):
            assert set(os.listdir(self.path("out"))) <= allowed, (what, os.listdir(self.path("out")))
        if os.path.exists(self.path("out/report.html")):
            with open(self.path("out/report.html")) as file:
                assert file.read().rstrip().endswith("</html>"), (what, "half a page")
        if os.path.exists(self.path("rows.csv")):
            with open(self.path("rows.csv")) as file:
                assert file.read().endswith("\n"), (what, "half a csv file")
        known = {"bin", "shim.so", "drift.toml", "two.toml", "out", "rows.csv", "told"}
        assert set(os.listdir(self.here)) <= known, (what, os.listdir(self.here))

    def one(self, kind, at, error):
        """False: the study has fewer calls of this kind."""
        self.clean()
        code, told, _, failed = self.call(kind, at, error)
        what = f"{kind} {at} ({errno.errorcode[error]}): exit code {code}: {told.strip()[-500:]}"
        if not failed:
            assert code == 0, what
            return False
        # 0: the program can do without that call. 2: a file of the user's cannot be read. 3: an engine could not be asked.
        assert code in (0, 2, 3, 5), what
        assert code == 0 or told.strip(), what + "no message"
        self.require_whole(what)
        if code == 0 and self.export() != self.expected:
            raise AssertionError(what + ": other figures, and no word about it")
        again, told_then, _, _ = self.call()
        if again == 3:  # a worker's row is repeated by the next run
            again, told_then, _, _ = self.call()
        assert again == 0, f"{what}; then {again}: {told_then}"
        assert self.export() == self.expected, what + ": the export after it differs"
        self.ended[kind, code] += 1
        return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("atwood")
    parser.add_argument("--kinds", default="write,sync,rename,open,map")
    parser.add_argument("--every", type=int, default=1, help="of the calls only each of these")
    parser.add_argument("--allocations", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep-going", action="store_true", help="list what fails instead of ending")
    asked = parser.parse_args()
    campaign = Campaign(asked.atwood)
    wrong = []

    def attempt(kind, at, error):
        try:
            return campaign.one(kind, at, error)
        except (AssertionError, subprocess.TimeoutExpired) as failure:
            if not asked.keep_going:
                raise
            wrong.append(failure)
            print(failure, flush=True)
            return True

    for kind in filter(None, asked.kinds.split(",")):
        for error in ERRORS[kind]:
            at = 1
            while attempt(kind, at, error):
                at += asked.every
    if asked.allocations > 0:
        campaign.clean()
        _, _, count, _ = campaign.call("memory", 0)
        chosen = random.Random(asked.seed)
        for _ in range(asked.allocations):
            attempt("memory", chosen.randint(1, count), errno.ENOMEM)
        print(f"{count} allocations, of which {asked.allocations} failed")
    for (kind, code), count in sorted(campaign.ended.items()):
        print(f"{count:6} {kind}: exit code {code}")
    print(f"{sum(campaign.ended.values())} calls failed; each run after one gave the undisturbed export")
    if wrong:
        sys.exit(f"{len(wrong)} went wrong")


if __name__ == "__main__":
    main()
