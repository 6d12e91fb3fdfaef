#!/usr/bin/env python3
"""Opens playback pages of known motion in headless Chromium, with WebGL (SwiftShader) and without: poses against formulas,
play, step, scrub, orbit, pan, zoom, follow, magnify, let go, links. No error may reach the console, no request the
network. player_test.py WRITE_SYNTHETIC_PLAYBACK
Answers 77 (skipped) with a word where Chromium or chromedriver is missing."""
import math
import os
import sys
import time

from chromium import DOWN, HOSTILE, UP, check, move, silence, until
from player_page import camera, clock, colours, frames, in_both, opens, pixels, pose, scrub, still


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


def use(browser, folder, kind):
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
    print(f"ok: lets_go, links, no console error, no request ({kind})")


if __name__ == "__main__":
    sys.exit(in_both(use))
