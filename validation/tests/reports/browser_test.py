#!/usr/bin/env python3
"""Opens a report from disk in headless Chromium and uses it as a reader would: sorts, filters, zooms, hovers, switches
to dark, prints. No error may reach the console, no request the network. browser_test.py WRITE_SYNTHETIC_REPORT
Answers 77 (skipped) with a word where Chromium or chromedriver is missing."""
import csv
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

from accessibility import accessible, contrast, luminance
from chromium import DOWN, HOSTILE, SKIPPED, UP, Browser, check, move, programs, silence, until
from saves import uncontrolled

LIMIT = 3_000_000


def column(browser, number):
    return browser.run("""return [...document.querySelectorAll('#rows tbody tr:not(.spacer)')]
        .map(row => row.children[arguments[0]]?.textContent)""", number)


def opens(browser, path):
    browser.post("/url", {"url": pathlib.Path(path).as_uri()})
    until("the report is drawn", lambda: browser.run("return document.documentElement.dataset.ready === 'true'"), 40)
    check(browser.run("return document.querySelector('#verdict .word').textContent") == "Fail", "the verdict is not shown")
    order = browser.run("return [...document.querySelectorAll('main > section')].map(s => s.id)")
    check(order[:2] == ["story", "failing"], f"failing cells do not stand on top: {order}")
    told = browser.run("return document.querySelector('#story').innerText")
    check("Not passed: " in told and "Which to use" in told and "Without a figure" in told and "What each engine loses at 240 steps a second" in told, f"the first screen tells: {told}")
    cards = browser.run("return [...document.querySelectorAll('#failing .badge')].map(b => b.className)")
    check(cards == ["badge fail", "badge fail", "badge fail", "badge unverifiable", "badge not-run"], f"failing cards: {cards}")
    words = browser.run("return [...document.querySelectorAll('#failing .card')].map(c => c.textContent)")
    check(sum("oblique" in text for text in words) == 1 and all(f"{n} steps" in " ".join(words) for n in (120, 240, 480)), f"a ladder's failures do not share a card: {words}")
    check(all("/home/" not in text and "validation/gates/default.toml:12" in text for text in words), f"a gate's origin: {words}")
    check("0.125 m" in browser.run("return document.querySelector('#laws').textContent"), "the law of 0.125 m is missing")
    check(browser.run("return document.body.textContent.includes(arguments[0])", HOSTILE), "the hostile name is not shown as text")
    check(browser.run("return document.querySelectorAll('img, iframe, [onerror], [onmouseover]').length") == 0, "hostile text became an element")


def sorts(browser):
    heads = browser.run("return [...document.querySelectorAll('#rows thead th')].map(t => t.textContent)")
    at = heads.index("value")
    button = f"#rows thead th:nth-child({at + 1}) button"
    browser.type("#row-search", "kepler-e0.6 error-position-max")
    until("the search leaves 20 ladders", lambda: browser.run("return document.querySelector('#row-count').textContent").startswith("200 of "))
    browser.click(button)
    check(browser.run("return document.querySelector(arguments[0]).parentElement.ariaSort", button) == "ascending", "aria-sort is not ascending")
    rising = [float(text.lstrip("\u2264 ")) for text in column(browser, at)]
    check(len(rising) > 15 and rising == sorted(rising), f"not ascending: {rising}")
    browser.click(button)
    falling = [float(text) for text in column(browser, at)]
    check(falling == sorted(falling, reverse=True) and falling[0] > rising[0], f"not descending: {falling}")


def filters(browser):
    browser.run("""const s = document.querySelector('#row-search'); s.value = ''; s.dispatchEvent(new Event('input'));
        const t = document.querySelector('#row-status'); t.value = 'diverged'; t.dispatchEvent(new Event('change'));""")
    heads = browser.run("return [...document.querySelectorAll('#rows thead th')].map(t => t.textContent)")
    until("only diverged rows", lambda: set(column(browser, heads.index("status"))) == {"diverged"})
    check(any(HOSTILE in text for text in column(browser, heads.index("reason"))), "the hostile reason is not in the table")
    browser.run("[...document.querySelectorAll('#rows .bar button')].find(b => b.textContent === 'clear').click()")
    total = browser.run("return document.querySelector('#row-count').textContent")
    check(total.split()[0] == total.split()[2], f"clear does not clear: {total}")
    view = "document.querySelector('#rows .rows')"
    first = column(browser, 0)[0]
    browser.run(f"{view}.scrollTop = {view}.scrollHeight / 2")
    until("other rows after scrolling", lambda: column(browser, 0)[0] != first)
    count = browser.run("return document.querySelectorAll('#rows tbody tr').length")
    check(count < 120, f"{count} rows are in the page: the table is not virtual")


