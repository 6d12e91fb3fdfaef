#!/usr/bin/env python3
"""Lets the n-th call to the system fail, for every n of a study of two cells until it passes: each run must end with a
message and exit code 5, or do without that call where EXPECTED says why it can; leave nothing half-written and a sound
store; and the same command must then go on to the same export.

    python3 validation/tests/campaigns/faults.py build/release/bin/atwood [--kinds read,write,sync,rename,remove,open,map]
        [--files store.db] [--every 1] [--allocations 1000] [--seed 1] [--stacks 0]

Of the allocations a random choice fails, most of which are in loops. With --stacks N the first allocation of every N-th call
stack fails as well; a call stack is its three innermost return addresses, and a run has some 4 000.
"""
import argparse
import collections
import csv
import errno
import os
import random
import re
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
GATES = """[[gate]]
scenario = "drift"
method = "*"
metric = "error-position-end"
max = 1e-9
reason = "it keeps its velocity"
"""
MACHINE = ("commit", "compiler", "flags", "cpu", "run_id")
# write: also those of which the store is told that the disk is full.
ERRORS = {"read": (errno.EIO,), "write": (errno.EIO, errno.ENOSPC), "sync": (errno.EIO,), "rename": (errno.EACCES,),
          "remove": (errno.EACCES,), "open": (errno.EMFILE, errno.EACCES), "map": (errno.ENOMEM,), "memory": (errno.ENOMEM,)}
# The calls whose failure may end otherwise than with exit code 5, the codes that are allowed then, and why. HERE: the folder
# of the study. The first that matches "CALL PATH" holds. 0 always asks for the undisturbed export.
EXPECTED = [
    (r"\w+ \w+ HERE/out/history\.db", (0,), "the history of runs decides no figure; what it lost is told"),
    (r"open \w+ (HERE/root/validation/\S+|(HERE/)?(drift|two))\.toml$", (0, 2, 5), "input that may not be read is named as "
     "input; 0 where it was read before, and is looked at again for the report"),
    (r"memory malloc", (0, 5), "done otherwise or again: the history of runs, the overview of the store, the search for "
     "descendants"),
    (r"read \w+ /dev/urandom", (0, 5), "the C++ library and SQLite have other sources of random numbers"),
    (r"\w+ \w+ /proc/cpuinfo", (0,), "the processor's name is a column of provenance, and no more"),
    (r"\w+ \w+ /proc/\d+/maps", (0,), "an engine whose code is not known: the next run measures its cells again"),
    (r"\w+ \w+ /proc/\d+/(task|environ|statm)", (0,), "the search for descendants, which processes leave at any time"),
    (r"open open (HERE/bin/|HERE/shim|/usr/lib/)", (0, 5), "code that may not be read is not known: the next run measures "
     "its cells again"),
    (r"open open (\.|out|out/reports)$", (0,), "a file that has a name from the beginning is written in its place"),
    (r"open open64 HERE/out$", (0,), "SQLite goes on where a folder cannot be synced"),
    (r"open \w+ /dev/", (0,), "a worker may then not write to this device, which keeps nothing"),
    (r"open \w+ /tmp/atwood-worker-\w+$", (0, 5), "without its lock a scratch directory works as well"),
    (r"read read pipe:", (0, 5), "a worker's standard error adds to messages alone; the trial of a confinement is told"),
    (r"rename linkat ", (0,), "where a file cannot be given a name, a temporary file is written in its place"),
    (r"rename rename out/(index|reports/\w+\.trends)\.html", (0,), "the index of reports is not renewed, which is told"),
    (r"remove unlink HERE/out/store\.db-(wal|shm)", (0,), "the log is in the file already; the next run removes it"),
    (r"open open64 HERE/out/store\.db$", (0, 5), "SQLite then opens it for reading, enough after the last write"),
    (r"sync fdatasync HERE/out$", (0,), "SQLite goes on where a folder cannot be synced"),
    (r"sync fsync HERE(/out|/out/reports)?$", (0,), "the file is whole and synced; its folder may not be"),
    (r"(sync fsync|write write) HERE/(out/)?(reports/)?#\d+", (0, 5), "a page that has no name yet: 0 where it is the index, "
     "which is told"),
]


