#!/usr/bin/env python3
"""Opens playback pages of known motion in headless Chromium, with WebGL (SwiftShader) and without: poses against formulas,
play, step, scrub, orbit, pan, zoom, follow, magnify, let go, switches, keys, links, contrast and a screen reader's tree. No error may reach the console, no request the
network. player_test.py WRITE_SYNTHETIC_PLAYBACK
Answers 77 (skipped) with a word where Chromium or chromedriver is missing."""
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from accessibility import accessible, contrast
from chromium import DOWN, HOSTILE, SKIPPED, UP, Browser, check, move, programs, silence, until

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


def is_text(browser):
    check(browser.run("return document.querySelector('h1').textContent") == HOSTILE, "the title is not the scene's")
    check(browser.run("return document.querySelectorAll('img, iframe, [onerror]').length") == 0, "hostile text became an element")
    words = browser.run("return document.querySelector('aside').textContent")
    check(words.count(HOSTILE) >= 3, f"claim, source and reason are not shown as text: {words}")
    check("diverged" in words, "how a run ended is not said")


def poses(browser):
    """Against the formulas of write_synthetic_playback.cpp. 16 bits of a range of 2 m are 3e-5 m; a cubic over frames of
    1/60 s at 2 rad/s is better than that."""
    for t in (0, 0.1, 1.2345, 2.71, 2.999):
        found = pose(browser, 0, t)
        exact = [math.cos(2 * t), math.sin(2 * t), 1]
        check(math.dist(found["p"], exact) < 6e-5, f"the truth at {t} s stands at {found['p']}, not at {exact}")
        q = [math.cos(1.5 * t), 0, 0, math.sin(1.5 * t)]
        check(abs(abs(sum(a * b for a, b in zip(found["q"], q))) - 1) < 1e-7, f"the truth's attitude at {t} s is {found['q']}, not {q}")
        near = pose(browser, 1, t)
        # The difference is of 16 bits of its own: 3e-9 m over 65536.
        check(abs(near["p"][2] - found["p"][2] - 1e-9 * t) < 1e-13, f"m/near at {t} s is off by {near['p'][2] - found['p'][2]}")
    for t in (3.2, 3.9):  # beyond the truth's end methods stand alone
        check(math.dist(pose(browser, 1, t)["p"], [math.cos(2 * t), math.sin(2 * t), 1]) < 6e-5, f"m/near at {t} s, beyond the truth")
    check(math.dist(pose(browser, 2, 4)["p"], [math.cos(4), math.sin(4), 1.2]) < 1e-4, "a run that ended does not stay at its last pose")


def magnifies(browser):
    scrub(browser, 2, 4)
    browser.run("const s = document.querySelector('#magnify'); s.value = '10000000'; s.dispatchEvent(new Event('change'));")
    frames(browser)
    base, near = pose(browser, 0, 2), pose(browser, 1, 2)
    check(abs(near["p"][2] - base["p"][2] - 0.02) < 1e-5, f"1e7 times 2e-9 m is drawn as {near['p'][2] - base['p'][2]} m")
    # q_truth^-1 q is a turn about the body's x by 1e7 * 2e-7 rad.
    (a, b, c, d), (w, x, y, z) = base["q"], near["q"]
    turn = [a * w + b * x + c * y + d * z, a * x - b * w - c * z + d * y, a * y + b * z - c * w - d * x, a * z - b * y + c * x - d * w]
    check(math.dist([abs(turn[0]), abs(turn[1]), turn[2], turn[3]], [math.cos(1), math.sin(1), 0, 0]) < 1e-3, f"2 rad are drawn as {turn}")
    note = browser.run("return document.querySelector('#note').textContent")
    check("1e7 times as far from the truth" in note, f"the page does not say that it magnifies: {note!r}")
    browser.run("const s = document.querySelector('#magnify'); s.value = 'auto'; s.dispatchEvent(new Event('change'));")
    check(browser.run("return document.querySelector('#magnify').value") == "1", "0.2 m and more need no magnification")
    browser.click("#run-2")  # without m/ends the largest are 3e-9 m and 3e-7 rad
    browser.run("const s = document.querySelector('#magnify'); s.value = 'auto'; s.dispatchEvent(new Event('change'));")
    check(browser.run("return document.querySelector('#magnify').value") == "1000000", "the fitting magnification is not 1e6")
    browser.run("const s = document.querySelector('#magnify'); s.value = '1'; s.dispatchEvent(new Event('change'));")
    browser.click("#run-2")