def side_by_side(browser):
    browser.run("""const s = document.querySelector('#compare-scenario'); s.value = 'kepler-e0.6'; s.dispatchEvent(new Event('change'));""")
    ladder = browser.run("return [...document.querySelector('#compare-steps').options].map(o => o.value)")
    lines = lambda: browser.run("return [...document.querySelectorAll('#compare tbody tr')].map(r => [...r.children].map(c => c.textContent))")
    before = lines()
    check(len(ladder) > 1 and any(line[0] == "atwood/rk4" for line in before), f"side by side has no rk4: {before}")
    browser.run("""const s = document.querySelector('#compare-steps'); s.selectedIndex = s.selectedIndex ? 0 : 1; s.dispatchEvent(new Event('change'));""")
    check(lines() != before and lines(), "another step count shows the same figures")


def contacts(browser):
    lines = browser.run("return [...document.querySelectorAll('#sweep tbody tr')].map(r => [...r.children].map(c => c.textContent))")
    check(lines == [["all pairs answered", "0 of 2 pairs", "14 of 1 pair"], ["box-box", "0", "14"], ["sphere-plane", "0", "\u2013"]], f"the sweep shows {lines}")
    marked = browser.run("return [...document.querySelectorAll('#sweep .short')].map(c => c.textContent)")
    check(marked == ["14 of 1 pair", "14"], f"misses that are marked: {marked}")
    for select in ("#compare-scenario", "#plot-scenario"):
        check(not browser.run("return [...document.querySelector(arguments[0]).options].some(o => o.value === 'geometry-sweep')", select), f"{select} offers a sweep of poses, which has no steps")
    browser.run("""const s = document.querySelector('#compare-scenario'); s.value = 'stack-10'; s.dispatchEvent(new Event('change'));""")
    heads = browser.run("return [...document.querySelectorAll('#compare th')].map(c => c.textContent)")
    check(heads == ["method", "penetration-max [m]"], f"side by side has {heads}")
    cut = browser.run("""return [...document.querySelectorAll('#matrix .tilted span')].filter(s => s.scrollHeight > s.clientHeight || s.scrollWidth > s.clientWidth)
        .map(s => s.textContent)""")
    check(not cut, f"headings of the matrix are cut off: {cut}")


def bounces(browser):
    browser.run("""const s = document.querySelector('#compare-scenario'); s.value = 'drop'; s.dispatchEvent(new Event('change'));""")
    check(browser.run("return document.querySelector('#compare-steps').value") == "240", "a scene with contacts does not open at the finest steps that most have")
    lines = browser.run("return [...document.querySelectorAll('#compare tr')].map(r => [...r.children].map(c => c.textContent))")
    check(lines == [["method", "error-position-max [m]", "impact-time-error [s]", "error-position-end [m]", "step-time [s]"],
                    ["bullet64/default", "4.17e-4", "\u2013 2 of 16 missed", "6e-32", "not timed: slow"],
                    ["atwood/symplectic-euler+impulse{solver=direct}", "4.17e-4", "0.001", "6e-32", "1e-6"]], f"bounces side by side: {lines}")
    browser.run("""const s = document.querySelector('#plot-scenario'); s.value = 'drop'; s.dispatchEvent(new Event('change'));""")
    orders = browser.run("return [...document.querySelectorAll('#plots .orders td')].map(c => c.textContent)")
    check(orders == ["inconclusive (no convergence)", "inconclusive (\u00b1 0.4)"], f"orders that are none: {orders}")
    browser.click("#plots [data-plot='all']")
    shown = browser.run("return [...document.querySelectorAll('#plots .chart')].filter(c => !c.hidden).map(c => c.id)")
    check(shown == ["plot-step", "plot-cpu"], f"plots of a scene without curves over time: {shown}")


