"""Shares of a study, chunks from a shared directory, and the merge of their stores."""
import csv
import itertools
import json
import os
import signal
import shutil
import sqlite3
import subprocess
import sys
import time
import unittest

from case import ATWOOD
from stored_cells_test import OwnEngine

STUDY = """id = "small"
[[cells]]
scenarios = ["ballistic", "oscillator", "kepler-e0.3"]
methods = ["atwood/rk4", "atwood/heun", "atwood/midpoint"]
"""
LOGGING_ENGINE = '{ command = ["./engine.py"], sandbox = false }'
MACHINE = ("commit", "compiler", "flags", "cpu", "cpu_features", "libm", "run_id")  # columns of a run and its machine


class Shards(OwnEngine):
    def setUp(self):
        super().setUp()
        for name in list(self.environment):
            if name.startswith(("SLURM_", "OMPI_", "PMI_", "JOB_COMPLETION")):
                del self.environment[name]
        self.path("small.toml", STUDY)

    def shard(self, share, *more, out="shards", study="small.toml", **how):
        return self.atwood("run", study, "--no-timing", "--shard", share, "--out", out, *more, **how)

    def stores(self, out="shards"):
        return sorted(os.path.join(out, name) for name in os.listdir(self.path(out)) if name.endswith(".db"))

    def merge(self, *stores, out="all/store.db", **how):
        os.makedirs(os.path.dirname(self.path(out)), exist_ok=True)
        return self.atwood("merge", *stores, "-o", out, **how)

    def rows(self, out, *study):
        """The export, without the columns of the run and its machine."""
        self.atwood("report", *(study or ["small.toml"]), "--out", out, "-o", f"csv:{out}.csv")
        with open(self.path(out + ".csv"), newline="") as file:
            return [{name: text for name, text in row.items() if name not in MACHINE} for row in csv.DictReader(file)]


