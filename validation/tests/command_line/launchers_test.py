"""Real launchers give each of their processes a share: Open MPI's mpirun. Skipped by name where there is none."""
import os
import shutil
import subprocess
import sys
import unittest

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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
