#!/usr/bin/env python3
"""What the report says of figures made by hand, in headless Chromium: the ranks of the matrix, the curves a plot opens with,
the figures in the sentences, the metric of a scene, pictures of fluids, methods beside the truth, pages on paper.
figures_test.py REPORTS/WEB; answers 77 (skipped) with a word where Chromium or chromedriver is missing."""
import os
import pathlib
import re
import sys
import tempfile
import time

from accessibility import accessible, contrast
from chromium import HOSTILE, SKIPPED, Browser, check, programs, silence, until
from crafted_page import Report
from saves import everything_saves

NAN = "nan"


def ladder(report, scene, method, metric, values, unit="m", bar=0.0, seconds=0.0, steps=(120, 240, 480)):
    for n, value in zip(steps, values):
        report.row(scene, method, n, metric, value, bar, unit)
        if seconds:
            report.row(scene, method, n, "step-time", seconds / n, 0.0, "s")


def tumbling(title="By hand"):
    """A box that five engines turn, and a ball whose impacts they time."""
    report = Report(title)
    report.scene("tumble", "A tumbling box", metric="error-attitude-max", tags=("smooth",))
    turns = {"atwood/rk4": (4e-6, 5e-7, 3e-8), "atwood/euler": (4e-2, 2e-2, 1e-2), "atwood/rk4@long-double": (1e-6, 1e-8, 1e-9), "atwood/rk4@float": (5e-5, 4e-5, 3e-5), "atwood/euler@float": (4.1e-2, 2.1e-2, 1.1e-2),
             "bullet64/default": (8e-2, 4e-2, 2e-2), "bullet64/tuned": (8e-3, 4e-3, 2e-3), "bullet32/default": (8.1e-2, 4.1e-2, 2.1e-2), "ode/default": (6e-2, 3e-2, 1.5e-2),
             "mujoco/default": (3e-5, 9e-7, 1e-7), "cvode/adams:1e-10": (2e-9,)}
    for method, values in turns.items():
        ladder(report, "tumble", method, "error-attitude-max", values, "rad", seconds=2e-3, steps=(314,) if ":" in method else (120, 240, 480))
        ladder(report, "tumble", method, "error-position-max", [v * 7 for v in values], "m", steps=(314,) if ":" in method else (120, 240, 480))
    place = lambda family, method, steps, error, cost: {"family": family, "method": method, "steps": steps, "error": error, "cost": cost}
    best, next_one = place("atwood/rk4", "atwood/rk4", 240, 5e-7, 1.5e-3), place("mujoco/default", "mujoco/default", 240, 9e-7, 4.5e-3)
    report.data["dominance"] = [{"scenario": "tumble", "metric": "error-attitude-max", "unit": "rad", "cost": "seconds", "by_budget": [], "stable": [],
                                 "by_error": [{"asked": 1e-3, "contenders": 2, "ranked": [next_one, best]}, {"asked": 1e-6, "contenders": 2, "ranked": [best, next_one]}]}]
    report.scene("bounce", "A ball that bounces")
    for method, values in {"atwood/rk4": (1e-9, 1e-9, 1e-9), "bullet64/default": (3e-2, 2e-2, 1e-2), "ode/default": (1e-2, 5e-3, 2e-3)}.items():
        ladder(report, "bounce", method, "error-position-max", [v * 3 for v in values])
        ladder(report, "bounce", method, "impact-time-error", values, "s")
    report.row("bounce", "mujoco/default", 240, "status", 0, unit="", status="unsupported", reason=f"MuJoCo has no restitution {HOSTILE}")
    return report


def ranks():
    """One scene for each way to rank: with figures inside the bar, ties, all equal, one without a figure, a failed gate."""
    report = Report()
    cases = {"bars": [(1e-9, 1e-9), (2.9e-9, 1e-9), (1e-3, 1e-9), (1e-1, 1e-9)], "ties": [(1, 0), (1, 0), (2, 0), (5, 0)], "equal": [(3, 0)] * 4,
             "missing": [(1, 0), (NAN, 0), (0, 0), (4, 0)], "infinite": [(1, 0), ("inf", 0), (2, 0), (-8, 0)], "refused": [(1, 0), (2, 0), (3, 0), (4, 0)]}
    for id, values in cases.items():
        report.scene(id, id, tags=("left",) if id in ("bars", "ties") else ("right",))
        for k, (value, bar) in enumerate(values):
            for n in (120, 240, 480):
                report.row(id, f"m{k}/a", n, "error-position-max", value if n == 240 else 5 + k, bar)
                report.row(id, f"m{k}/a", n, "error-velocity-end", 9 - k)
    report.data["verdicts"] = [{"judgement": "fail", "scenario": "refused", "method": "m2/a", "steps": 240, "metric": "error-position-max", "unit": "m", "value": 3, "bar": 0, "kind": "at most",
                                "allowed": "<= 2", "margin": -1, "text": "", "reason": "", "origin": "", "rerun": ""}]
    return report, {"bars": [0, 0, 67, 100], "ties": [0, 0, 67, 100], "equal": [None] * 4, "missing": [50, None, 0, 100], "infinite": [0, None, 50, 100], "refused": [0, 33, None, 100]}