class Merged(Shards):
    def test_a_merge_equals_a_single_run(self):
        self.atwood("run", "small.toml", "--no-timing", "--out", "single")
        for share in ("1/3", "2/3", "3/3"):
            self.shard(share, told=["share " + share.replace("/", " of ")])
        self.assertFalse(os.path.exists(self.path("shards/report.html")))
        stores = self.stores()
        self.assertEqual(len(stores), 3)
        cells = json.loads(self.merge(*reversed(stores), "--json").stdout)
        self.assertEqual((cells["absent"], cells["twice"]), ([], 0))
        expected = self.rows("single")
        self.assertGreater(len(expected), 100)
        self.assertEqual(self.rows("all"), expected)
        self.atwood("run", "small.toml", "--no-timing", "--out", "all", told=["nothing to do", "0 of 9 cells"][:1])
        self.merge(*stores, code=2, told=["exists already"])
        # A cell in several stores, with the same results: a free test of determinism.
        self.merge(*stores, "single/store.db", out="more/store.db", told=["in several, with the same results"])
        self.assertEqual(self.rows("more"), expected)

    def test_the_order_of_stores_changes_no_byte_of_the_merged_one(self):
        # Truths and provenances are in several stores, cells in one.
        shares = ("1/3", "2/3", "3/3")
        for share in shares:
            self.shard(share)
        stores = self.stores()
        merged = []
        for number, order in enumerate(itertools.permutations(stores)):
            self.merge(*order, out=f"order{number}/store.db")
            with open(self.path(f"order{number}/store.db"), "rb") as file:
                merged.append(file.read())
        self.assertEqual(len(merged), 6)
        self.assertGreater(len(merged[0]), 10000)
        self.assertEqual(len(set(merged)), 1)
        self.atwood("doctor", "--check-store", "--out", "order0", told=["sound"])
        # Entry by entry those of a single run, but for what tells of runs, machines and shares.
        self.atwood("run", "small.toml", "--no-timing", "--out", "single")
        self.assertEqual(self.entries("order0"), self.entries("single"))

    def entries(self, out):
        """Every entry of the store, without the columns of the run and its machine."""
        found = {}
        with sqlite3.connect(self.path(out + "/store.db")) as database:
            for table, columns in (("cells", "hash, scenario, method, steps, status, reason, steps_taken, rate_evaluations, "
                                             "limit_s, killed_from_outside"),
                                   ("series", "*"), ("measured", "*"), ("truths", "*")):
                found[table] = database.execute(f"SELECT {columns} FROM {table} ORDER BY 1").fetchall()
                self.assertGreater(len(found[table]), 2)
        database.close()
        return found

    def test_cells_that_no_store_has_are_listed(self):
        for share in ("1/3", "3/3"):
            self.shard(share)
        told = json.loads(self.merge(*self.stores(), "--json").stdout)
        missing = json.loads(self.shard("2/3", "--dry-run", "--json").stdout)["shares"][1]["cells"]
        self.assertEqual(told["absent"], sorted(missing))
        self.merge("shards/shard-1-of-3.db", "nowhere.db", out="none.db", code=2, told=["nowhere.db: no such file"])
        self.assertFalse(os.path.exists(self.path("none.db")))

    def test_different_results_of_one_cell_are_told_and_nothing_is_written(self):
        self.write_engine(fingerprint="always the same")
        self.atwood("run", *self.words, "--no-timing", "--out", "one")
        self.path("gain.py", "GAIN = 1.01\n")
        self.atwood("run", *self.words, "--no-timing", "--out", "two")
        told = self.merge("one/store.db", "two/store.db", code=1,
                          told=["recording of mine, mine/one, 64 steps", "rows of mine, mine/one, 512 steps",
                                "one/store.db has", "two/store.db has"])
        self.assertNotIn("atwood/rk4", told.stderr)
        self.assertEqual(os.listdir(self.path("all")), [])

    def test_a_campaign_of_shards_is_one(self):
        self.path("campaign.toml", f'id = "campaign"\nengines = [{LOGGING_ENGINE}]\n[[cells]]\nscenarios = ["mine.toml", "ballistic"]\n'
                                   'methods = ["mine/one"]\n')
        for generation in range(2):  # code that is not fully known is measured again by the next run
            for share in ("1/2", "2/2"):
                self.shard(share, study="campaign.toml", told=["mine: a new campaign"])
            self.merge(*self.stores(), out=f"all{generation}/store.db")
            steps = {(row["scenario"], row["steps"]) for row in self.rows(f"all{generation}", "campaign.toml") if row["steps"] != "0"}
            self.assertGreater(len(steps), 7)
            self.atwood("gate", "campaign.toml", "--out", f"all{generation}")


