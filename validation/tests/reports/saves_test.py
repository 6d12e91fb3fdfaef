#!/usr/bin/env python3
"""Every table of every page is saved as CSV, every plot as SVG and PNG: of a report with fluids, joints, contacts, an audit, statistics,
a sweep, fields and a comparison with an earlier run; of the index of runs; of a study's page with trends. saves_test.py ATWOOD
Answers 77 (skipped) with a word where Chromium or chromedriver is missing."""
import os
import pathlib
import re
import sqlite3
import subprocess
import sys
import tempfile

from chromium import SKIPPED, Browser, check, programs, silence, until
from saves import everything_saves

STUDY = """id = "audit"
[[cells]]
scenarios = ["kepler-e0.6"]
methods = ["atwood/rk4", "atwood/leapfrog", "arkode/erkstep/HEUN_EULER_2_1_2"]
steps = [960, 1920, 3840, 7680, 15360]
[[cells]]
probe = "reversal"
scenarios = ["kepler-e0.6"]
methods = ["atwood/rk4", "atwood/leapfrog"]
steps = [480]
timing = false
[[cells]]
scenarios = ["taylor-green"]
methods = ["atwood/rk4+sph"]
spacings_m = [0.125]
sound_speeds_m_per_s = [10]
timing = false
[[cells]]
scenarios = ["double-pendulum-regular"]
methods = ["atwood/rk4", "atwood/rattle"]
steps = [400, 800]
timing = false
[[cells]]
scenarios = ["bounce-e0.5"]
methods = ["atwood/rk4+event", "bullet64/default"]
timing = false
[[cells]]
probe = "contact-sweep"
scenarios = ["geometry-sweep"]
methods = ["atwood/contacts", "bullet64/contacts"]
steps = [20]
"""
COLUMNS = "begun_ns, ended_ns, study, selection, cells, command, commit_id, host, cpu, verdict, passed, failed, unverifiable, not_run, environment"


def atwood(folder, *words):
    program = os.path.abspath(sys.argv[1])
    ended = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, timeout=600)
    check(ended.returncode in (0, 1), f"atwood {' '.join(words)}: {ended.stderr}")


def pages(folder):
    """A report beside an earlier run whose errors were others, the index, and twelve runs whose errors change at the seventh."""
    (folder / "study.toml").write_text(STUDY)
    atwood(folder, "run", "study.toml")
    with sqlite3.connect(folder / "atwood-out/history.db") as database:
        database.executemany(f"INSERT INTO runs({COLUMNS}) SELECT {COLUMNS} FROM runs WHERE id=1 AND ?", [(1,)] * 11)
        database.execute("INSERT INTO figures SELECT runs.id, one.scenario, one.method, one.kind, (SELECT content FROM figures AS other WHERE other.run=1 AND other.kind=one.kind "
                         "AND other.scenario=one.scenario AND other.method=iif(runs.id>=7 AND one.method='atwood/rk4', 'atwood/leapfrog', one.method)) "
                         "FROM figures AS one, runs WHERE one.run=1 AND one.scenario='kepler-e0.6' AND one.kind='errors' AND runs.id>1")
    atwood(folder, "report", "study.toml", "--against", "9")
    return [folder / "atwood-out" / name for name in ("report.html", "index.html", "reports/audit.trends.html")]


def opens(browser, path):
    browser.post("/url", {"url": path.as_uri()})
    until("the page is drawn", lambda: browser.run("return document.readyState === 'complete' && (!document.querySelector('#data') || document.documentElement.dataset.ready === 'true')"), 40)


def report(browser, path):
    opens(browser, path)
    sections = browser.run("return [...document.querySelectorAll('section[id]')].map(s => s.id)")
    wanted = {"fluids", "fields", "audit", "statistics", "sweep", "compare", "changes", "plots", "matrix", "rows", "engines"}
    check(wanted <= set(sections), f"sections that the report lacks: {wanted - set(sections)}")
    tables, plots = everything_saves(browser)
    check({"fluids.csv", "rows.csv", "figures-that-changed.csv"} <= set(tables), f"tables: {sorted(tables)}")
    fields = {name: text for name, text in plots.items() if name.startswith("taylor-green-") and "rk4-sph" in name}
    check({name.split("-")[2] for name in fields} >= {"speed", "pressure", "error"}, f"fields: {sorted(fields)}")
    for name, text in fields.items():
        check("x [m]" in text and "y [m]" in text and len(re.findall("h-[0-9.]+z", text)) == 64, f"{name} has no axes or lacks some of its 64 particles")
    # Every scene, with all of its plots.
    for scene in browser.run("return [...document.querySelector('#plot-scenario').options].map(o => o.value)"):
        browser.run("const s = document.querySelector('#plot-scenario'); s.value = arguments[0]; s.dispatchEvent(new Event('change')); document.querySelector(\"#plots [data-plot='all']\")?.click();", scene)
        _, plots = everything_saves(browser)
        charts = [name for name in plots if re.match(re.escape(scene) + r"-.*-(step|cpu|evaluations|error|energy)\.svg", name)]
        check(len(charts) >= (5 if scene == "kepler-e0.6" else 1), f"plots of {scene}: {sorted(plots)}")
        ladder = next(plots[name] for name in charts if name.endswith("-step.svg"))
        # A label that would overlap another is left out: of particles' ladders, which are short, those of high orders.
        wanted = (1, 2, 4, 5) if scene == "kepler-e0.6" else (1,)
        check(all(f">order {slope}<" in ladder for slope in wanted), f"the guides of slope are not in the error against step of {scene}")
        print("ok:", scene, len(charts), "charts of", len(plots), "plots,", max(len(text) for text in plots.values()), "bytes at most")


def history(browser, index, trends):
    opens(browser, index)
    tables, plots = everything_saves(browser)
    check(set(tables) == {"atwood-reports.csv", "atwood-runs.csv"} and not plots, f"the index saves {sorted(tables)}, {sorted(plots)}")
    runs = tables["atwood-runs.csv"]
    check(runs[0][:3] == ["run", "begun (UTC)", "study"] and [line[0] for line in runs[1:]] == [str(n) for n in range(12, 0, -1)], f"the runs: {runs}")
    opens(browser, trends)
    tables, plots = everything_saves(browser)
    check(set(tables) == {"audit-runs.csv"} and len(plots) > 2, f"the page with trends saves {sorted(tables)}, {sorted(plots)}")
    for name, text in plots.items():
        check(name.startswith("kepler-e0.6-atwood-rk4-") and text.count("<circle") == 12 and re.search("run 7</text>", text), f"{name}: {text[:300]}")
    browser.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    _, dark = everything_saves(browser)
    browser.devtools("Emulation.setEmulatedMedia", features=[])
    ground = lambda text: re.search(r'<rect[^>]*fill="([^"]+)"', text)[1]
    check({ground(text) for text in plots.values()} == {"rgb(255, 255, 255)"} and {ground(text) for text in dark.values()} == {"rgb(20, 24, 31)"}, "a saved plot has not the colours of the page")


def main():
    found = programs()
    if not found:
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        browser = None
        try:
            page, index, trends = pages(pathlib.Path(folder))
            browser = Browser(*found)
            report(browser, page)
            silence(browser, page)
            history(browser, index, trends)
            print("ok: index and trends")
        except AssertionError as error:
            print("FAILED:", error)
            return 1
        finally:
            if browser:
                browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
