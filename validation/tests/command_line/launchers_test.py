"""Real launchers give each of their processes a share: Open MPI's mpirun, Slurm's srun and arrays, the variables of an indexed
job. Skipped by name where there is none."""
import os
import shutil
import subprocess
import sys
import unittest

import one_machine_slurm
from case import ATWOOD
from shards_test import Shards


class Launchers(Shards):
    @unittest.skipUnless(shutil.which("mpirun"), "mpirun is not installed")
    def test_mpirun(self):
        words = ["mpirun", "-np", "2", "--oversubscribe"] + (["--allow-run-as-root"] if os.getuid() == 0 else [])
        run = [ATWOOD, "run", "small.toml", "--no-timing", "--out", "shards"]
        ended = subprocess.run([*words, *run], cwd=self.here, env=self.environment, text=True, capture_output=True, timeout=300)
        self.expect(ended, 0, "share 1 of 2 (OMPI_COMM_WORLD_RANK)", "share 2 of 2 (OMPI_COMM_WORLD_RANK)")
        self.assertEqual([os.path.basename(store) for store in self.stores()], ["shard-1-of-2.db", "shard-2-of-2.db"])
        self.merge(*self.stores())
        self.atwood("run", "small.toml", "--no-timing", "--out", "single")
        self.assertEqual(self.rows("all"), self.rows("single"))


    def test_an_indexed_job(self):
        for index in range(3):
            self.environment.update(JOB_COMPLETION_INDEX=str(index), JOB_COMPLETIONS="3")
            self.atwood("run", "small.toml", "--no-timing", "--out", "shards", told=[f"share {index + 1} of 3 (JOB_COMPLETION_INDEX)"])
        for name in ("JOB_COMPLETION_INDEX", "JOB_COMPLETIONS"):
            del self.environment[name]
        self.joined_equals_single()

    def joined_equals_single(self):
        self.merge(*self.stores())
        self.atwood("run", "small.toml", "--no-timing", "--out", "single")
        self.assertEqual(self.rows("all"), self.rows("single"))


@unittest.skipIf(one_machine_slurm.missing(), one_machine_slurm.missing())
class UnderSlurm(Launchers):
    """One Slurm for all tests of the class."""
    test_mpirun = test_an_indexed_job = None

    @classmethod
    def setUpClass(cls):
        cls.slurm = one_machine_slurm.Slurm().__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.slurm.__exit__()

    def ask_slurm(self, *words):
        return self.slurm.ask(*words, cwd=self.here, environment=self.environment)

    def task(self, *words):
        """A script that runs the share of its task."""
        return self.path("task.sh", f"#!/bin/sh\nexec '{ATWOOD}' run {' '.join(words)} --no-timing --out shards\n", 0o755)

    def outputs(self):
        texts = []
        for name in sorted(os.listdir(self.here)):
            if name.startswith("slurm-"):
                with open(self.path(name)) as file:
                    texts.append(f"{name}: {file.read()}")
        return "\n".join(texts)

    def test_srun(self):
        told = self.ask_slurm("srun", "-n", "2", ATWOOD, "run", "small.toml", "--no-timing", "--out", "shards")
        self.assertEqual([os.path.basename(store) for store in self.stores()], ["shard-1-of-2.db", "shard-2-of-2.db"], told)
        self.joined_equals_single()

    def test_an_array_of_eight(self):
        self.assertIn("Submitted batch job", self.ask_slurm("sbatch", "--array=0-7", self.task("small.toml")))
        self.slurm.until("the array has ended", lambda: not self.slurm.jobs(), 300)
        self.assertEqual(len(self.stores()), 8, self.outputs())
        self.assertIn("share 8 of 8 (SLURM_ARRAY_TASK_ID)", self.outputs())
        self.joined_equals_single()

    def test_a_task_that_was_killed_is_queued_again_and_goes_on(self):
        """An engine that needs a second for each of four cells; its task is requeued, which kills it, amid them."""
        self.environment["ENGINE_SLEEP"] = "1"
        self.write_engine(fingerprint="always the same")
        self.ask_slurm("sbatch", "--array=0-1", "--requeue", "--open-mode=append", self.task(*self.words))
        runs = lambda: self.written("engine.log").count("accuracy")
        self.slurm.until("two cells were begun", lambda: runs() >= 2, 120)
        running = [job.split()[0] for job in self.slurm.jobs() if job.endswith(" RUNNING")]
        self.assertTrue(running, self.outputs())
        for job in running:  # the task of our own engine may have ended
            self.ask_slurm("scontrol", "requeue", job)
        self.slurm.until("the task has ended", lambda: not self.slurm.jobs(), 300)
        self.assertIn("reused from the store: ", self.outputs())
        self.assertLessEqual(runs(), 5, "a cell that was stored was run again")
        self.merge(*self.stores())
        self.atwood("run", *self.words, "--no-timing", "--out", "single")
        joined, single = self.rows("all", *self.words), self.rows("single", *self.words)
        self.assertEqual([row for row in joined if row["status"] != "ok"], [], self.outputs())
        self.assertEqual(joined, single)

    def written(self, name):
        with open(self.path(name)) as file:
            return file.read()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