class Split(Shards):
    def shares(self, count, *more, **environment):
        return json.loads(self.atwood("run", "small.toml", "--shard", f"1/{count}", "--dry-run", "--json", *more,
                                      **environment).stdout)["shares"]

    def test_shares_are_whole_ladders_of_about_the_same_cost(self):
        whole = self.shares(1)[0]
        for count in (2, 4, 20):
            shares = self.shares(count)
            self.assertEqual(len(shares), count)
            self.assertEqual(sorted(cell for share in shares for cell in share["cells"]), sorted(whole["cells"]))
            ladders = [{cell.rsplit(",", 1)[0] for cell in share["cells"]} for share in shares]
            self.assertEqual(sum(map(len, ladders)), len(set().union(*ladders)))
            self.assertEqual(len(set().union(*ladders)), 9)
        self.assertFalse(os.path.exists(self.path("atwood-out")))

    def test_a_launcher_gives_the_share(self):
        launchers = [({"SLURM_ARRAY_TASK_ID": "7", "SLURM_ARRAY_TASK_COUNT": "4", "SLURM_ARRAY_TASK_MIN": "3",
                       "SLURM_ARRAY_TASK_STEP": "2", "SLURM_ARRAY_TASK_MAX": "9"}, "3/4"),
                     ({"SLURM_PROCID": "1", "SLURM_NTASKS": "2"}, "2/2"),
                     ({"OMPI_COMM_WORLD_RANK": "0", "OMPI_COMM_WORLD_SIZE": "3", "SLURM_PROCID": "0", "SLURM_NTASKS": "1"}, "1/3"),
                     ({"PMI_RANK": "4", "PMI_SIZE": "5"}, "5/5"),
                     ({"JOB_COMPLETION_INDEX": "1", "JOB_COMPLETIONS": "8"}, "2/8"),
                     ({"SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_COUNT": "2", "SLURM_ARRAY_TASK_MIN": "0",
                       "SLURM_PROCID": "2", "SLURM_NTASKS": "3"}, "6/6"),
                     # A batch script runs once for all of its job's tasks.
                     ({"SLURM_JOB_ID": "9", "SLURM_PROCID": "0", "SLURM_NTASKS": "4"}, None),
                     ({}, None)]
        for variables, share in launchers:
            with self.subTest(variables):
                told = self.atwood("run", "small.toml", "--dry-run", **variables).stdout
                mine = [line.split()[0] for line in told.splitlines() if line.endswith("<- this process")]
                self.assertEqual(mine, [share] if share else [])
        wrong = [({"SLURM_ARRAY_TASK_ID": "1"}, "SLURM_ARRAY_TASK_COUNT is not"),
                 ({"SLURM_ARRAY_TASK_ID": "7", "SLURM_ARRAY_TASK_COUNT": "3", "SLURM_ARRAY_TASK_MIN": "1",
                   "SLURM_ARRAY_TASK_MAX": "7"}, "not numbered evenly"),
                 ({"JOB_COMPLETION_INDEX": "1"}, "JOB_COMPLETIONS is not"),
                 ({"PMI_RANK": "2", "PMI_SIZE": "2"}, "expected a smaller rank"),
                 ({"PMI_RANK": "two", "PMI_SIZE": "2"}, "expected a whole number")]
        for variables, words in wrong:
            with self.subTest(variables):
                self.atwood("run", "small.toml", "--dry-run", code=2, told=[words], **variables)
                self.atwood("run", "small.toml", "--dry-run", "--shard", "1/2", **variables)  # it outweighs them
        for share in ("0/2", "3/2", "1", "1/", "/2", "-1/2", "1/2/3", "1.5/2", " 1/2", "1/9999999999"):
            with self.subTest(share):
                self.atwood("run", "small.toml", "--dry-run", f"--shard={share}", code=2, told=["expected I/N"])

    def test_costs_of_a_store_decide_the_split(self):
        self.atwood("costs", "small.toml", "-o", "costs.json", code=2, told=["no store"])
        self.atwood("run", "small.toml", "--no-timing")
        self.atwood("costs", "small.toml", "-o", "costs.json")
        with open(self.path("costs.json")) as file:
            costs = json.load(file)
        name = "ballistic, atwood/heun"
        for ladder in costs["wall_ns_by_steps"]:
            costs["wall_ns_by_steps"][ladder] = [[rung[0], 1e12 if ladder == name else 1] for rung in costs["wall_ns_by_steps"][ladder]]
        self.path("costs.json", json.dumps(costs))
        first, *others = self.shares(2, "--costs", "costs.json")
        self.assertGreater(first["cost_ns"], 1e12)
        self.assertTrue(first["cells"][0].startswith("ballistic"))
        self.assertIn(name, {cell.rsplit(",", 1)[0] for cell in first["cells"]})
        self.shard("1/2", "--costs", "costs.json")
        self.shard("2/2")
        self.merge(*self.stores(), code=2, told=["different costs", "run all shards with the same --costs"])
        for text in ("", "{}", "[1]", '{"format": "atwood costs 1", "wall_ns_by_steps": {"a": [[0, 1]]}}',
                     '{"format": "atwood costs 1", "wall_ns_by_steps": {"a": [[1, -1]]}}'):
            self.path("wrong.json", text)
            self.shard("1/2", "--costs", "wrong.json", code=2, told=["wrong.json"])
        self.atwood("run", "small.toml", "--costs", "costs.json", code=2, told=["--costs decides how a study is split"])

    def test_a_share_runs_its_dearest_ladder_first(self):
        """By steps times bodies, or by the file of costs; the order of rows stays that of the study."""
        self.write_engine(fingerprint="one")
        with open(self.path("mine.toml")) as file:
            scene = file.read()
        steps = {"a": 128, "b": 512, "c": 64, "d": 256}
        for name, count in steps.items():
            self.path(f"{name}.toml", scene.replace('"mine"', f'"{name}"').replace("[64, 128, 256, 512]", f"[{count}]"))
        self.path("small.toml", f'id = "small"\nengines = [{LOGGING_ENGINE}]\n[[cells]]\n'
                                f'scenarios = {json.dumps([name + ".toml" for name in steps])}\nmethods = ["mine/one"]\n')
        self.atwood("run", "small.toml", "--no-timing", "-j", "1", "--out", "single")
        self.assertEqual(self.steps_run(), [128, 512, 64, 256])  # a whole study in its order
        self.shard("1/1", "-j", "1")
        self.assertEqual(self.steps_run(), [512, 256, 128, 64])
        self.atwood("costs", "small.toml", "--out", "single", "-o", "costs.json")
        with open(self.path("costs.json")) as file:
            costs = json.load(file)
        for name, cost in (("a", 2e9), ("b", 1e9), ("c", 4e9), ("d", 3e9)):
            ladder = f"{name}, mine/one"
            costs["wall_ns_by_steps"][ladder] = [[rung[0], cost] for rung in costs["wall_ns_by_steps"][ladder]]
        self.path("costs.json", json.dumps(costs))
        self.shard("1/1", "-j", "1", "--costs", "costs.json", out="by-costs")
        self.assertEqual(self.steps_run(), [64, 256, 128, 512])
        expected = self.rows("single")
        for out in ("shards", "by-costs"):
            self.merge(f"{out}/shard-1-of-1.db", out=f"{out}-all/store.db")
            self.assertEqual(self.rows(f"{out}-all"), expected)

    def steps_run(self):
        """The step counts of the runs since the last call, in the order of the engine's log."""
        with open(self.path("engine.log"), "r+") as file:
            steps = [int(line.split()[1]) for line in file]
            file.truncate(0)
        return steps

    def test_a_share_makes_no_documents(self):
        for words in (["-o", "csv:rows.csv"], ["--junit", "j.xml"], ["--json"]):
            self.shard("1/2", *words, code=2, told=["atwood merge"])


