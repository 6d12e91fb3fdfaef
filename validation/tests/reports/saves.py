"""Whether everything on a page can be saved: every table as CSV, every plot as SVG and as PNG. What is saved is caught, not written."""
import csv
import io
import re
import xml.etree.ElementTree

from chromium import check, until

CATCH = """if (!window.saved) { window.saved = []; URL.createObjectURL = blob => { saved.push({blob}); return 'blob:null/0'; };
    HTMLAnchorElement.prototype.click = function () { saved[saved.length - 1].name = this.download; }; }"""
# Plots (a chart draws its canvas when it is first seen, its place is there before). Drawings that are no plots: samples of a
# line in a legend, and pictures that lead to the scene that they show.
DRAWINGS = """[...document.querySelectorAll('svg, canvas, .plot')].filter(e => !e.parentElement.closest('svg') && !e.closest('button, .gallery, #sheets, [hidden]'))"""
FIGURES = f"[...new Set({DRAWINGS}.map(e => e.closest('figure')).filter(f => f))]"


def uncontrolled(browser):
    """Tables and drawings of the page without their buttons."""
    browser.run("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    tables = browser.run("""return [...document.querySelectorAll('table')].filter(t => { const region = t.closest('.scroll') ?? t, b = region.previousElementSibling;
        return !(b?.matches('.save') && b.querySelectorAll('button').length === 1 && b.textContent === 'CSV'); }).map(t => t.outerHTML.slice(0, 160))""")
    plots = browser.run(f"""return {DRAWINGS}.filter(e => !['SVG', 'PNG'].every(kind => e.closest('figure')?.querySelectorAll(`[data-save=${{kind}}]`).length === 1)).map(e => e.outerHTML.slice(0, 160))""")
    return tables, plots


def press(browser, of, at, selector):
    """Presses a button of the `at`-th of a list of elements and answers the name and the text, or the colours, of what it saves."""
    browser.run(CATCH)
    count = browser.run("return saved.length")
    browser.run(f"({of})[arguments[0]].querySelector(arguments[1]).click()", at, selector)
    until("something is saved", lambda: browser.run("return saved.length") > count)
    name, kind = browser.run("const s = saved[saved.length - 1]; return [s.name, s.blob.type]")
    if kind != "image/png":
        return name, kind, browser.run("return saved[saved.length - 1].blob.text()")
    return name, kind, browser.run("""return createImageBitmap(saved[saved.length - 1].blob).then(image => {
        const c = new OffscreenCanvas(image.width, image.height), ink = c.getContext('2d'); ink.drawImage(image, 0, 0);
        return [image.width, image.height, new Set(new Uint32Array(ink.getImageData(0, 0, c.width, c.height).data.buffer)).size]; })""")


def named(name, ending):
    check(re.fullmatch(r"[a-z0-9][a-z0-9.-]*\." + ending, name), f"a file is called {name!r}")


def tables_save(browser):
    """{name: rows} of every table's CSV, which has the rows and columns that the table shows."""
    found = {}
    buttons = "[...document.querySelectorAll('.save')].filter(s => s.textContent === 'CSV')"
    for at in range(browser.run(f"return {buttons}.length")):
        name, kind, text = press(browser, buttons, at, "button")
        named(name, "csv")
        check(kind == "text/csv", f"{name} is {kind}")
        lines = list(csv.reader(io.StringIO(text)))
        shown = browser.run("const t = (" + buttons + """)[arguments[0]].nextElementSibling; return [t.matches('.rows'), [...t.querySelectorAll('tr')].map(r => r.children.length),
            [...t.querySelectorAll('tr')].map(r => { const c = r.firstElementChild?.cloneNode(true); c?.querySelectorAll('.copy').forEach(b => b.remove()); return c?.textContent ?? ''; })]""", at)
        if not shown[0]:  # which holds the rows in view only
            bare = lambda word: re.sub(r"\W", "", word)
            check([len(line) for line in lines] == shown[1] and [bare(line[0]) for line in lines] == [bare(word) for word in shown[2]],
                  f"{name} has other rows than its table: {lines[:3]} {shown[2][:3]}")
        check(len(lines) > 1 and len(lines[0]) > 1, f"{name} is empty: {lines}")
        found[name] = lines
    return found


def plots_save(browser):
    """{name: SVG} of every plot that is shown; each parses, and so does its PNG, which has the same size twice over and more than two colours."""
    found = {}
    for at in range(browser.run(f"return {FIGURES}.length")):
        name, kind, text = press(browser, FIGURES, at, "[data-save=SVG]")
        named(name, "svg")
        root = xml.etree.ElementTree.fromstring(text)
        size = [float(root.get(side)) for side in ("width", "height")]
        drawn = root.findall(".//{*}path") + root.findall(".//{*}circle") + root.findall(".//{*}polyline") + root.findall(".//{*}polygon")
        check(kind == "image/svg+xml" and root.tag == "{http://www.w3.org/2000/svg}svg" and len(drawn) > 1 and min(size) > 80, f"{name}: {len(drawn)} shapes, size {size}")
        check("var(" not in text and not root.findall(".//*[@class]"), f"{name} needs the style of the page")
        check(len(text) < 300_000, f"{name} has {len(text)} bytes")
        raster, kind, (width, height, colours) = press(browser, FIGURES, at, "[data-save=PNG]")
        named(raster, "png")
        check(kind == "image/png" and raster[:-4] == name[:-4] and [width, height] == [int(2 * side) for side in size] and colours > 2,
              f"{raster}: {width} x {height}, {colours} colours beside {size}")
        found[name] = text
    return found


def everything_saves(browser):
    tables, plots = uncontrolled(browser)
    check(not tables, f"{len(tables)} tables without CSV: {tables}")
    check(not plots, f"{len(plots)} plots without SVG and PNG: {plots}")
    return tables_save(browser), plots_save(browser)
