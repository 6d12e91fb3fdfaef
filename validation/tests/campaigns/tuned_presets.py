"""No tuned preset loses to its engine's default. tuned_presets.py ATWOOD ROOT [--all]

For each engine whose `tuned` differs from its default, scenes of those classes are run with both, at the scenes' own step
counts: the main figure of a scene (`metric` of its file; else the largest error of position) must not exceed 1.5 times the
default's, the truth's bar and 1e-6 of its unit apart. The scenes are those of the search, training and held out, that a run
takes seconds for; with --all every scene of the catalogue that the two methods take. Engines that are not built are left out."""
import argparse
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile

MOST_RATIO, LEAST_DIFFERENCE = 1.5, 1e-6
SLOW = {"pile-216", "settling-100", "settling-boxes-100", "elastic-216", "wall", "arm-6", "andrews", "bricard"}  # nightly


def main_metric(root, scenario):
    with open(f"{root}/validation/scenarios/{scenario}.toml") as file:
        named = re.search(r'^metric *= *"([^"]+)"', file.read(), re.M)
    return named.group(1) if named else "error-position-max"


def rows_of(atwood, root, engine, scenarios, limit_s):
    """{(scenario, scheme): {(metric, steps): row}} of the default and of tuned."""
    with tempfile.TemporaryDirectory() as here:
        words = [word for one in scenarios for word in ("--scenario", one)]
        run = subprocess.run([atwood, "run", *words, "--method", engine + "/default", "--method", engine + "/tuned", "--no-timing", "--quiet",
                              "--keep", "none", "--limit", str(limit_s), "--out", here + "/out", "-o", f"csv:{here}/rows.csv"],
                             cwd=here, env={**os.environ, "ATWOOD_ROOT": root}, capture_output=True, text=True)
        if not os.path.exists(f"{here}/rows.csv"):
            sys.exit(f"{engine}: no rows\n{run.stdout[-2000:]}{run.stderr[-2000:]}")
        found = {}
        with open(f"{here}/rows.csv") as file:
            for row in csv.DictReader(file):
                if row["steps"] and not row["body"] and not row["t_s"]:
                    scheme = row["method"].split("/")[1]
                    found.setdefault((row["scenario"], scheme), {})[row["metric"], int(row["steps"])] = row
        return found


def size_of(row):
    return abs(float(row["value"])) if row and row["status"] == "ok" and row["value"] else math.nan


def losses(root, engine, found, judged):
    """Sentences; counts into `judged` the figures that were compared."""
    for scenario in sorted({name for name, _ in found}):
        default, tuned = found.get((scenario, "default"), {}), found.get((scenario, "tuned"), {})
        metric = main_metric(root, scenario)
        if not any(name == metric for name, _ in default):
            metric = "error-position-max"
        for (name, steps), row in sorted(default.items()):
            of_default = size_of(row)
            if name != metric or not math.isfinite(of_default):
                continue
            judged.append((engine, scenario, steps))
            bar = float(row["truth_bar"] or 0)
            of_tuned = size_of(tuned.get((name, steps)))
            if not of_tuned <= MOST_RATIO * of_default + LEAST_DIFFERENCE + (bar if math.isfinite(bar) else 0):
                yield f"{engine}/tuned: {metric} of {scenario} at {steps} steps is {of_tuned:.3g}, the default's {of_default:.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("atwood")
    parser.add_argument("root")
    parser.add_argument("--all", action="store_true", help="every scene of the catalogue")
    parser.add_argument("--presets", help="another file than reference/rivals/tuned.json (the workers hold their own)")
    options = parser.parse_args()
    root, atwood = os.path.abspath(options.root), os.path.abspath(options.atwood)
    with open(options.presets or f"{root}/reference/rivals/tuned.json") as file:
        searches = json.load(file)
    everything = sorted(name[:-5] for name in os.listdir(f"{root}/validation/scenarios") if name.endswith(".toml"))
    judged, lost = [], []
    for engine, classes in sorted(searches.items()):
        searched = {one for entry in classes.values() if entry["settings"] for one in entry["training"] + entry["held_out"]}
        if not searched or not os.path.exists(f"{os.path.dirname(atwood)}/atwood-{engine}"):
            continue
        scenarios = everything if options.all else sorted(searched - SLOW)
        if scenarios:
            lost += losses(root, engine, rows_of(atwood, root, engine, scenarios, 60 if options.all else 20), judged)
    print(f"{len(judged)} figures of {len({one[:2] for one in judged})} pairs of an engine and a scene", *lost, sep="\n")
    if not judged:
        print("found nothing to judge: no engine with a tuned preset is built")
        sys.exit(77)
    sys.exit(bool(lost))


if __name__ == "__main__":
    main()