def opens(browser, folder, name, report, web, fragment=""):
    path = os.path.join(folder, name + ".html")
    pathlib.Path(path).write_text(report.page(web))
    browser.post("/url", {"url": "about:blank"})
    browser.post("/url", {"url": pathlib.Path(path).as_uri() + fragment})
    until("the report is drawn", lambda: browser.run("return document.documentElement.dataset.ready === 'true'"), 40)
    return path


def text(browser, selector):
    return browser.run("return document.querySelector(arguments[0]).innerText", selector)


def sentences(browser):
    check("Not reached at any step size" not in text(browser, "#story"), "what other engines reach is not folded")
    browser.run("document.querySelectorAll('#story details').forEach(d => { d.open = true; })")
    told = text(browser, "#story")
    for words in ("use atwood/rk4 (240 steps, 1.5 ms). The best of another engine is mujoco/default (240 steps), at 3 times the cost.",
                  "to 1e-6 rad (error of the attitude, largest over the run)", "Not reached at any step size that ran by bullet64 (0.002 at best), bullet32 (0.021 at best) and ode (0.015 at best).",
                  "It is also reached by cvode/adams:1e-10 at tol 1e-10", "1 cell unsupported", "mujoco, 1 unsupported: MuJoCo has no restitution"):
        check(words in told, f"the first screen does not say {words!r}: {told}")
    check("atwood/rk4@float has 4e-5 on tumble at 240 steps, where double has 5e-7 (80 times)" in told, f"what float costs: {told}")
    check("In 1 of its 2 runs with a twin in double the errors differ by less than a tenth" in told, f"runs that float costs nothing: {told}")
    check("bullet32 has the same error in float within a tenth" in told, f"float of bullet32: {told}")
    lines = browser.run("return [...document.querySelectorAll('.losses tbody tr')].map(r => [...r.children].map(c => c.innerText.replace(/\\s+/g, ' ').trim()))")
    expected = {"atwood": ["5e-7 rk4", "1e-9 rk4"], "bullet64": ["0.04 default 0.004 tuned", "0.02 default"], "bullet32": ["0.041 default", "no figure"], "ode": ["0.03 default", "0.005 default"],
                "mujoco": ["9e-7 default", "no figure"], "cvode": ["2e-9 adams:1e-10", "no figure"]}
    check({line[0]: line[1:] for line in lines} == expected, f"what each engine loses at 240 Hz: {lines}")
    bold = browser.run("return [...document.querySelectorAll('.losses td b')].map(b => b.innerText)")
    check(bold == ["1e-9", "2e-9"], f"the smallest errors of the columns: {bold}")


def curves(browser):
    browser.run("location.hash = '#scene=tumble'")
    until("the scene is open", lambda: browser.run("return document.querySelector('#plot-scenario').value") == "tumble")
    check(browser.run("return document.querySelector('#plot-metric').value") == "error-attitude-max", "the scene does not open with the metric that it names")
    shown = browser.run("return [...document.querySelectorAll('#plots .legend button[aria-pressed=true]')].map(b => b.dataset.method)")
    wanted = {"atwood/rk4", "cvode/adams:tol", "mujoco/default", "bullet64/tuned", "ode/default", "bullet64/default"}
    check(set(shown) == wanted and len(shown) == 6, f"the curves that the plot opens with: {shown}")
    browser.run("location.hash = '#scene=bounce'")
    until("the metric of impacts by the rule", lambda: browser.run("return document.querySelector('#plot-metric').value") == "impact-time-error")


def unmeasured_metric(browser, folder, web):
    report = tumbling()
    report.data["scenarios"][0]["metric"] = "penetration-max"  # named, and nothing measured it
    path = opens(browser, folder, "unmeasured", report, web, "#scene=tumble")
    check(browser.run("return document.querySelector('#plot-metric').value") == "error-attitude-max", "a metric without figures is opened")
    silence(browser, path)


def parts(browser):
    lines = browser.run("""return [...document.querySelectorAll('#matrix tbody tr')].map(r => [r.children[0].textContent, [...r.querySelectorAll('td')].map(t => {
        const part = t.style.getPropertyValue('--part'); return part === '' ? null : parseFloat(part); })])""")
    return {name: found for name, found in lines}