def settings(browser):
    words = browser.run("return document.querySelector('#engines').textContent")
    check("rest_sweeps = 100" in words and "solver = direct" in words and words.count("sleeping = false") > 1, "a response's settings are not printed")
    check("ran-nowhere" not in words and "Follows nothing" not in words, "what did not run is printed")
    check("nan" not in browser.run("return document.querySelector('#compare').textContent + document.querySelector('#matrix').textContent").split(), "a missing figure shows as nan")


def plots(browser):
    browser.run("""const s = document.querySelector('#plot-scenario'); s.value = 'kepler-e0.6'; s.dispatchEvent(new Event('change'));
        document.querySelector("#plots [data-plot='step']").click();""")
    one = browser.run("return [...document.querySelectorAll('#plots .chart')].filter(c => !c.hidden).map(c => c.id)")
    check(one == ["plot-step"], f"plots that are shown: {one}")
    few = browser.run("return document.querySelectorAll('#plots .legend button').length")
    check(2 <= few <= 8, f"a plot opens with {few} curves")
    browser.run("""[...document.querySelectorAll('#plots .legend-row .pair button')].find(b => b.textContent === 'all').click();
        document.querySelector("#plots [data-plot='all']").click();
        document.querySelector('#plot-step').scrollIntoView({block: 'center'});""")
    until("the plot is drawn", lambda: browser.run("return document.querySelector('#plot-step canvas') !== null"))
    ink = browser.run("""const c = document.querySelector('#plot-step canvas');
        const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; const seen = new Set();
        for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200) seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]); return seen.size;""")
    check(ink > 20, f"the plot has only {ink} colours: no curves?")
    time.sleep(0.3)
    box = browser.run("const r = document.querySelector('#plot-step .u-over').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]")
    left, top, width, height = box
    # Hover: along a grid of places until one is near a point.
    for part in range(2, 30):
        browser.mouse(move(left + width * 0.96, top + height * part / 32, 10))
        if not browser.run("return document.querySelector('#plot-step .tip').hidden"):
            break
    words = browser.run("return document.querySelector('#plot-step .readout').textContent")
    check("steps" in words and "h = " in words and "/" in words, f"the readout does not speak: {words!r}")
    # Zoom: drag a box, look at the range, take it back.
    browser.mouse(move(left + width * 0.3, top + height * 0.2), DOWN, move(left + width * 0.6, top + height * 0.5), move(left + width * 0.7, top + height * 0.6), UP)
    until("zoomed", lambda: browser.run("return document.querySelector('#plot-step').dataset.zoomed === 'true'"))
    low, high = (float(x) for x in browser.run("return document.querySelector('#plot-step').dataset.x").split())
    browser.click("#plot-step .reset")
    until("reset", lambda: browser.run("return document.querySelector('#plot-step').dataset.zoomed === 'false'"))
    full_low, full_high = (float(x) for x in browser.run("return document.querySelector('#plot-step').dataset.x").split())
    check(abs((high - low) / (full_high - full_low) - 0.4) < 0.03, f"a drag over 40 % of the width shows {(high - low) / (full_high - full_low):.0%}")
    browser.click("#plots .legend button[data-method='atwood/rk4']")
    check(browser.run("return document.querySelector(\"#plots .legend button[data-method='atwood/rk4']\").ariaPressed") == "false", "a method does not switch off")
    browser.click("#plots .legend button[data-method='atwood/rk4']")
    browser.run("document.querySelector('#plot-cpu .plot').focus()")
    browser.post("/actions", {"actions": [{"type": "key", "id": "keys", "actions": [{"type": "keyDown", "value": "\ue014"}, {"type": "keyUp", "value": "\ue014"}]}]})
    until("the keyboard reads a point", lambda: "/" in browser.run("return document.querySelector('#plot-cpu .readout').textContent"))
    # Other scenarios (the hostile one among them) and every metric draw.
    browser.run("""for (const o of [...document.querySelector('#plot-scenario').options].filter((_, i) => i % 5 === 3)) {
        const s = document.querySelector('#plot-scenario'); s.value = o.value; s.dispatchEvent(new Event('change'));
        const m = document.querySelector('#plot-metric');
        for (const p of [...m.options]) { m.value = p.value; m.dispatchEvent(new Event('change')); } }""")


def ready(browser):
    until("the report is drawn", lambda: browser.run("return document.documentElement.dataset.ready === 'true'"), 40)