def plays(browser):
    still(browser)
    check(clock(browser) == 0 and browser.run("return document.querySelector('#play').textContent") == "play", "the clock does not stand at 0")
    before = colours(browser, 1)
    browser.click("#play")
    until("time goes on", lambda: clock(browser) > 0.3)
    browser.click("#play")
    stopped = clock(browser)
    frames(browser)
    check(clock(browser) == stopped, "pause does not pause")
    check(colours(browser, 0) > 8 and colours(browser, 1) > 3 and before > 1, "nothing is drawn")
    still(browser)
    browser.click("#forward")
    frames(browser)
    check("frame 1 of 240, step 4 of 960" in browser.run("return document.querySelector('#frame').textContent"), "one frame forward")
    browser.click("#back")
    frames(browser)
    check(clock(browser) == 0, "one frame back")


def scrubs(browser):
    box = browser.run("const c = document.querySelector('#curve-position canvas'); c.scrollIntoView({block: 'center'}); const r = c.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]")
    x = box[0] + 52 + (box[2] - 64) * 0.5
    browser.mouse(move(x, box[1] + 60), DOWN, UP)
    frames(browser)
    check(abs(clock(browser) - 2) < 0.03, f"a press in the middle of the plot sets {clock(browser)} s")
    check(abs(float(browser.run("return document.querySelector('#curve-energy canvas').dataset.cursor")) - float(browser.run("return document.querySelector('#curve-position canvas').dataset.cursor"))) < 1, "the plots have different cursors")
    values = browser.run("return [...document.querySelectorAll('.run .value')].map(v => v.textContent)")
    check(values[1].startswith("2 nm") and "2e-7 rad" in values[1] and values[2].startswith("20 cm"), f"the errors at 2 s read {values}")
    scrub(browser, 3.5, 4)
    check(browser.run("return [...document.querySelectorAll('.run .value')].map(v => v.textContent)")[2] == "ended", "a run that ended is not said to have ended")


def saves(browser):
    """The saved PNG shows what the stage shows, above its captions."""
    scrub(browser, 2, 4)
    browser.run("""window.saved = null; URL.createObjectURL = blob => { window.saved = blob; return 'blob:null/0'; };
        HTMLAnchorElement.prototype.click = function () { window.savedName = this.download; };""")
    browser.click("#save")
    until("a picture is saved", lambda: browser.run("return window.saved !== null && window.savedName !== undefined"))
    check(browser.run("return saved.type + ' ' + savedName").startswith("image/png "), "the picture is no PNG")
    wide, high, stage_high, far, inked = browser.run("""const image = await createImageBitmap(saved), layers = [...document.querySelectorAll('.stage canvas')], [w, h] = [layers[0].width, layers[0].height];
        const read = draw => { const c = document.createElement('canvas'); c.width = image.width; c.height = image.height; const ink = c.getContext('2d'); draw(ink); return ink.getImageData(0, 0, image.width, image.height).data; };
        const found = read(ink => ink.drawImage(image, 0, 0)), back = getComputedStyle(document.querySelector('.stage')).backgroundColor;
        const shown = read(ink => { ink.fillStyle = back; ink.fillRect(0, 0, w, h); layers.forEach(l => ink.drawImage(l, 0, 0, w, h)); });
        let far = 0, inked = 0; for (let i = 0; i < 4 * w * h; i += 1) far += Math.abs(found[i] - shown[i]) > 3;
        for (let i = 4 * w * h; i < found.length; i += 4) inked += Math.abs(found[i] - found[found.length - 4]) > 60;
        return [image.width - w, image.height, h, far, inked];""")
    check(wide == 0 and high > stage_high and far == 0, f"the picture differs from the stage in {far} values")
    check(inked > 200, f"the captions have {inked} dark pixels")
    saves_lines(browser)