class Leases(Shards):
    def start(self, number, **environment):
        words = [ATWOOD, "run", "slow.toml", "--no-timing", "-j", "1", "--lease", "chunks", "--lease-expiry", "2", "--out", "shards",
                 "--shard", f"{number}/3"]
        return subprocess.Popen(words, cwd=self.here, env={**self.environment, **environment}, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def test_the_chunk_of_a_dead_process_is_taken_again(self):
        self.write_engine(fingerprint="one")
        scenes = []
        for i in range(8):
            with open(self.path("mine.toml")) as file:
                scenes.append(os.path.basename(self.path(f"mine{i}.toml", file.read().replace('"mine"', f'"mine{i}"').replace("mass_kg = 2.0", f"mass_kg = {2 + i}.0"))))
        self.path("slow.toml", f'id = "slow"\nengines = [{LOGGING_ENGINE}]\n[[cells]]\nscenarios = {json.dumps(scenes)}\n'
                               'methods = ["mine/one"]\n')
        dead = self.start(1, ENGINE_SLEEP="0.2")
        while self.runs() < 2:
            self.assertIsNone(dead.poll(), "the process ended before it ran two cells")
            time.sleep(0.02)
        dead.send_signal(signal.SIGKILL)
        dead.communicate()
        before = self.runs()
        self.assertLess(before, 8)
        others = [self.start(number) for number in (2, 3)]
        for other in others:
            told = other.communicate(timeout=100)
            self.assertEqual(other.returncode, 0, told)
        self.assertEqual(len(os.listdir(self.path("chunks"))), 1)
        place = self.path("chunks/" + os.listdir(self.path("chunks"))[0])
        self.assertEqual((os.listdir(place + "/todo"), os.listdir(place + "/taken"), len(os.listdir(place + "/done"))), ([], [], 8))
        told = json.loads(self.merge(*self.stores(), "--json").stdout)
        self.assertEqual((told["cells"], told["absent"]), (32, []))
        self.assertLessEqual(self.runs(), 32 + before)
        self.atwood("run", "slow.toml", "--no-timing", "--out", "all", told=["nothing to do"])
        # A directory with the chunks of another study.
        self.shard("1/3", "--lease", "chunks", code=5, told=["chunks of another study"])


class Kept(Shards):
    def recordings(self, out):
        with sqlite3.connect(self.path(out + "/store.db")) as database:
            kept = database.execute("SELECT kept, count(*) FROM series GROUP BY kept").fetchall()
        database.close()
        return dict(kept)

    def test_recordings_that_are_not_kept_change_no_row(self):
        study = ["run", "small.toml", "--no-timing", "--out"]
        self.atwood(*study, "all")
        self.atwood(*study, "worst", "--keep", "worst")
        told = self.atwood(*study, "none", "--keep", "none").stderr
        named = told.split("without running their cells again: ")[1].splitlines()[0].split(", ")
        measured = {row["metric"] for row in self.rows("all") if row["steps"] not in ("", "0")} - {"status", "truth"}
        self.assertEqual(set(named), measured)
        self.assertEqual(named, sorted(named))
        self.assertIn("error-position-end", named)
        self.assertNotIn("order-position", named)  # fitted to stored rows
        expected = self.rows("all")
        self.assertEqual(self.rows("worst"), expected)
        self.assertEqual(self.rows("none"), expected)
        cells = sum(self.recordings("all").values())
        self.assertEqual(self.recordings("all"), {"all": cells})
        self.assertEqual(self.recordings("worst"), {"all": 9, "end": cells - 9})
        self.assertEqual(self.recordings("none"), {"end": cells})
        sizes = {out: os.path.getsize(self.path(out + "/store.db")) for out in ("all", "worst", "none")}
        self.assertLess(sizes["none"], sizes["worst"])
        self.assertLess(sizes["worst"], sizes["all"])  # what was dropped is given back
        self.atwood(*study, "none", told=["nothing to do"])
        self.atwood("doctor", "--check-store", "--out", "none", told=["sound"])
        self.atwood("merge", "all/store.db", "none/store.db", "-o", "both.db", told=["with the same results"])
        os.makedirs(self.path("both"))
        shutil.move(self.path("both.db"), self.path("both/store.db"))
        self.assertEqual(self.recordings("both"), {"all": cells})
        self.atwood(*study, "other", "--keep", "some", code=2)

    def test_a_network_file_system_gets_a_rollback_journal(self):
        run = ["run", "small.toml", "--no-timing"]
        self.atwood(*run, ATWOOD_STORE_JOURNAL="rollback", told=["rollback journal"])
        with sqlite3.connect(self.path("atwood-out/store.db")) as database:
            self.assertEqual(database.execute("PRAGMA journal_mode").fetchone(), ("delete",))
            database.execute("BEGIN EXCLUSIVE")
            self.atwood(*run, ATWOOD_STORE_JOURNAL="rollback", code=5, told=["is in use by another program"])
            database.execute("ROLLBACK")
        database.close()
        self.atwood(*run, ATWOOD_STORE_JOURNAL="rollback", told=["nothing to do"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
