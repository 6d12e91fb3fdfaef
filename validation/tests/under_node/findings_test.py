"""What the manual says of the engines under Node.js is measured by findings.py, and how they were tuned by the recorded searches.
findings_test.py BIN_DIR ROOT; figures of engines that are not built are left out."""
import json
import os
import re
import subprocess
import sys
import unittest

import findings

BIN_DIR, ROOT = (os.path.abspath(path) for path in sys.argv[1:3])
PAGES = ["rapier", "jolt", "mujoco3"]
CLASSES = ["free-flight", "bounce", "friction", "stack", "heap", "mechanism"]


def page(name):
    with open(f"{ROOT}/docs/{name}.md") as file:
        return file.read()


def table(name):
    """Rows of the figures that are printed under this name."""
    script = f"{ROOT}/validation/tests/under_node/findings.py"
    ended = subprocess.run([sys.executable, script, BIN_DIR, name], capture_output=True, text=True, check=True, timeout=300)
    return [line.split(",") for line in ended.stdout.splitlines() if not line.startswith("#")][1:]


def built(*engines):
    return all(os.path.exists(f"{BIN_DIR}/atwood{engine}") for engine in ("", *(f"-{name}" for name in engines)))


class Findings(unittest.TestCase):
    def test_each_table_of_the_pages_has_its_command_and_each_command_its_table(self):
        named = set(re.findall(r"`((?:rapier|jolt|mujoco3)-[a-z0-9-]+|oblique-bounce)`", "".join(map(page, PAGES))))
        self.assertEqual(named - {"jolt-physics"}, set(findings.TABLES))  # a package's name

    @unittest.skipUnless(built("rapier", "jolt"), "one of the engines is not built")
    def test_the_friction_of_an_oblique_bounce_is_what_the_page_says(self):
        for mu, *ratios in table("oblique-bounce"):
            row = re.search(rf"^\| {mu} \|(.*)$", page("rapier"), re.M).group(1)
            said = [float(re.match(r"[0-9.]+", cell.strip()).group()) for cell in row.split("|")[:4]]
            self.assertEqual(said, [round(float(ratio), 4) for ratio in ratios])

    @unittest.skipUnless(built("jolt"), "jolt is not built")
    def test_jolt_s_attitude_at_960_steps_is_what_the_page_says(self):
        for variant, *numbers in table("jolt-960"):
            if variant == "as in the catalogue":
                self.assertIn(f"| nothing | {', '.join(f'{float(x):.4f}' for x in numbers[:4]).replace('0.', '.')} |", page("jolt"))

    def test_the_page_of_presets_tells_the_trials_of_each_search(self):
        with open(f"{ROOT}/reference/rivals/tuned.json") as file:
            searches = json.load(file)
        for engine, classes in searches.items():
            if engine == "atwood":
                continue
            trials = [classes.get(name, {}).get("trials", 0) for name in CLASSES]
            self.assertIn(f"| `{engine}` | {' | '.join(map(str, trials))} |", page("tuned-presets"))
            for name in ("bounce", "friction"):  # as many for each engine that was searched but DART, as the page says
                if classes.get(name, {}).get("trials"):
                    self.assertEqual(classes[name]["trials"], 16 if engine == "dart" else 32, engine)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