# Draws the saved SVG at the size of the stage (or of a plot) and counts pixels that differ from `shown` by more than a quarter.
DIFFERENCE = """const text = await saved.text(), parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
    const image = new Image(); await new Promise((good, bad) => { image.onload = good; image.onerror = bad; image.src = 'data:image/svg+xml,' + encodeURIComponent(text); });
    const shown = arguments[0].map(s => document.querySelector(s)).filter(Boolean), box = shown[0].getBoundingClientRect(), w = Math.round(box.width), h = Math.round(box.height);
    const read = draw => { const c = document.createElement('canvas'); c.width = w; c.height = h; const ink = c.getContext('2d'); draw(ink); return ink.getImageData(0, 0, w, h).data; };
    const panel = getComputedStyle(document.documentElement).getPropertyValue('--panel').trim();
    const a = read(ink => ink.drawImage(image, 0, 0)), b = read(ink => { ink.fillStyle = panel; ink.fillRect(0, 0, w, h); shown.forEach(l => ink.drawImage(l, 0, 0, w, h)); });
    let far = 0, drawn = 0; for (let i = 0; i < a.length; i += 4) {
      const apart = (x, y, j) => Math.max(Math.abs(x[i] - y[j]), Math.abs(x[i + 1] - y[j + 1]), Math.abs(x[i + 2] - y[j + 2])) > 64;
      far += apart(a, b, i); drawn += apart(b, b, 0); }
    return [parsed.querySelector('parsererror') ? 'not XML' : parsed.documentElement.nodeName, parsed.querySelectorAll('script, [onload], [onclick]').length,
      parsed.querySelectorAll('path').length, [...parsed.querySelectorAll('text')].map(t => t.textContent), far, drawn, savedName];"""


def saves_lines(browser):
    """The view and the plots saved as SVG are XML and look like the page; a plot saves as PNG too."""
    browser.run("window.saved = null;")
    browser.click("#save-svg")
    until("an SVG is saved", lambda: browser.run("return window.saved !== null"))
    layers = [".stage canvas:nth-of-type(1)", ".stage canvas:nth-of-type(2)"]
    kind, active, paths, texts, far, drawn, name = browser.run(DIFFERENCE, layers)
    check(kind == "svg" and active == 0 and name.endswith(".svg"), f"the view saved as SVG is {kind} with {active} active parts, {name}")
    check(any(HOSTILE in text for text in texts), f"the title is not among the texts {texts}")
    lit = browser.run("return document.querySelector('.stage canvas').getContext('2d') === null")  # WebGL shades more finely
    check(paths > 40 and drawn > 1000 and far < (0.4 if lit else 0.1) * drawn, f"the view's SVG, {paths} paths, differs in {far} pixels of {drawn} that are drawn")
    browser.run("window.saved = null;")
    browser.run("document.querySelector('#curve-position .save-curve[aria-label^=\"Save as SVG\"]').click()")
    until("a plot is saved", lambda: browser.run("return window.saved !== null"))
    kind, active, paths, texts, far, drawn, name = browser.run(DIFFERENCE, ["#curve-position canvas"])
    check(kind == "svg" and active == 0 and drawn > 200 and far < 0.35 * drawn, f"the plot's SVG is {kind}, differs in {far} pixels of {drawn} that are drawn")
    check(any("s" == text.strip()[-1:] for text in texts) and name.endswith(".svg"), f"the plot's SVG has the texts {texts}, {name}")
    browser.run("window.saved = null; document.querySelector('#curve-energy .save-curve[aria-label^=\"Save as PNG\"]').click()")
    until("a plot is saved as PNG", lambda: browser.run("return window.saved !== null"))
    check(browser.run("return saved.type === 'image/png' && saved.size > 500 && savedName.endsWith('.png')"), "the plot's PNG is none")


