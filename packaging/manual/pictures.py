#!/usr/bin/env python3
"""Draws the pictures of the concepts, each from runs of the program: pictures.py PROGRAM FOLDER [NAME...]

They are committed in docs/pictures; a test draws them again and compares."""
import csv
import io
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
from fractions import Fraction

from drawing import COLOURS, Plot, document, number, polyline, text

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


class Program:
    def __init__(self, path, folder):
        self.path, self.folder = path, folder

    def call(self, *words):
        return subprocess.run([self.path, *words], cwd=self.folder, check=True, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL).stdout

    def rows(self, scenario, methods, *more):
        """The rows of a run, without times; the codes of gates are no concern here."""
        words = [w for m in methods for w in ("--method", m)]
        ended = subprocess.run([self.path, "run", "--scenario", scenario, *words, "--no-timing", "-o", "csv:rows.csv",
                                *more],
                               cwd=self.folder, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if ended.returncode not in (0, 1):
            raise RuntimeError(ended.stdout + ended.stderr)
        with open(self.folder / "rows.csv", newline="") as file:
            return list(csv.DictReader(file))

    def trace(self, scene, method, *more):
        return list(csv.DictReader(io.StringIO(self.call("trace", scene, "--method", method, *more))))


def ladder(rows, method, metric, x="h_s"):
    points = [(float(r[x]), float(r["value"])) for r in rows if (r["method"], r["metric"]) == (method, metric)]
    if not points:
        raise RuntimeError(f"no rows of {metric} by {method}")
    return sorted(points)


def order(program):
    """Errors against steps: what an order is, and where float ends it."""
    methods = {"bullet64/default": "Bullet, double", "bullet32/default": "Bullet, float", "ode/default": "ODE",
               "atwood/symplectic-euler": "symplectic Euler", "atwood/rk4": "RK4", "atwood/rk4@float": "RK4 in float",
               "atwood/verner8": "Verner 8"}
    rows = program.rows("free-box-complex", methods)
    plot = Plot("A tumbling box: attitude error after 10 s against the number of steps", (100, 10000, True),
                (1e-13, 10, True),
                "steps in 10 s",
                "error of the attitude after 10 s [rad]")
    for k, (method, name) in enumerate(methods.items()):
        plot.curve(ladder(rows, method, "error-attitude-end", "steps"), COLOURS[k], name, dashed="float" in name)
    for power, start in ((1, 0.12), (4, 1e-5)):
        plot.curve([(800 * 2**k, start / 2 ** (power * k)) for k in range(3)], "#888", "", marks=False, dashed=True,
                   width=1)
        plot.note(3400, start / 4**power, f"order {power}")
    return plot.svg()


def bar(program):
    """Errors of runs beside the truth's bar, on a scene where both grow exponentially."""
    truth = program.trace("lorenz", "truth")
    plot = Plot("Lorenz's system: errors of three runs, and the bar of the truth", (0, 10), (1e-26, 100, True),
                "time [s]", "distance from the truth")
    for k, (method, name) in enumerate({"atwood/rk4": "RK4", "atwood/verner8": "Verner 8",
                                        "atwood/verner8@quad": "Verner 8, 113 bits"}.items()):
        run = program.trace("lorenz", method, "--steps", "3840")
        points = []
        for r, t in list(zip(run, truth))[1:]:
            points.append((float(t["t_s"]), max(difference(r, t), 1e-26)))
        plot.curve(points, COLOURS[k], name, marks=False)
    bars = [(float(t["t_s"]), max(math.hypot(*(float(t[f"p{a}_m_bar"]) for a in "xyz")), 1e-26)) for t in truth[1:]]
    plot.curve(bars, "#888", "bar of the truth", marks=False, dashed=True)
    return plot.svg()


def difference(a, b):
    """The distance of two positions; of decimal texts, which have more digits than a float."""
    return math.sqrt(sum(float((Fraction(a[f"p{k}_m"]) - Fraction(b[f"p{k}_m"])) ** 2) for k in "xyz"))


def orbits(program):
    """Three rungs of a ladder, as orbits."""
    plot = Plot("One planet, three rungs of explicit Euler's ladder, and the truth", (-3.2, 1.2), (-1.5, 1.3), "x [m]",
                "y [m]", height=420)
    for k, steps in enumerate(("480", "1920", "7680")):
        run = program.trace("kepler-e0.6", "atwood/explicit-euler", "--steps", steps, "--samples", "240")
        plot.curve([(float(r["px_m"]), float(r["py_m"])) for r in run], COLOURS[k], f"{steps} steps", marks=False,
                   at_end=True)
    truth = program.trace("kepler-e0.6", "truth", "--samples", "240")
    plot.curve([(float(r["px_m"]), float(r["py_m"])) for r in truth], "#888", "truth", marks=False, dashed=True,
               at_end=True)
    return plot.svg()


def window(program):
    """The window of a fit: what is left out at both ends, from the row's own words."""
    method = "atwood/rk4"
    rows = program.rows("kepler-e0.6", [method])
    fit = next(r for r in rows if r["metric"] == "order-position")
    first, last = map(int, re.match(r"(\d+)\.\.(\d+) steps", fit["reason"]).groups())
    plot = Plot("The order of RK4 is fitted over its window", (100, 1e5, True), (1e-13, 1, True), "steps",
                "largest error of the position [m]")
    points = ladder(rows, method, "error-position-max", "steps")
    plot.column(first / 1.4, last * 1.4, f"window: order {float(fit['value']):.2f} ± {float(fit['truth_bar']):.2f}")
    plot.curve(points, COLOURS[0], "RK4")
    plot.note(14000, 1e-9, "near round-off")
    plot.note(110, 2e-5, "too coarse")
    return plot.svg()


def growth(program):
    """Laws of growth: the energy and the position of a symplectic method and of one that is not."""
    truth = program.trace("kepler-10-periods", "truth")
    plot = Plot("Ten orbits: how errors of position and energy grow", (1, 10, True), (1e-7, 1e-2, True),
                "orbits", "largest error within an orbit")
    for k, (method, name, steps) in enumerate((("atwood/yoshida4", "Yoshida 4", "3840"),
                                               ("atwood/rk4", "RK4", "3840"))):
        run = program.trace("kepler-10-periods", method, "--steps", steps)
        period = float(truth[-1]["t_s"]) / 10
        places, energies = {}, {}
        for r, t in list(zip(run, truth))[1:]:
            turn = math.ceil(float(t["t_s"]) / period - 1e-9)
            places[turn] = max(places.get(turn, 0), difference(r, t))
            energies[turn] = max(energies.get(turn, 0), abs(energy(r) + 0.5))
        plot.curve(sorted(places.items()), COLOURS[k], f"{name}, position [m]")
        plot.curve(sorted(energies.items()), COLOURS[k], f"{name}, energy [J]", dashed=True)
    return plot.svg()


def energy(r):
    v = math.hypot(*(float(r[f"v{a}_m_per_s"]) for a in "xyz"))
    return v * v / 2 - 1 / math.hypot(*(float(r[f"p{a}_m"]) for a in "xyz"))


GATE = ('[[gate]]\nscenario = "kepler-e0.6"\nmethod = "{}"\nmetric = "order-position"\n'
        'within = [{}, {}]\nreason = "An example."\n')
ASKED = {"atwood/explicit-euler": 1, "atwood/velocity-verlet": 2, "atwood/heun": 2, "atwood/midpoint": 3,
         "atwood/kutta3": 3,
         "atwood/rk4": 4, "atwood/dopri5": 5}


def verdicts(program):
    """Orders with their intervals beside what gates ask for, and the verdicts; midpoint is asked for too high a one."""
    gates = [GATE.format(method, asked - 0.1, asked + 0.1) for method, asked in ASKED.items()]
    (program.folder / "gates.toml").write_text("\n".join(gates))
    rows = program.rows("kepler-e0.6", ASKED, "--tolerances", "gates.toml", "--junit", "verdicts.xml")
    told, left, right, middle = judged(program.folder / "verdicts.xml"), 245, 455, 350
    parts = [f'<rect x="{middle - 40}" y="26" width="80" height="{len(ASKED) * 32 - 4}" fill="{COLOURS[2]}" '
             'opacity=".18"/>',
             text(middle, 18, "asked for ± 0.1", "middle")]
    for k, (method, asked) in enumerate(ASKED.items()):
        row = next(r for r in rows if (r["method"], r["metric"]) == (method, "order-position"))
        y, value, half, verdict = 44 + 32 * k, float(row["value"]), float(row["truth_bar"]), told[method]
        colour = {"pass": COLOURS[2], "fail": COLOURS[1]}.get(verdict, COLOURS[5])
        parts.append(text(left - 20, y + 4, f"{method}, asked for {asked}", "end"))
        if math.isfinite(value):
            at = [min(max(middle + 400 * (v - asked), left), right) for v in (value - half, value, value + half)]
            parts.append(polyline([(at[0], y), (at[2], y)], colour, 3))
            parts.append(f'<circle cx="{number(at[1])}" cy="{y}" r="4.5" fill="{colour}"/>')
        else:
            parts.append(text(middle, y + 4, "no order was found", "middle", ' class="faint"'))
        figure = f"{value:.2f} ± {half:.2g}" if math.isfinite(value) else "inconclusive"
        parts.append(text(right + 12, y + 4, f"{figure}: {verdict.replace('_', ' ')}", more=f' style="fill:{colour}"'))
    return document(640, 36 + 32 * len(ASKED), "Observed orders, the intervals that gates allow, and verdicts", parts)


def judged(junit):
    """{method: verdict} of a file of verdicts."""
    found = {}
    for case in xml.parse(junit).iter("testcase"):
        if case.get("name").endswith(" order-position"):
            bad = case.find("failure")
            found[case.get("name").split()[0]] = "pass" if bad is None else bad.get("type")
    return found


def hypotheses(program):
    """A row of touching balls under three laws of contact: three answers, none of them wrong."""
    scene = (ROOT / "validation/scenarios/cradle-touching-3.toml").read_text()
    scene = re.sub(r"(?m)^simultaneous_impacts.*\n", "", scene.replace('"cradle-touching-3"', '"cradle"'))
    (program.folder / "cradle.toml").write_text(scene)
    plot = Plot("Three touching balls hit two: the speeds afterwards", (0.7, 5.3), (-0.4, 1.4), "ball",
                "speed afterwards [m/s]")
    for k, (method, name, steps) in enumerate((("atwood/rk4+event{simultaneous=sequential}", "one after the other",
                                                "960"),
                                               ("atwood/rk4+event{simultaneous=together}", "together", "960"),
                                               ("atwood/rk4+penalty", "stiff springs", "76800"))):
        end = program.trace("cradle.toml", method, "--steps", steps)[-5:]
        plot.curve([(1 + i, float(r["vx_m_per_s"])) for i, r in enumerate(end)], COLOURS[k], name)
    return plot.svg()


PICTURES = {"order": order, "bar": bar, "orbits": orbits, "window": window, "growth": growth, "verdicts": verdicts,
            "hypotheses": hypotheses}


def draw(program, name):
    with tempfile.TemporaryDirectory() as folder:
        return PICTURES[name](Program(program, pathlib.Path(folder)))


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[2])
    for wanted in sys.argv[3:] or PICTURES:
        (target / f"{wanted}.svg").write_text(draw(str(pathlib.Path(sys.argv[1]).resolve()), wanted), encoding="utf-8")