class Campaign:
    def __init__(self, atwood):
        self.folder = tempfile.TemporaryDirectory()
        self.here = os.path.realpath(self.folder.name)
        # The program beside few workers: each of its runs begins by asking them all.
        os.mkdir(self.path("bin"))
        for name in ("atwood", "atwood-engine", "atwood-truth"):
            shutil.copy(os.path.join(os.path.dirname(os.path.abspath(atwood)), name), self.path("bin"))
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", os.path.join(HERE, "fault_shim.c"), "-o", self.path("shim.so"), "-ldl"], check=True)
        # A catalogue of one scene and one gate: a run reads all of it.
        for folder in ("scenarios/fluid", "gates"):
            os.makedirs(self.path("root/validation/" + folder))
        shutil.copytree(os.path.join(HERE, "../../study"), self.path("root/validation/study"), ignore=lambda _, names: [
            name for name in names if not name.endswith(".toml")])
        shutil.copy(os.path.join(HERE, "../../scenarios/ballistic.toml"), self.path("root/validation/scenarios"))
        for name, text in (("drift.toml", SCENE), ("two.toml", STUDY), ("root/validation/gates/drift.toml", GATES)):
            with open(self.path(name), "w") as file:
                file.write(text)
        self.environment = {**os.environ, "ATWOOD_ROOT": self.path("root")}
        self.ended = collections.Counter()
        self.expected = None
        code, told, _, _ = self.call()
        assert code == 0, told
        self.expected = self.export()
        assert len(self.expected) > 20, len(self.expected)

    def path(self, name):
        return os.path.join(self.here, name)

    def call(self, kind="", at=0, error=errno.EIO, files="", more=None):
        """The exit code, what was told, how many calls were counted, and the one that failed, as "CALL PATH", or ""."""
        environment = {**self.environment, **(more or {})}
        if kind:
            environment.update(LD_PRELOAD=self.path("shim.so"), FAULT_PROGRAM="atwood", FAULT_CALLS=kind, FAULT_AT=str(at),
                               FAULT_ERRNO=str(error), FAULT_TOLD=self.path("told"))
            if files:
                environment["FAULT_FILES"] = files
        if os.path.exists(self.path("told")):
            os.unlink(self.path("told"))
        ended = subprocess.run([self.path("bin/atwood"), "run", "two.toml", "--no-timing", "-j", "1", "--out", "out", "-o", "csv:rows.csv"],
                               cwd=self.here, env=environment, capture_output=True, text=True, errors="replace", timeout=300)
        counted, failed = 0, ""
        if kind and os.path.exists(self.path("told")):
            with open(self.path("told")) as file:
                for line in file:
                    word, _, rest = line.rstrip("\n").partition(" ")
                    counted, failed = (int(rest), failed) if word == "counted" else (counted, rest)
        # Of a cell that failed the table on standard output tells.
        return ended.returncode, ended.stderr + (ended.stdout if ended.returncode == 3 else ""), counted, failed.replace(self.here, "HERE")

    def stacks(self):
        """The call stacks that allocate, in the order in which they first do."""
        self.clean()
        code, told, _, _ = self.call("memory", more={"FAULT_STACKS": "1"})
        assert code == 0, told
        with open(self.path("told")) as file:
            return [line.split()[1] for line in file if line.startswith("stack ")]

    def check_store(self, what):
        if not os.path.exists(self.path("out/store.db")):
            return
        ended = subprocess.run([self.path("bin/atwood"), "doctor", "--check-store", "--out", "out"], cwd=self.here,
                               env=self.environment, capture_output=True, text=True)
        assert ended.returncode == 0, f"{what}; then the store is not sound: {ended.stdout} {ended.stderr}"

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
        known = {"bin", "root", "shim.so", "drift.toml", "two.toml", "out", "rows.csv", "told"}
        assert set(os.listdir(self.here)) <= known, (what, os.listdir(self.here))

    def one(self, kind, at, error, files="", stack=""):
        """False: the study has fewer calls of this kind."""
        self.clean()
        code, told, _, failed = self.call(kind, at, error, files, {"FAULT_STACK": stack} if stack else None)
        what = f"{kind} {stack or at} ({errno.errorcode[error]}), {failed}: exit code {code}: {told.strip()[-500:]}"
        if not failed:
            assert code == 0, what
            return False
        allowed, why = ((5,), "")
        for pattern, codes, reason in EXPECTED:
            if re.match(pattern, f"{kind} {failed}"):
                allowed, why = codes, reason
                break
        assert code in allowed, f"{what}; expected {' or '.join(map(str, allowed))}"
        assert code == 0 or told.strip(), what + "no message"
        self.require_whole(what)
        self.check_store(what)
        if code == 0 and self.export() != self.expected:
            raise AssertionError(what + ": other figures, and no word about it")
        again, told_then, _, _ = self.call()
        assert again == 0, f"{what}; then {again}: {told_then}"
        assert self.export() == self.expected, what + ": the export after it differs"
        self.ended[kind, code, why] += 1
        return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("atwood")
    parser.add_argument("--kinds", default="read,write,sync,rename,remove,open,map")
    parser.add_argument("--files", default="", help="only calls on files whose path contains this text")
    parser.add_argument("--every", type=int, default=1, help="of the calls only each of these")
    parser.add_argument("--allocations", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stacks", type=int, default=0, help="of the call stacks that allocate each of these; 0: none")
    parser.add_argument("--keep-going", action="store_true", help="list what fails instead of ending")
    asked = parser.parse_args()
    campaign = Campaign(asked.atwood)
    wrong = []

    def attempt(kind, at, error, stack=""):
        try:
            return campaign.one(kind, at, error, asked.files, stack)
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
    if asked.stacks > 0:
        stacks = campaign.stacks()
        assert len(stacks) > 1000, len(stacks)
        chosen_stacks = stacks[:: asked.stacks]
        failed = sum(attempt("memory", 0, errno.ENOMEM, stack) for stack in chosen_stacks)
        assert failed >= 0.9 * len(chosen_stacks), (failed, len(chosen_stacks))  # some depend on other processes
        print(f"{len(stacks)} call stacks that allocate, of which {failed} failed")
    for (kind, code, why), count in sorted(campaign.ended.items()):
        print(f"{count:6} {kind}: exit code {code}" + (f" ({why})" if why else ""))
    print(f"{sum(campaign.ended.values())} calls failed; each run after one gave the undisturbed export")
    if wrong:
        sys.exit(f"{len(wrong)} went wrong")


if __name__ == "__main__":
    main()