def moves_camera(browser):
    browser.run("document.querySelector('.stage').scrollIntoView({block: 'center'})")
    left, top, width, height = browser.run("const r = document.querySelector('.stage').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]")
    x, y = left + width / 2, top + height / 2
    start = camera(browser)
    browser.mouse(move(x, y), DOWN, move(x + 60, y + 20), UP)
    frames(browser)
    turned = camera(browser)
    check(abs(turned[0] - start[0] + 0.48) < 0.02 and abs(turned[1] - start[1] - 0.16) < 0.02 and turned[2:] == start[2:], f"a drag turns {start} to {turned}")
    browser.run("""document.querySelector('.stage').dispatchEvent(new WheelEvent('wheel', {deltaY: -100, clientX: arguments[0], clientY: arguments[1], cancelable: true}))""", x, y)
    frames(browser)
    check(abs(camera(browser)[2] / start[2] - math.exp(-0.15)) < 1e-3, "the wheel does not zoom")
    zoomed = camera(browser)
    browser.run("""const e = document.querySelector('.stage'), o = {pointerId: 1, buttons: 4, clientX: 300, clientY: 300};
        e.setPointerCapture = () => {}; e.dispatchEvent(new PointerEvent('pointerdown', o));
        e.dispatchEvent(new PointerEvent('pointermove', {...o, clientX: 380})); e.dispatchEvent(new PointerEvent('pointerup', o));""")
    frames(browser)
    check(camera(browser)[:3] == zoomed[:3] and camera(browser)[3:] != zoomed[3:], "the middle button does not pan")
    browser.run("document.querySelector('#fit').scrollIntoView()")
    browser.click("#fit")
    scrub(browser, 1, 4)
    browser.run("const s = document.querySelector('#follow'); s.value = '1'; s.dispatchEvent(new Event('change'));")
    frames(browser)
    scrub(browser, 2, 4)
    check(math.dist(camera(browser)[3:], [math.cos(4), math.sin(4), 1]) < 1e-3, f"the camera does not follow the body: {camera(browser)}")
    browser.run("const s = document.querySelector('#follow'); s.value = '-1'; s.dispatchEvent(new Event('change'));")
    browser.click("#fit")
    frames(browser)


def links(browser, path):
    scrub(browser, 1.5, 4)
    browser.click("#run-2")
    before = camera(browser)
    until("the address keeps the view", lambda: "hide=2" in browser.run("return location.hash"))
    fragment = browser.run("return location.hash")
    opens(browser, path, fragment)
    frames(browser)
    check(abs(clock(browser) - 1.5) < 1e-3, f"the link opens at {clock(browser)} s")
    check(math.dist(camera(browser), before) < 1e-4, f"the link opens with the camera {camera(browser)}, not {before}")
    check(not browser.run("return document.querySelector('#run-2').checked"), "the link shows a run that was hidden")
    for bad in ("#t=nan&k=-3&hide=99.x&view=1_2", "#t=1e999&k=1e999&view=0_0_-1_0_0_0", "#%ff"):
        opens(browser, path, bad)
        frames(browser)
        check(all(math.isfinite(x) for x in camera(browser)), f"{bad} breaks the camera")


SWITCHES = ["trails", "contacts", "normals", "impulses", "friction", "thrusters", "point-forces", "other-forces", "joints", "names", "axes", "grid"]
STATE = """const value = s => document.querySelector(s)?.value, on = s => document.querySelector(s)?.checked;
    return {speed: value('#speed'), follow: value('#follow'), field: value('#field'), particles: value('#particles-of'), k: value('#magnify'),
      loop: on('#loop'), wait: on('#wait'), held: !document.querySelector('#let-go').hidden, theme: document.documentElement.dataset.theme ?? '',
      runs: [...document.querySelectorAll('.run input')].map(b => b.checked), switches: arguments[0].filter(name => on('#show-' + name))};"""


def state(browser):
    return browser.run(STATE, SWITCHES)


def choose(browser, selector, value):
    browser.run("const s = document.querySelector(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('change'));", selector, value)
    frames(browser)