def matrix(browser, expected):
    check(parts(browser) == expected, f"ranks: {parts(browser)}, expected {expected}")
    check(browser.run("return document.querySelectorAll('#matrix .refused').length") == 1, "a failed gate is not struck out")
    names = browser.run("return [...document.querySelectorAll('#matrix td button')].filter(b => !/^[a-z]+, m\\d\\/a, \\d+ steps: /.test(b.ariaLabel)).map(b => b.ariaLabel)")
    check(not names, f"figures of the matrix whose names say too little: {names}")
    browser.run("const b = document.querySelector('#matrix td button'); b.focus();")
    where = lambda: browser.run("return document.activeElement.ariaLabel")
    press = lambda key: browser.post("/actions", {"actions": [{"type": "key", "id": "keys", "actions": [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]}]})
    press("\ue014"), press("\ue015")
    check(where().startswith("ties, m1/a, 240"), f"right and down lead to {where()}")
    check(browser.run("return document.querySelectorAll('#matrix td [tabindex=\"0\"]').length") == 1, "the matrix has more than one stop for Tab")
    press("\ue013"), press("\ue013")
    check(where().startswith("bars, m1/a"), f"up twice leads to {where()}")
    taken = browser.run("const e = new KeyboardEvent('keydown', {key: 'ArrowLeft', altKey: true, bubbles: true, cancelable: true}); document.activeElement.dispatchEvent(e); return e.defaultPrevented")
    check(not taken and where().startswith("bars, m1/a"), "the matrix takes Alt and an arrow from the browser")


def change(browser, selector, value):
    browser.run("const s = document.querySelector(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('change'));", selector, value)


def matrix_links(browser, folder, report, web):
    """Every select, sorting and fold of the page is in its address."""
    opening = parts(browser)
    change(browser, "#matrix-tag", "right")
    change(browser, "#matrix-metric", "error-velocity-end")
    change(browser, "#matrix-rung", "finest")
    change(browser, "#compare-scenario", "ties")
    change(browser, "#compare-steps", "480")
    browser.run("document.querySelector('#gates summary').click(); document.querySelector('#gates th:nth-child(3) button').click(); document.querySelector('#gates th:nth-child(3) button').click();")
    state = """return [...document.querySelectorAll('#matrix select, #compare select')].map(s => s.value).concat(document.querySelector('#gates details').open,
        [...document.querySelectorAll('#gates th')].map(t => t.ariaSort).join(' '), document.querySelector('#compare tbody').textContent)"""
    before, after, fragment = browser.run(state), parts(browser), browser.run("return location.hash")
    check(set(after) == {"equal", "missing", "infinite", "refused"}, f"scenes with a tag: {list(after)}")
    opens(browser, folder, "ranks", report, web, fragment)
    check(browser.run(state) == before and parts(browser) == after, f"the link {fragment} restores {browser.run(state)}, not {before}")
    # A link to a scene keeps what is chosen elsewhere, and a section that it leads past.
    browser.run("document.querySelector('nav a[href=\"#rows\"]').click()")
    change(browser, "#row-method", "m0/a")
    change(browser, "#plot-metric", "error-velocity-end")
    browser.run("document.querySelector('.gallery a[href=\"#scene=equal\"]').click()")
    until("the link opens its scene", lambda: browser.run("return document.querySelector('#plot-scenario').value") == "equal")
    fragment = browser.run("return location.hash")
    check(browser.run(state) == before and parts(browser) == after and "row-method=m0%2Fa" in fragment, f"a link to a scene leaves {browser.run(state)} of {before}, {fragment}")
    check(browser.run("return document.querySelector('#plot-metric').value") == "error-position-max" and not re.search(r"[#&](metric|at)=", fragment), f"a link to a scene keeps what belonged to another: {fragment}")
    browser.run("document.querySelector('.of-scene a').click()")
    check(browser.run("return document.querySelector('#row-count').textContent") == "24 of 144 rows", f"the link to all rows of a scene shows {text(browser, '#row-count')}")
    browser.run("history.back()")
    until("back leads to the scene", lambda: browser.run("return location.hash") == fragment and text(browser, "#row-count").startswith("36 of"))
    # A choice that depends on another begins anew where the address does not name it.
    browser.run("location.hash = '#compare-scenario=ties&compare-steps=480'")
    until("the finest steps", lambda: browser.run("return document.querySelector('#compare-steps').value") == "480")
    for address in ("#compare-scenario=ties", "#compare-scenario=bars", "#compare-scenario=bars&compare-steps=-1", "#scene=ties"):
        browser.run("location.hash = '#compare-scenario=bars&compare-steps=480'")
        until("the finest steps again", lambda: browser.run("return document.querySelector('#compare-steps').value") == "480")
        browser.run("location.hash = arguments[0]", address)
        until(f"{address} shows the steps that the scene opens with", lambda: browser.run("return document.querySelector('#compare-steps').value") == "120", 3)
    browser.run("location.hash = '#matrix-metric=none&matrix-tag=%3Cimg%3E&fold=gates.99&by.all-gates=x,up&compare-steps=-1'")
    until("a link that names nothing shows what the page opens with", lambda: parts(browser) == opening)
    check(not browser.run("return document.querySelector('#gates details').open"), "what the link does not unfold stays unfolded")


