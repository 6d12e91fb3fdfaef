"""A store that a disk has changed is mended by the next run; an engine's fingerprint covers the modules beside it."""
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import unittest

from case import ROOT, Case

WORKER = os.path.join(ROOT, "reference/your_engine/worker.py")
SCENARIO = ["--scenario", "ballistic"]


class Damage(Case):
    def test_a_flipped_bit_in_a_key_is_mended_or_refused_in_words(self):
        run = ["run", *SCENARIO, "--method", "atwood/rk4", "--no-timing"]
        store = self.path("atwood-out/store.db")
        self.ask(*run)
        with sqlite3.connect(store) as database:
            database.execute("PRAGMA journal_mode=DELETE")
            keys = [key for key, in database.execute("SELECT hash FROM cells ORDER BY hash")]
        database.close()
        with open(store, "rb") as file:
            sound = file.read()
        # One bit in the tail of a key: the entry then stands at the wrong place of its table. Each key stands in `cells`,
        # in `series` (its row and its index) and in `measured`.
        places = [match.start() + 25 for match in re.finditer(b"|".join(key.encode() for key in keys[:4]), sound)]
        self.assertEqual(len(places), 16)
        mended = 0
        for place in places:
            damaged = bytearray(sound)
            damaged[place] ^= 1
            for end in ("-wal", "-shm"):
                if os.path.exists(store + end):
                    os.remove(store + end)
            with open(store, "wb") as file:
                file.write(damaged)
            first = self.ask(*run, code=(0, 5))
            for word in ("UNIQUE", "constraint", "cells.hash"):
                self.assertNotIn(word, first.stderr)
            if first.returncode != 0:
                self.assertIn("move it away", first.stderr)
                continue
            mended += "runs again" in first.stderr
            second = self.ask(*run).stderr
            self.assertNotIn("runs again", second)
            self.assertIn("nothing to do", second)
            self.ask("report", *run[1:-1])
        self.assertGreaterEqual(mended, 8)  # recordings and rows; where a counted key has changed the store is refused


class Template(Case):
    def test_a_module_of_the_copied_worker_counts(self):
        with open(WORKER) as file:
            text = file.read()
        with open(self.path("worker.py"), "w") as file:
            file.write(text.replace("import hashlib,", "import gain, hashlib,", 1))
        os.chmod(self.path("worker.py"), 0o755)

        def gain(value):
            with open(self.path("gain.py"), "w") as module:
                module.write(f"GAIN = {value}\n")

        run = ["run", *SCENARIO, "--engine", "./worker.py", "--no-timing"]
        gain("1.0")
        first = self.ask(*run).stderr
        self.assertIn("python 0 of", first)
        self.assertNotIn("campaign", first)
        self.assertNotIn("python 0 of", self.ask(*run).stderr)
        gain("1.01234")
        self.ask(*run, told=["python 0 of"])


# Loads a library at its first run request, as plug-ins do.
LATE = r"""
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
int main(void) {
  static char line[1 << 20];
  while (fgets(line, sizeof line, stdin)) {
    const char* cell = strstr(line, "\"cell\":");
    if (strstr(line, "\"hello\"") || !cell) {
      printf("{\"engine\":\"late\",\"version\":\"1\",\"scalar\":\"double\",MORE"
             "\"methods\":[{\"id\":\"late/a\",\"doc\":\"a\"}]}\n");
    } else {
      if (!dlopen(getenv("LATE_LIBRARY"), RTLD_NOW)) return 1;
      printf("{\"cell\":%d,\"done\":{\"status\":\"unsupported\",\"reason\":\"no\"}}\n", atoi(cell + 7));
    }
    fflush(stdout);
  }
  return 0;
}
"""


@unittest.skipUnless(shutil.which("cc"), "without a compiler")
class Late(Case):
    def build(self, more=""):
        for name, text, flags in (("late", LATE.replace("MORE", more), ["-ldl"]),
                                  ("liblate.so", "double gain(void) { return 1; }", ["-shared", "-fPIC"])):
            with open(self.path(name + ".c"), "w") as file:
                file.write(text)
            subprocess.run(["cc", self.path(name + ".c"), "-o", self.path(name), *flags], check=True)
        os.environ["LATE_LIBRARY"] = self.path("liblate.so")

    def test_cells_of_a_library_that_is_loaded_after_hello_are_measured_again(self):
        run = ["run", *SCENARIO, "--engine", "./late", "--no-timing"]
        self.build()
        self.ask(*run, told=["late 0 of", "liblate.so after its hello"])
        self.ask(*run, told=["late 0 of", "liblate.so after its hello"])
        self.build(more='\\"files\\":[\\"liblate.so\\"],')
        self.ask(*run, told=["late 0 of"])
        self.assertNotIn("late 0 of", self.ask(*run).stderr)


class Large(Case):
    def test_a_huge_file_is_refused_by_name(self):
        with open(self.path("huge.bin"), "wb") as file:
            file.truncate(200 << 30)
        shutil.copy(WORKER, self.path("worker.py"))
        with open(self.path("study.toml"), "w") as file:
            file.write('id = "s"\nengines = [["python3", "worker.py", "huge.bin"]]\n[[cells]]\n'
                       'scenarios = ["ballistic"]\nmethods = ["python/*"]\n')
        self.ask("run", "study.toml", "--no-timing", code=(2, 3), told=["huge.bin", "4 GiB"])
        with open(self.path("worker.py")) as file:
            text = file.read()
        with open(self.path("worker.py"), "w") as file:
            file.write(text.replace('"scalar": "double",', '"scalar": "double", "files": ["huge.bin"],', 1))
        self.ask("run", *SCENARIO, "--engine", "./worker.py", "--no-timing", code=(2, 3), told=["huge.bin", "4 GiB"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