def kept(browser):
    """The address, once it has not changed for longer than the page waits before it writes it."""
    last = None
    while last != (last := browser.run("return location.hash")):
        time.sleep(0.4)
    return last


def pixels(browser, layer):
    """A number that stands for the pixels of a layer of the stage."""
    return browser.run("""const source = document.querySelectorAll('.stage canvas')[arguments[0]], copy = document.createElement('canvas');
        copy.width = source.width; copy.height = source.height; const ink = copy.getContext('2d'); ink.drawImage(source, 0, 0);
        let sum = 0; for (const x of new Uint32Array(ink.getImageData(0, 0, copy.width, copy.height).data.buffer)) sum = (Math.imul(sum, 31) + x) | 0;
        return sum;""", layer)


def drawn(browser):
    """How many paths and texts the view has, from its SVG without the lines below it."""
    browser.run("window.saved = null; URL.createObjectURL = blob => { window.saved = blob; return 'blob:null/0'; }; HTMLAnchorElement.prototype.click = () => {}; document.querySelector('#save-svg').click();")
    until("an SVG is saved", lambda: browser.run("return window.saved !== null"))
    return browser.run("const text = await saved.text(); return [text.split('<path').length - 1, text.split('<text').length - 1];")


def switches(browser, path):
    """Each switch takes away its own lines and no others. An arrow is two paths, a ring, a disc and a spring are one, a word is two texts."""
    opens(browser, path, "#t=1&hide=1&on=grid.names")
    frames(browser)
    check(state(browser)["switches"] == SWITCHES, f"the page of forces has the switches {state(browser)['switches']}")
    label = browser.run("return document.querySelector('label[for=show-other-forces]').textContent")
    check(label == "drives, springs, attractors", f"the switch of other forces is called {label!r}")
    counts = {"contacts": [2, 2], "normals": [2, 0], "impulses": [3, 0], "friction": [2, 0], "thrusters": [2, 0], "point-forces": [2, 0],
              "other-forces": [4, 0], "trails": [2, 0]}
    for name in SWITCHES:
        before, shown = drawn(browser), pixels(browser, 0 if name == "grid" else 1)
        browser.click(f"#show-{name}")
        frames(browser)
        after = drawn(browser)
        gone = [a - b for a, b in zip(before, after)]
        check(pixels(browser, 0 if name == "grid" else 1) != shown, f"{name}: nothing changes on the screen")
        check(gone == counts[name] if name in counts else sum(gone) > 0, f"{name}: {gone} paths and texts go, not {counts.get(name)}")
        browser.click(f"#show-{name}")
        frames(browser)
        check(drawn(browser) == before, f"{name}: it does not come back")
    scrub(browser, 1.75, 2)  # the thruster is off, and the impact is over
    before = drawn(browser)
    browser.click("#show-thrusters")
    browser.click("#show-impulses")
    frames(browser)
    check(drawn(browser) == before, "a thruster that is off, or an impact that is over, is drawn")
    opens(browser, path.replace("forces.html", "smooth.html"))
    check(set(state(browser)["switches"]) == {"trails", "axes"} and not browser.run("return document.querySelector('#show-thrusters, #show-friction, #show-grid')"), "a page without forces has switches for them")