def fluid(browser, folder, web):
    report = Report("A fluid")
    report.scene("vortex", "A vortex")
    report.scene("other", "Another")
    ladder(report, "vortex", "atwood/sph", "error-velocity-end", (1e-2, 5e-3, 2e-3), "m/s")
    ladder(report, "other", "atwood/sph", "error-velocity-end", (1e-2, 5e-3, 2e-3), "m/s")
    side = 30
    levels = lambda at, low, high: {"low": low, "high": high, "at": at}
    grid = [(i, j) for i in range(side) for j in range(side)]
    report.data["pictures"] = [{"s": report.word("vortex"), "m": report.word("atwood/sph"), "n": 480, "dx": 0.03, "c": 10, "t": 1, "particles": side * side, "side": 1 / side, "error_of": "velocity",
                                "x": levels([round(4096 * i / (side - 1)) for i, _ in grid], 0, 1), "y": levels([round(4096 * j / (side - 1)) for _, j in grid], 0, 1),
                                "speed": levels([round(250 * i / (side - 1)) for i, _ in grid], 0.5, 2)}]
    ladder(report, "vortex", "atwood/sph", "velocity-l1", (1e-2, 5e-3, 2e-3), "1")
    cheapest = {"family": "atwood/sph", "method": "atwood/sph", "steps": 240, "error": 5e-4, "cost": 1.5e-3}
    report.data["dominance"] = [{"scenario": "vortex", "metric": "velocity-l1", "unit": "1", "cost": "seconds", "by_budget": [], "stable": [],
                                 "by_error": [{"asked": 1e-3, "contenders": 1, "ranked": [cheapest]}]}]
    path = opens(browser, folder, "fluid", report, web, "#scene=vortex")
    squares = browser.run("return [...document.querySelectorAll('.scene-picture .picture path')].map(p => [(p.getAttribute('d').match(/M/g) || []).length, p.getAttribute('fill')])")
    check(sum(n for n, _ in squares) == side * side and len({fill for _, fill in squares}) == 24, f"squares by colour: {squares}")
    widths = browser.run("return [...document.querySelectorAll('.scene-picture .picture path')].map(p => Math.min(...[...p.getAttribute('d').matchAll(/M([\\d.]+)/g)].map(m => Number(m[1]))))")
    check(widths == sorted(widths), "slow particles do not stand on the left")
    label = browser.run("return document.querySelector('.scene-picture .picture').getAttribute('aria-label')")
    check("speed: 0.5 (dark) to 2 m/s (bright)" in label and "atwood/sph" in label, f"the picture is named {label!r}")
    check(browser.run("return document.querySelectorAll('.gallery .thumbnail svg').length") == 1, "the gallery has no picture of the fluid")
    text = browser.run("return [...document.querySelectorAll('h3, th, p, li, .gallery a')].map(e => e.textContent).join('\\n')")
    check("(velocity l1): use" in text, "the sentence about the cheapest method is missing")
    check(not re.search(r"\[1?\]| 1 \(velocity l1\)|\d 1: atwood", text), "a figure without a unit has the unit 1, or empty brackets")
    # The field as a file: every particle, slow ones on the left, on axes of its extent beside a scale of its values.
    _, plots = everything_saves(browser)
    field = plots["vortex-speed-atwood-sph.svg"]
    squares = {fill: [float(x) for x in re.findall(r"M([\d.]+)", path)] for path, fill in re.findall(r'<path d="([^"]*h-[\d.]+z)" fill="(rgb[^"]*)"', field)}
    check(sum(len(xs) for xs in squares.values()) == side * side and len(squares) > 24, f"{sum(len(xs) for xs in squares.values())} particles in {len(squares)} colours")
    check(max(squares["rgb(0,34,78)"]) < min(squares["rgb(254,232,56)"]), "slow particles do not stand on the left of the file")
    words = re.findall(">([^<>]+)</text>", field)
    check({"0", "1", "x [m]", "y [m]", "0.6", "2", "speed [m/s]"} <= set(words) and "900 particles" in words[0], f"axes and scale of the field: {words}")
    silence(browser, path)
    fluids_table(browser)