def state_of(browser):
    return browser.run("""const pressed = [...document.querySelectorAll('#plots .legend button[aria-pressed=true]')].map(b => b.dataset.method);
        const value = id => document.querySelector(id).value;
        return [value('#plot-scenario'), value('#plot-metric'), document.querySelector('#plots').dataset.plot, pressed.sort(), value('#row-search'),
          value('#row-status'), document.querySelector('#row-count').textContent,
          [...document.querySelectorAll('#rows th[aria-sort]')].map(t => t.getAttribute('aria-sort')), document.querySelector('#plot-step').dataset.x ?? '']""")


def links(browser, path):
    """A link restores scene, metric, plot, methods, zoom, filter and sorting; one that names what is not there does no harm."""
    browser.run("""const set = (id, v, e = 'change') => { const s = document.querySelector(id); s.value = v; s.dispatchEvent(new Event(e)); };
        set('#plot-scenario', 'kepler-e0.6'); set('#plot-metric', 'error-velocity-max'); document.querySelector("#plots [data-plot='step']").click();
        set('#row-status', 'ok'); set('#row-search', 'kepler', 'input'); document.querySelector('#rows thead th:nth-child(3) button').click();""")
    browser.click("#plots .legend button:first-child")
    browser.run("document.querySelector('#plot-step').scrollIntoView({block: 'center', behavior: 'instant'})")
    until("the plot is drawn", lambda: browser.run("return document.querySelector('#plot-step canvas') !== null"))
    time.sleep(0.5)
    left, top, width, height = browser.run("const r = document.querySelector('#plot-step .u-over').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]")
    browser.mouse(move(left + width * 0.3, top + height * 0.2), DOWN, move(left + width * 0.5, top + height * 0.5), move(left + width * 0.7, top + height * 0.6), UP)
    until("the zoom is in the address", lambda: "zoom=step" in browser.run("return location.hash"))
    before, fragment = state_of(browser), browser.run("return location.hash")
    check(before[8] and before[4] == "kepler" and "row-status=ok" in fragment and "shown=" in fragment, f"the address holds {fragment}")
    browser.post("/url", {"url": "about:blank"})
    browser.post("/url", {"url": pathlib.Path(path).as_uri() + fragment})
    ready(browser)
    browser.run("document.querySelector('#plot-step').scrollIntoView({block: 'center', behavior: 'instant'})")
    until("the link restores its state", lambda: state_of(browser) == before or print(state_of(browser), before), 8)
    browser.run("location.hash = '#scene=nowhere&metric=none&plot=x&zoom=step,1,nan&row-status=%3Cimg%3E&sort=,&t=1e999&shown=-'")
    time.sleep(0.3)
    check(browser.run("return document.querySelectorAll('img').length") == 0, "a link made an element")
    # A method whose id holds a comma comes back from the link that the page wrote.
    browser.run("""const s = document.querySelector('#plot-scenario'); s.value = 'stack-10'; s.dispatchEvent(new Event('change'));
        [...document.querySelectorAll('#plots .legend-row .pair button')].find(b => b.textContent === 'all').click();""")
    fragment, pressed = browser.run("return location.hash"), state_of(browser)[3]
    check(pressed == ["atwood/symplectic-euler+impulse{solver=direct,erp=0.5}"], f"methods of stack-10: {pressed}")
    browser.run("location.hash = '#scene=kepler-e0.6'")
    until("another scene is open", lambda: state_of(browser)[0] == "kepler-e0.6")
    browser.run("location.hash = arguments[0]", fragment)
    until("the link with a comma restores its method", lambda: state_of(browser)[0] == "stack-10" and state_of(browser)[3] == pressed)
    browser.run("location.hash = '#scene=ballistic'")
    until("a link to a scene opens it", lambda: browser.run("return document.querySelector('#plot-scenario').value") == "ballistic")


