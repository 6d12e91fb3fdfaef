"""The methods that a report draws beside the truth: which they are, and that their poses are as far from it as the rows say."""
import base64
import json
import os
import re
import sys
import unittest
import zlib

from case import Case

METHODS = ("atwood/explicit-euler", "atwood/rk4", "atwood/rk4@float", "bullet64/default", "bullet64/tuned", "ode/default", "mujoco/default")


class Motion(Case):
    def embedded(self):
        with open(self.path("atwood-out/report.html")) as file:
            coded = re.search('<script type="text/plain" id="data">([^<]*)<', file.read())[1]
        return json.loads(zlib.decompress(base64.b64decode(coded), -15))

    def test_beside_the_truth(self):
        words = [word for method in METHODS for word in ("--method", method)]
        self.ask("run", "--scenario", "free-box-complex", *words, "-o", "json:rows.json", code=(0, 1))
        scene, = self.embedded()["scenes"]
        with open(self.path("rows.json")) as file:
            report = json.load(file)
        scenario, = report["scenarios"]
        self.assertEqual([method["id"].split("/")[0] for method in scene["methods"]][0], "atwood")
        chosen = [method["id"] for method in scene["methods"]]
        self.assertLessEqual(len(chosen), 3)
        self.assertEqual(len({method.split("/")[0] for method in chosen}), len(chosen), chosen)  # of each engine one
        self.assertNotIn("bullet64/tuned", chosen)  # of a rival its default settings
        self.assertNotIn("atwood/rk4@float", chosen)
        nearest = min(scenario["steps"], key=lambda steps: abs(steps / (240 * scenario["t_end_s"]) - 1))
        figures = {(row["method"], row["steps"], row["metric"]): row["value"] for row in report["rows"] if row["body"] == "" and row.get("t_s") is None}
        for method in scene["methods"]:
            self.assertEqual(method["steps"], nearest, method["id"])
            body, = method["bodies"]
            for part, metric in (("p", "error-position-max"), ("r", "error-attitude-max")):
                self.assertEqual(len(body[part]), 3 * len(scene["times"]))
                sizes = [sum(x * x for x in body[part][i:i + 3]) ** 0.5 for i in range(0, len(body[part]), 3)]
                exact = figures[method["id"], nearest, metric]
                self.assertAlmostEqual(max(sizes) / exact if exact else max(sizes), 1 if exact else 0, delta=0.01, msg=f"{method['id']} {metric}: {max(sizes)}, not {exact}")
                self.assertEqual(sizes[0], 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