# The table of the program (reports/render/fluid_table.cpp): all columns are in sight, on narrow screens one under the other.
def fluids_table(browser):
    heads = ["scenario", "method", "spacing m", "c m/s", "steps", "total", "model", "space", "time", "orders", "not kept"]
    cells = ["taylor-green-parts", "atwood/rk4+sph{kernel=wendland-c4,smoothing=1.8,shift=1,density_diffusion=0.1}", "0.05", "10", "320", "0.00074", "0.00071", "0.00082", "<= 6.2e-05", "time 4.01", "momentum 0.00042"]
    browser.run("""const box = document.createElement('div'); box.className = 'scroll'; box.id = 'probe';
        box.innerHTML = `<table class="fluids"><thead><tr>${arguments[0].map(h => `<th>${h}</th>`).join('')}</tr></thead><tbody><tr>${arguments[1].map((c, i) => `<td data-head="${arguments[0][i]}">${c}</td>`).join('')}</tr></tbody></table>`;
        document.querySelector('section').prepend(box)""", heads, cells)
    measure = "const b = document.querySelector('#probe'); return [b.scrollWidth - b.clientWidth, getComputedStyle(b.querySelector('thead')).display, getComputedStyle(b.querySelector('td:nth-child(9)'), '::before').content]"
    for width, head in ((1280, "table-header-group"), (420, "none")):
        browser.devtools("Emulation.setDeviceMetricsOverride", width=width, height=844, deviceScaleFactor=1, mobile=False)
        time.sleep(0.3)
        beyond, display, before = browser.run(measure)
        check(beyond <= 0 and display == head, f"at {width} px the table of fluids goes {beyond} px beyond its box, its head is {display}")
        check(width > 760 or before == '"time"', f"at {width} px a cell says {before}")
    browser.devtools("Emulation.clearDeviceMetricsOverride")
    browser.run("document.querySelector('#probe').remove()")


def folds(browser, folder, report, web):
    """What the page unfolds by itself, and what it builds again, stays as the reader sees it."""
    opens(browser, folder, "ranks", report, web)
    seen = lambda: browser.run("return [...document.querySelectorAll('#gates details, #metrics details, #plots details')].map(d => d.open)")
    browser.run("document.querySelector('nav a[href=\"#gates\"]').click()")
    browser.run("document.querySelector('nav a[href=\"#plots\"]').click()")
    fragment, before = browser.run("return location.hash"), seen()
    check(browser.run("return document.querySelector('#gates details').open"), "a link to a section does not unfold it")
    opens(browser, folder, "ranks", report, web, fragment)
    check(seen() == before, f"the link {fragment} unfolds {seen()}, not {before}")
    browser.run("document.querySelector('#gates summary').click(); document.querySelector('nav a[href=\"#plots\"]').click();")
    fragment, before = browser.run("return location.hash"), seen()
    check("gates" not in fragment, f"what is folded as it opened stands in the address: {fragment}")
    opens(browser, folder, "ranks", report, web, fragment)
    check(seen() == before, f"the link {fragment} unfolds {seen()}, not {before}")
    browser.run("location.hash = '#scene=refused'")
    until("the scene is open", lambda: browser.run("return document.querySelector('#plot-scenario').value") == "refused")
    opening = seen()
    browser.run("document.querySelector('#plots summary').click()")
    before = seen()
    check(before != opening and "fold=plots.0" in browser.run("return location.hash"), f"folding the gates of a scene leaves {before}")
    for _ in range(2):
        browser.click("#theme")
        check(seen() == before, f"another theme folds {seen()}, not {before}")
    browser.run("document.querySelector('#plots summary').click()")
    check(seen() == opening and "fold=" not in browser.run("return location.hash"), "unfolding again leaves a fold in the address")


def dependent(browser, folder, web):
    """The scenes of a contest depend on its cost, and begin anew with it."""
    report = tumbling()
    table = report.data["dominance"][0]
    report.data["dominance"] = [{**table, "scenario": scene, "cost": cost} for cost in ("seconds", "evaluations") for scene in ("tumble", "bounce")]
    path = opens(browser, folder, "dependent", report, web)
    chosen = lambda: browser.run("return ['#dominance-cost', '#dominance-scenario'].map(s => document.querySelector(s).value)")
    for address, wanted in (("#dominance-cost=evaluations", ["evaluations", "tumble"]), ("#dominance-cost=seconds", ["seconds", "tumble"]), ("#scene=tumble", ["seconds", "tumble"])):
        browser.run("location.hash = '#dominance-cost=evaluations&dominance-scenario=bounce'")
        until("another contest", lambda: chosen() == ["evaluations", "bounce"])
        browser.run("location.hash = arguments[0]", address)
        until(f"{address} shows {wanted}", lambda: chosen() == wanted, 3)
    silence(browser, path)


def at_opening(browser, folder, report, web, script):
    """What is chosen on the scene that the page opens with, which no address names yet, and the colours of its outlines."""
    opens(browser, folder, "beside", report, web)
    change(browser, "#scene-magnify", "10")
    browser.click(".of-method:last-of-type")
    browser.run("const s = document.querySelector('.scene-picture .time'); s.value = 500; s.dispatchEvent(new Event('input'));")
    state = "return [document.querySelector('#scene-magnify').value, document.querySelector('.scene-picture .time').value, [...document.querySelectorAll('.of-method')].map(b => b.ariaPressed)]"
    fragment, before = browser.run("return location.hash"), browser.run(state)
    check(before == ["10", "500", ["true", "false"]], f"the choices are {before}")
    opens(browser, folder, "beside", report, web, fragment)
    check(browser.run(state) == before and len(browser.run(script)) == 2, f"{fragment} restores {browser.run(state)}, not {before}")
    # Another metric opens with other methods, and so with other colours.
    colours = """const of = m => document.querySelector(`#plots .legend button[data-method='${m}'] svg [stroke]`)?.getAttribute('stroke');
        return [...document.querySelectorAll('.of-method')].map(b => [b.style.getPropertyValue('--colour').trim(), of(b.textContent.split(',')[0])])"""
    first = browser.run(colours)
    change(browser, "#plot-metric", "impact-time-error")
    check(browser.run(state) == before, f"another metric leaves {browser.run(state)}, not {before}")
    fragment, second = browser.run("return location.hash"), browser.run(colours)
    opens(browser, folder, "beside", report, web, fragment)
    for pairs in (first, second, browser.run(colours)):
        check(all(outline == curve and curve for outline, curve in pairs), f"outlines and curves have the colours {pairs}")
    check(first != second, f"another metric has the same colours: {first}")