def exports(browser):
    browser.run("""window.saved = []; URL.createObjectURL = blob => { saved.push(blob); return 'blob:null/0'; };
        HTMLAnchorElement.prototype.click = function () { saved[saved.length - 1].called = this.download; };""")
    text = lambda selector: browser.run("""document.querySelector(arguments[0]).click(); return saved[saved.length - 1].text()""", selector)
    rows = list(csv.reader(io.StringIO(text("#rows .save button"))))
    count = int(browser.run("return document.querySelector('#row-count').textContent").split()[0])
    check(len(rows) == count + 1 and {len(row) for row in rows} == {12} and rows[0][0] == "scenario", f"the CSV has {len(rows)} lines for {count} rows")
    browser.run("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    without = uncontrolled(browser)
    check(without == ([], []), f"tables without CSV, plots without SVG and PNG: {without}")
    gates = list(csv.reader(io.StringIO(text("#gates .save button"))))
    check(any(HOSTILE in cell for row in gates for cell in row), "the hostile name is not in the CSV of the gates")
    drawing = xml.etree.ElementTree.fromstring(text("#plots .chart:not([hidden]) [data-save=SVG]"))
    check(len(drawing.findall(".//{*}polyline")) >= 2, "the saved SVG has no curves")
    browser.run("document.querySelector('#plots .chart:not([hidden]) [data-save=PNG]').click()")
    until("a PNG is saved", lambda: browser.run("return saved[saved.length - 1].type") == "image/png")
    check(browser.run("return saved[saved.length - 1].arrayBuffer().then(b => [...new Uint8Array(b).slice(1, 4)])") == [80, 78, 71], "the PNG is none")
    browser.click("#cite-button")
    words = browser.run("return document.querySelector('#cite').textContent")
    check("@misc{" in words and "command: " in words, f"cite says {words}")
    browser.run("document.querySelector('#cite').close()")


def motion(browser):
    """The picture of a scene plays and follows its slider."""
    browser.run("document.querySelector('#plot-scenario').value = document.querySelector('.thumbnail svg').closest('a').getAttribute('href').slice(7); "
                "document.querySelector('#plot-scenario').dispatchEvent(new Event('change'));")
    drawn = "return document.querySelector('.scene-picture .bodies').innerHTML"
    start = browser.run(drawn)
    browser.run("const s = document.querySelector('.scene-picture .time'); s.value = 500; s.dispatchEvent(new Event('input'));")
    middle = browser.run(drawn)
    check(start and start != middle and "t=0.5" in browser.run("return location.hash"), "the slider does not move the scene")
    browser.click(".scene-picture .play")
    until("it plays", lambda: browser.run(drawn) != middle)
    browser.click(".scene-picture .play")


def dark(browser):
    page = "return getComputedStyle(document.body).backgroundColor"
    contrast(browser)
    light = browser.run(page)
    browser.click("#theme")
    until("dark", lambda: browser.run(page) != light)
    rgb = lambda colour: [int(part) for part in re.findall(r"\d+", colour)]
    check(luminance(rgb(browser.run(page))) < 0.02 < 0.8 < luminance(rgb(light)), "the switch does not lead from light to dark")
    contrast(browser)
    browser.click("#theme")
    check(browser.run(page) == light, "the switch does not lead back")


def narrow(browser):
    browser.devtools("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=2, mobile=False)
    time.sleep(0.3)
    width = browser.run("return document.documentElement.scrollWidth")
    check(width <= 390, f"at 390 px the page is {width} px wide")
    browser.devtools("Emulation.clearDeviceMetricsOverride")


def prints(browser):
    browser.post("/refresh", {})  # plots outside the window are not drawn yet
    until("the report is drawn again", lambda: browser.run("return document.documentElement.dataset.ready === 'true'"), 40)
    drawn = "return document.querySelectorAll('#plots canvas').length"
    check(browser.run(drawn) < 5, "the plots are not lazy")
    paper = browser.paper()
    check(paper.startswith(b"%PDF") and len(paper) > 40_000, "printing gives no document")
    scenes = browser.run("return document.querySelectorAll('#plot-scenario option').length")
    pages = len(re.findall(rb"/Type\s*/Page\b", paper))
    check(pages > scenes, f"{scenes} scenes on {pages} pages")


def main():
    found = programs()
    if not found:
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "report.html")
        print(subprocess.run([sys.argv[1], path], check=True, capture_output=True, text=True).stdout.strip())
        check(os.path.getsize(path) < LIMIT, f"the report has {os.path.getsize(path)} bytes")
        browser = Browser(*found)
        try:
            opens(browser, path)
            links(browser, path)
            print("ok: links")
            for use in (exports, motion):
                use(browser)
                print("ok:", use.__name__)
            opens(browser, path)
            for use in (accessible, sorts, filters, side_by_side, contacts, bounces, settings, plots, dark, narrow, prints):
                use(browser)
                print("ok:", use.__name__)
            silence(browser, path)
            print("ok: no console error, no request")
        except AssertionError as error:
            print("FAILED:", error)
            return 1
        finally:
            browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