def restores(browser, path):
    """Each choice is in the address, alone and with all others, and comes back from it."""
    opens(browser, path, "#t=1")
    plain, solids = state(browser), pixels(browser, 0)
    usual = plain["switches"]
    check(plain["loop"] and not plain["wait"] and plain["follow"] == "-1" and plain["runs"] == [True, True], f"the page opens with {plain}")
    single = [("speed=3", "speed", "3"), ("speed=whole", "speed", "whole"), ("loop=0", "loop", False), ("wait=1", "wait", True), ("follow=1", "follow", "1"),
              ("field=2", "field", "2"), ("particles=1", "particles", "1"), ("k=100", "k", "100"), ("hide=0", "runs", [False, True]), ("theme=dark", "theme", "dark"), ("theme=light", "theme", "light")]
    single += [(f"off={name}", "switches", [s for s in usual if s != name]) for name in usual]
    single += [(f"on={name}", "switches", [s for s in SWITCHES if s in usual or s == name]) for name in ("names", "grid")]
    for words, key, value in single:
        opens(browser, path, "#t=1&" + words)
        frames(browser)
        found = state(browser)
        check(found[key] == value, f"{words}: {key} is {found[key]}")
        check({**found, key: 0} == {**plain, key: 0}, f"{words} changes more than {key}: {found}")
        if key in ("field", "particles"):
            check(pixels(browser, 0) != solids, f"{words}: the picture is the same")
        until("the page writes its address", lambda: "view=" in browser.run("return location.hash"))
        check(words in browser.run("return location.hash"), f"{words} does not stay in the address")
    opens(browser, path, "#t=1.9&loop=0&speed=10")
    browser.click("#play")
    until("it stops at the end", lambda: clock(browser) == 2 and browser.run("return document.querySelector('#play').textContent") == "play")
    check("t=2&" in kept(browser), f"the end is not in the address: {kept(browser)}")


def all_chosen(browser, path):
    """By hand, through the controls; held until let go; the camera beside the body that it follows."""
    opens(browser, path, "#t=0.5")
    for selector, value in (("#speed", "0.1"), ("#follow", "1"), ("#field", "2"), ("#particles-of", "1"), ("#magnify", "10")):
        choose(browser, selector, value)
    for name in ("trails", "friction", "thrusters", "names", "grid"):
        browser.click(f"#show-{name}")
    for selector in ("#loop", "#run-0", "#theme", "#wait"):
        browser.click(selector)
    until("it waits", lambda: state(browser)["held"])
    browser.type(".stage", "dd+")
    frames(browser)
    before, seen = state(browser), camera(browser)
    opens(browser, path, kept(browser))
    frames(browser)
    check(state(browser) == before and before["held"] and clock(browser) == 0, f"the link opens with {state(browser)}, not {before}")
    check(math.dist(camera(browser), seen) < 1e-4, f"the link opens with the camera {camera(browser)}, not {seen}")
    check(abs(camera(browser)[3]) + abs(camera(browser)[4]) > 0.02, "the camera is not beside the body")
    browser.click("#let-go")
    until("it goes on", lambda: clock(browser) > 0.02)
    check(abs(camera(browser)[3] - seen[3] - 0.2 * clock(browser)) < 0.02, "the camera does not go with the body")


def hostile(browser, path):
    """Values without a meaning leave the page as it is without them."""
    opens(browser, path, "#t=1")
    frames(browser)
    plain, seen = state(browser), camera(browser)
    for bad in ("k=NaN&hide=__proto__&speed=constructor&follow=99&field=-1&particles=toString&loop=2&wait=yes&on=constructor.__proto__&off=toString&theme=evil&view=1_2",
                "k=Infinity&hide=1.x&speed=1e999&view=1e400_0_1_0_0_0", "k=1e300&hide=&speed=0&view=0_0_1e-300_0_0_0", "k=0&hide=-1&follow=1.5&view=0_0_1_1e300_0_0",
                "k=-3&hide=99.x&field=NaN&view=_____", "k=&speed=-1&particles=Infinity&view=NaN_0_1_0_0_0", "view=0_0_-1_0_0_0&loop=&wait=", "view=1e300_0_1_0_0_0&wait=0&loop=true",
                "view=0_0_1e300_0_0_0", "view=0_0_1_0_0_Infinity&on=%3Cimg%3E&theme=%22%3E", "wait=held%00&on=loop.wait&off=loop.wait", "%ff=%ff"):
        opens(browser, path, "#t=1&" + bad)
        frames(browser)
        check(state(browser) == plain and clock(browser) == 1, f"{bad} makes of {plain} {state(browser)}")
        check(math.dist(camera(browser), seen) < 1e-6, f"{bad} moves the camera from {seen} to {camera(browser)}")
    for bad in ("t=nan", "t=-1", "t=1e999", "t=", "t=Infinity"):
        opens(browser, path, "#" + bad)
        until(f"{bad} lets the clock run", lambda: 0 < clock(browser) < 2)
    opens(browser, path, "#t=1e300&view=0_9_3_0_0_0")
    frames(browser)
    check(clock(browser) == 2 and abs(camera(browser)[1] - 1.55) < 1e-5, "a time beyond the end, or a pitch beyond the pole, is not cut")
    opens(browser, path, "#t=0.7&wait=held")
    check(not state(browser)["held"] and state(browser)["wait"], "it is held where nothing is released")
    browser.run("location.hash = '#t=1.5&speed=3'")
    until("another link in the same page is followed", lambda: browser.run("return document.querySelector('#speed')?.value === '3' && document.documentElement.dataset.ready === 'true'"))