def beside_truth(browser, folder, web):
    """A point on a line from 0 to 1 m; one method is behind it by up to 1 mm, another by 2 mm and turned by 0.1 mrad."""
    report = tumbling()
    times = [0, 0.5, 1]
    report.data["scenes"] = [{"id": "tumble", "t_end": 1, "times": times, "poses": [{"p": [0, 0, 0, 0.5, 0, 0, 1, 0, 0], "q": [1, 0, 0, 0] * 3}],
                              "scene": {"bodies": [{"name": "box", "fixed": False, "p": [0, 0, 0], "q": [1, 0, 0, 0], "shape": {"kind": "box", "half": [0.05, 0.05, 0.05]}}], "joints": [], "ropes": [], "forces": []},
                              "methods": [{"id": "atwood/rk4", "steps": 240, "bodies": [{"p": [0, 0, 0, -5e-4, 0, 0, -1e-3, 0, 0], "r": [0] * 9}]},
                                          {"id": "ode/default", "steps": 240, "bodies": [{"p": [0, 0, 0, -1e-3, 0, 0, -2e-3, 0, 0], "r": [0, 0, 0, 0, 0, 5e-5, 0, 0, 1e-4]}]}]}]
    path = opens(browser, folder, "beside", report, web, "#scene=tumble&t=1")
    # The centres of the drawn shapes, of the truth and of the methods, in units of the picture.
    script = """const middle = e => { const b = e.getBBox(); return b.x + b.width / 2; };
        return [middle(document.querySelector('.scene-picture .bodies .body')), ...[...document.querySelectorAll('.scene-picture .ghosts')][1].querySelectorAll('polygon')].map(e => typeof e === 'number' ? e : middle(e))"""
    caption = lambda: text(browser, ".scene-picture figcaption")
    truth, near, far = browser.run(script)
    check("100 times as far from the truth" in caption(), f"the magnification is not said: {caption()}")
    check(abs((truth - far) / (truth - near) - 2) < 0.05 and truth - near > 10, f"100 times 1 and 2 mm of 1 m are drawn as {truth - near} and {truth - far}")
    change(browser, "#scene-magnify", "1")
    check(abs(browser.run(script)[1] - truth) < 1 and "as they are" in caption(), "errors as they are")
    browser.click(".of-method:last-of-type")
    check(len(browser.run(script)) == 2, "a method is not switched off")
    fragment = browser.run("return location.hash")
    opens(browser, folder, "beside", report, web, fragment)
    check(len(browser.run(script)) == 2 and browser.run("return document.querySelector('#scene-magnify').value") == "1", f"the link {fragment} does not restore the methods")
    ladder(report, "tumble", "ode/default", "impact-time-error", (1e-9, 1e-9, 1e-9), "s")
    ladder(report, "tumble", "bullet64/default", "impact-time-error", (1e-5, 1e-5, 1e-5), "s")
    ladder(report, "tumble", "atwood/rk4", "impact-time-error", (1e-2, 1e-2, 1e-2), "s")
    at_opening(browser, folder, report, web, script)
    silence(browser, path)


def themes(browser):
    dark = 0
    for _ in range(2):
        contrast(browser)
        dark += browser.run("return getComputedStyle(document.body).backgroundColor") == "rgb(18, 21, 24)"
        browser.click("#theme")
    check(dark == 1, "the two themes are not one light and one dark")


def bibtex(browser, folder, web):
    """An entry whose braces match, with one field of each name, where TeX's own signs are written out."""
    opens(browser, folder, "cite", tumbling(r"50 % of {a box} & $x_1^2$ \ #~ " + HOSTILE), web)
    browser.click("#cite-button")
    entry = browser.run("return document.querySelector('#cite pre').textContent")
    fields = dict(re.findall(r"^  (\w+) += \{(.*)\},?$", entry, re.MULTILINE))
    check(re.fullmatch(r"@misc\{[\w-]+,\n(  \w+ += \{.*\},\n)*  \w+ += \{.*\}\n\}", entry) and {"title", "howpublished", "year", "note"} == set(fields), f"the entry: {entry}")
    check(fields["year"] == "2026" and "commit 0123abc" in fields["note"], f"year and note: {fields}")
    bare = re.sub(r"\\textbackslash\{\}|\\[\^~]\{\}|\\[{}$&#_%]", "", fields["title"])
    check(bare.startswith("{") and bare.endswith("}") and not re.search(r"[\\{}$&#^_%~]", bare[1:-1]), f"signs of TeX in the title: {fields['title']}")
    browser.run("document.querySelector('#cite').close()")


