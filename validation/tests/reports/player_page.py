"""What the tests of the playback page share: opening it, its clock, its camera, what it draws; and a browser with WebGL
(SwiftShader) and one without."""
import os
import pathlib
import subprocess
import sys
import tempfile

from chromium import SKIPPED, Browser, check, programs, until

LIMIT = 1_500_000
WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
NO_WEBGL = ("--disable-gpu", "--disable-3d-apis")


def opens(browser, path, fragment=""):
    browser.post("/url", {"url": "about:blank"})  # so that another fragment loads the page again
    browser.post("/url", {"url": pathlib.Path(path).as_uri() + fragment})
    until("the player is ready", lambda: browser.run("return document.documentElement.dataset.ready === 'true'"), 60)


def still(browser):
    """Stops the clock at 0."""
    browser.run("""const p = document.querySelector('#play'); if (p.textContent === 'pause') p.click();
        const s = document.querySelector('#time'); s.value = 0; s.dispatchEvent(new Event('input'));""")
    frames(browser)


def frames(browser):
    browser.post("/execute/async", {"script": "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30)))", "args": []})


def scrub(browser, t, end):
    browser.run("const s = document.querySelector('#time'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));", 1000 * t / end)
    frames(browser)


def clock(browser):
    return float(browser.run("return document.querySelector('#clock').textContent").split()[2])


def camera(browser):
    return [float(x) for x in browser.run("return document.querySelector('.stage').dataset.camera").split()]


def pose(browser, run, t, body=1):
    return browser.run("return atwood.pose(arguments[0], arguments[1], arguments[2])", run, body, t)


def colours(browser, layer):
    """How many colours a layer of the stage has: 0 the solids, 1 the lines."""
    return browser.run("""const source = document.querySelectorAll('.stage canvas')[arguments[0]];
        const copy = document.createElement('canvas'); copy.width = source.width; copy.height = source.height;
        const ink = copy.getContext('2d'); ink.drawImage(source, 0, 0);
        const d = ink.getImageData(0, 0, copy.width, copy.height).data, seen = new Set();
        for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 60) seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);
        return seen.size;""", layer)


def pixels(browser, layer):
    """A number that stands for the pixels of a layer of the stage."""
    return browser.run("""const source = document.querySelectorAll('.stage canvas')[arguments[0]], copy = document.createElement('canvas');
        copy.width = source.width; copy.height = source.height; const ink = copy.getContext('2d'); ink.drawImage(source, 0, 0);
        let sum = 0; for (const x of new Uint32Array(ink.getImageData(0, 0, copy.width, copy.height).data.buffer)) sum = (Math.imul(sum, 31) + x) | 0;
        return sum;""", layer)


def in_both(use):
    """use(browser, folder, kind) with the pages of write_synthetic_playback, drawn in both ways; the exit code."""
    found = programs()
    if not found:
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        print(subprocess.run([sys.argv[1], folder], check=True, capture_output=True, text=True).stdout.strip())
        for name in os.listdir(folder):
            check(os.path.getsize(os.path.join(folder, name)) < LIMIT, f"{name} is too large")
        for kind, flags in (("webgl", WEBGL), ("canvas", NO_WEBGL)):
            browser = Browser(*found, flags)
            try:
                use(browser, folder, kind)
            except AssertionError as error:
                print("FAILED:", error)
                return 1
            finally:
                browser.close()
    return 0