SHIFT, LEFT, UPWARD, RIGHT, DOWNWARD = "\ue008", "\ue012", "\ue013", "\ue014", "\ue015"


def keys(browser, path):
    opens(browser, path, "#t=1")
    frames(browser)

    def press(text):
        before = camera(browser)
        browser.type(".stage", text)
        frames(browser)
        return [b - a for a, b in zip(before, camera(browser))]

    for text, turn in ((SHIFT + RIGHT, [-0.12, 0]), (SHIFT + LEFT, [0.12, 0]), (SHIFT + DOWNWARD, [0, 0.12]), (SHIFT + UPWARD, [0, -0.12])):
        change = press(text)
        check(math.dist(change, turn + [0, 0, 0, 0]) < 1e-4 and clock(browser) == 1, f"Shift and an arrow turn by {change[:2]} at {clock(browser)} s, not by {turn}")
    up, down, left, right = (press(text) for text in "wsad")
    check(up[5] > 0.01 and math.dist(up, [-x for x in down]) < 1e-4, f"w and s move by {up} and {down}")
    check(right[3] > 0.01 and abs(right[5]) < 1e-6 and math.dist(left, [-x for x in right]) < 1e-4, f"a and d move by {left} and {right}")
    check(up[:3] == right[:3] == [0, 0, 0], "keys that move the camera turn it")
    start = camera(browser)
    check(abs((start[2] + press("+")[2]) / start[2] - math.exp(-0.15)) < 1e-4, "+ does not zoom in")
    press("-")
    check(math.dist(camera(browser), start) < 1e-4, f"- is not the opposite of +: {camera(browser)}, {start}")
    press("+++dW")
    press("f")
    check(math.dist(camera(browser), start) < 1e-3, f"f does not fit: {camera(browser)}, {start}")
    check(press(RIGHT) == [0] * 6 and abs(clock(browser) - 1 - 1 / 120) < 1e-3, f"in the scene an arrow steps to {clock(browser)} s")
    browser.run("document.activeElement.blur()")
    for text, t in ((RIGHT, 1 + 2 / 120), (SHIFT + RIGHT, 1 + 12 / 120), ("w", 1 + 12 / 120), (SHIFT + LEFT, 1 + 2 / 120)):
        before = camera(browser)
        browser.type("body", text)
        frames(browser)
        check(camera(browser) == before and abs(clock(browser) - t) < 1e-3, f"outside the scene a key leads to {clock(browser)} s, not {t} s, and the camera {camera(browser)}")
    label, words = browser.run("return [document.querySelector('.stage').getAttribute('aria-label'), document.querySelector('#keys').textContent]")
    for word in ("Shift and arrows turn", "W A S D move", "zoom", "F fits"):
        check(word in label and word in words, f"the keys are not told: {word!r} in {label!r}, {words!r}")


def reads(browser, path):
    """What a screen reader is told, and the contrast of every text, in both themes, with all that can be opened open."""
    for theme in ("light", "dark"):
        for page in ("forces.html", "smooth.html", "bounces.html"):
            opens(browser, path.replace("forces.html", page), f"#t=1&k=100&on=names.grid&theme={theme}")
            browser.run("document.querySelector('details').open = true")
            frames(browser)
            dark = browser.run("return getComputedStyle(document.body).backgroundColor") == "rgb(18, 21, 24)"
            check(dark == (theme == "dark"), f"the theme {theme} is not shown")
            accessible(browser, ("banner", "main", "complementary"))
            contrast(browser, 4)
        opens(browser, path.replace("forces.html", "bounces.html"), f"#t=0.5&wait=held&theme={theme}")
        contrast(browser, 4)