def stillness(browser):
    """Who asked for less motion: a link leads to its section at once, and nothing plays by itself."""
    browser.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
    browser.run("window.scrolls = []; Element.prototype.scrollIntoView = function (how) { scrolls.push(how.behavior); }")
    browser.click("nav a[href='#matrix']")
    check(browser.run("return scrolls") [-1] == "auto", f"scrolled: {browser.run('return scrolls')}")
    moving = browser.run("return document.getAnimations().length + [...document.querySelectorAll('*')].filter(e => parseFloat(getComputedStyle(e).transitionDuration) > 0).length")
    check(moving == 0, f"{moving} elements move")
    browser.devtools("Emulation.setEmulatedMedia", features=[])


def narrow(browser, folder, web):
    """At 390 px the first plot stands on the first screen and a half."""
    browser.devtools("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=2, mobile=True)
    opens(browser, folder, "narrow", tumbling(), web)
    time.sleep(0.3)
    top, bottom, wide = browser.run("const r = document.querySelector('#plots .chart:not([hidden]) .plot').getBoundingClientRect(); return [r.top + scrollY, r.bottom + scrollY, document.documentElement.scrollWidth]")
    check(wide <= 390, f"the page is {wide} px wide")
    check(bottom <= 1.5 * 844, f"the first plot reaches from {top:.0f} to {bottom:.0f} px, the first screen and a half ends at {1.5 * 844:.0f}")
    browser.devtools("Emulation.clearDeviceMetricsOverride")


def many(browser, folder, web, scenes):
    report = Report("Many")
    report.data["scenes"] = []
    place = lambda m, error: {"family": f"engine{m}/default", "method": f"engine{m}/default", "steps": 240, "error": error, "cost": 1e-3 * (m + 1)}
    for k in range(scenes):
        report.scene(f"scene-{k}", f"Scene {k}")
        if k > 5:  # little to say: less than half a page
            ladder(report, f"scene-{k}", "engine0/default", "error-position-max", (1, 0.5, 0.25))
            continue
        for m in range(12):
            ladder(report, f"scene-{k}", f"engine{m}/default", "error-position-max", [10.0 ** -m / n for n in (1, 2, 4)], seconds=1e-3)
        levels = [10.0 ** -level for level in range(1, 12)]
        report.data["dominance"].append({"scenario": f"scene-{k}", "metric": "error-position-max", "unit": "m", "cost": "seconds", "by_budget": [], "stable": [],
                                         "by_error": [{"asked": error, "contenders": 2, "ranked": [place(1, error), place(2, error)]} for error in levels]})
        report.data["scenes"].append({"id": f"scene-{k}", "t_end": 1, "times": [0, 1], "poses": [{"p": [0, 0, 0, 1, 0, 0], "q": [1, 0, 0, 0] * 2}],
                                      "scene": {"bodies": [{"name": "box", "fixed": False, "p": [0, 0, 0], "q": [1, 0, 0, 0], "shape": {"kind": "box", "half": [0.05, 0.05, 0.05]}}], "joints": [], "ropes": [], "forces": []}})
        report.data["verdicts"] += [{"judgement": "fail", "scenario": f"scene-{k}", "method": f"engine{m % 12}/default", "steps": 240, "metric": "error-position-max", "unit": "m", "value": 3, "bar": 0,
                                     "kind": "at most", "allowed": "<= 2", "margin": -1, "text": "", "reason": "A reason of several words. " * 6, "origin": "", "rerun": ""} for m in range(30)]
    opens(browser, folder, f"paper-{scenes}", report, web)


def page_count(browser):
    begun = time.time()
    paper = browser.paper()
    print(f"on paper: {len(paper)} bytes, {time.time() - begun:.1f} s")
    return len(re.findall(rb"/Type\s*/Page\b", paper))


def prints(browser, folder, web):
    """Every scene has one page: ten scenes fewer are ten pages fewer, and no scene is cut off."""
    many(browser, folder, web, 11)
    all_pages = page_count(browser)
    check(browser.run("return document.querySelector('#sheets')") is None, "the pages of the scenes stay after printing")
    browser.run("const s = document.createElement('style'); s.textContent = '.sheet:not(:first-of-type) { display: none; }'; document.head.append(s)")
    one_sheet = page_count(browser)
    check(all_pages - one_sheet == 10, f"10 more scenes take {all_pages - one_sheet} more pages")
    browser.run("document.querySelector('head > style:last-of-type').remove(); dispatchEvent(new Event('beforeprint'))")
    browser.devtools("Emulation.setEmulatedMedia", media="print")
    browser.devtools("Emulation.setDeviceMetricsOverride", width=703, height=1017, deviceScaleFactor=1, mobile=False)
    heights = browser.run("return [...document.querySelectorAll('.sheet')].map(s => [s.scrollHeight, s.clientHeight, s.querySelectorAll('svg').length])")
    browser.devtools("Emulation.clearDeviceMetricsOverride")
    browser.devtools("Emulation.setEmulatedMedia", media="")
    browser.run("dispatchEvent(new Event('afterprint'))")
    check(len(heights) == 11 and all(inner <= outer <= 1017 and plots >= 1 for inner, outer, plots in heights), f"heights of the pages of the scenes: {heights}")


def whole_when_loaded(browser, folder, web):
    """What prints a page once it is loaded gets all of it: the load event waits for the report."""
    many(browser, folder, web, 11)
    loaded, drawn = browser.run("return [performance.getEntriesByType('navigation')[0].loadEventStart, Number(document.documentElement.dataset.drawn)]")
    check(loaded >= drawn > 0, f"the page is loaded after {loaded} ms and drawn after {drawn} ms")
    check(browser.run("return document.querySelectorAll('iframe').length") == 0, "the frame that delayed the load event stays")


def folds_long_tables(browser, folder, web):
    report = tumbling()
    report.data["tables"] = [{"id": f"t{n}", "title": f"{n} lines", "columns": ["scene", "method", "time"],
                              "rows": [["scene", f"method-{i}", i] for i in range(n)], "notes": ["A note."]} for n in (24, 25)]
    opens(browser, folder, "tables", report, web)
    seen = browser.run("return [...document.querySelectorAll('#tables table')].map(t => [t.rows.length, t.closest('details')?.open ?? null, t.rows[1].cells[1].className])")
    check(seen == [[25, None, ""], [26, False, ""]], f"tables of 24 and 25 lines: {seen}")
    where = browser.run("return [...document.querySelectorAll('#app > section')].map(s => s.id)")
    check(where.index("tables") > where.index("scenes") and where.index("tables") > where.index("plots"), f"tables stand before the scenes: {where}")


def goals(browser, folder, web):
    report = tumbling()
    entrant = lambda method, **more: {"method": method, "steps": 60, "error": 3e-12, "bar": 0, "seconds": 1e-4, "evaluations": 2600, "ns_per_step": NAN,
                                      "accurate": True, **more}
    goal = lambda name, ours: {"id": name, "title": name, "scenario": "tumble", "metric": "error-state-end", "unit": "m", "wanted_error": 2e-11,
                               "budget_kind": "seconds", "budget": 1e-3, "reached": True, "ours": ours, "rival": None, "uncounted": None, "ratio": NAN,
                               "ratio_low": NAN, "ratio_high": NAN, "why": ""}
    machine = {"timings": 40, "interrupted": 7, "repeated": 5, "ghz_low": 2.6, "ghz_high": 3.1, "again": 2, "busy": True}
    report.data["goals"] = [{**goal("known", entrant("atwood/radau15:1e-12", floor=4.4e-13)), "machine": machine},
                            goal("no condition", entrant("atwood/rk4")), goal("wild", entrant("atwood/rk4", last_quarter="inf"))]
    opens(browser, folder, "goals", report, web)
    told = browser.run("return [...document.querySelectorAll('#goals tbody tr')].map(row => row.innerText.replace(/\\s+/g, ' '))")
    floor = "floor: error 4.4e-13 m by rounding the initial state alone (condition \u00d7 unit round-off)"
    check([floor in row for row in told] == [True, False, False], f"the floor beside a goal: {told}")
    check("the calmest of 3: a busy machine" in told[0], f"a goal that was timed again: {told[0]}")
    check("not finite over the last quarter" in told[2], f"a state that is not finite: {told[2]}")


def main():
    found = programs()
    if not found:
        return SKIPPED
    web = sys.argv[1]
    browser = Browser(*found)
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = opens(browser, folder, "tumbling", tumbling(), web)
            for test in (sentences, curves, accessible, themes, stillness):
                test(browser)
                print("ok:", test.__name__)
            silence(browser, path)
            unmeasured_metric(browser, folder, web)
            report, expected = ranks()
            path = opens(browser, folder, "ranks", report, web)
            matrix(browser, expected)
            print("ok: matrix")
            for test in (matrix_links, folds):
                test(browser, folder, report, web)
                print("ok:", test.__name__)
            silence(browser, path)
            for test in (fluid, dependent, beside_truth, bibtex, narrow, whole_when_loaded, folds_long_tables, goals, prints):
                test(browser, folder, web)
                print("ok:", test.__name__)
    except AssertionError as error:
        print("FAILED:", error)
        return 1
    finally:
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