def narrow(browser):
    browser.devtools("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=2, mobile=True)
    frames(browser)
    wide = browser.run("return document.documentElement.scrollWidth")
    check(wide <= 390, f"the page is {wide} px wide on a screen of 390")
    browser.devtools("Emulation.clearDeviceMetricsOverride")


def lets_go(browser):
    still(browser)
    check(pose(browser, 0, 0.25)["p"][2] == pose(browser, 0, 0.5)["p"][2], "the ball moves before its release")
    # Straight between the frames next to an impact: a cubic over it would be 4 mm off.
    for t, height in ((1 - 1 / 240, 1.1 - 4 * (0.5 - 1 / 240) ** 2), (1 + 1 / 240, 0.1 + 4 / 240 - 4 / 240 ** 2)):
        check(abs(pose(browser, 0, t)["p"][2] - height) < 5e-4, f"beside the impact, at {t} s, the ball stands at {pose(browser, 0, t)['p'][2]} m, not at {height}")
    browser.click("#wait")
    until("it waits", lambda: not browser.run("return document.querySelector('#let-go').hidden"))
    check(abs(clock(browser) - 0.5) < 1e-3, f"it waits at {clock(browser)} s, not at the release")
    time.sleep(0.3)
    check(abs(clock(browser) - 0.5) < 1e-3, "it does not wait")
    browser.click("#let-go")
    until("it goes on", lambda: clock(browser) > 0.6)
    browser.click("#wait")
    browser.click("#loop")
    browser.run("const s = document.querySelector('#speed'); s.value = '10'; s.dispatchEvent(new Event('change'));")
    until("without a loop it stops at the end", lambda: clock(browser) == 2 and browser.run("return document.querySelector('#play').textContent") == "play")
    frames(browser)
    for part in ("contacts", "normals"):
        with_contact = pixels(browser, 1)
        browser.click(f"#show-{part}")
        frames(browser)
        check(pixels(browser, 1) != with_contact, f"the contact at the end is not drawn ({part})")
    note = browser.run("return document.querySelector('#note').textContent")
    check("Magnified" not in note, f"nothing is magnified: {note!r}")


def use(found, folder, flags, kind):
    browser = Browser(*found, flags)
    try:
        path = os.path.join(folder, "smooth.html")
        opens(browser, path)
        check(browser.run("return document.querySelector('.stage').dataset.kind") == kind, f"the scene is not drawn by {kind}")
        for test in (is_text, poses, plays, magnifies, scrubs, saves, moves_camera, narrow):
            test(browser)
            print(f"ok: {test.__name__} ({kind})")
        links(browser, path)
        silence(browser, path)
        opens(browser, os.path.join(folder, "bounces.html"))
        lets_go(browser)
        silence(browser, os.path.join(folder, "bounces.html"))
        path = os.path.join(folder, "forces.html")
        # The address and the page around the scene are the same for both ways of drawing.
        for test in (switches, all_chosen, keys) + ((restores, hostile, reads) if kind == "canvas" else ()):
            test(browser, path)
            print(f"ok: {test.__name__} ({kind})", flush=True)
        errors = [entry["message"] for entry in browser.log("browser") if entry["level"] in ("SEVERE", "WARNING")]
        check(not errors, f"the console says: {errors}")
        print(f"ok: lets_go, links, no console error, no request ({kind})")
    finally:
        browser.close()


def main():
    found = programs()
    if not found:
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        print(subprocess.run([sys.argv[1], folder], check=True, capture_output=True, text=True).stdout.strip())
        for name in os.listdir(folder):
            check(os.path.getsize(os.path.join(folder, name)) < LIMIT, f"{name} is too large")
        try:
            use(found, folder, WEBGL, "webgl")
            use(found, folder, NO_WEBGL, "canvas")
        except AssertionError as error:
            print("FAILED:", error)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
