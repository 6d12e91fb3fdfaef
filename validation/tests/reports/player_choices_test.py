#!/usr/bin/env python3
"""What a reader can choose on a playback page, in headless Chromium: a switch for each kind of mark, the keys of the camera,
all of it in the address and back, hostile addresses, contrast and a screen reader's tree.
player_choices_test.py WRITE_SYNTHETIC_PLAYBACK
Answers 77 (skipped) with a word where Chromium or chromedriver is missing."""
import math
import os
import sys
import time

from accessibility import accessible, contrast
from chromium import check, until
from player_page import camera, clock, frames, in_both, opens, pixels, scrub

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


def use(browser, folder, kind):
    # The address and the page around the scene are the same for both ways of drawing.
    for test in (switches, all_chosen, keys) + ((restores, hostile, reads) if kind == "canvas" else ()):
        test(browser, os.path.join(folder, "forces.html"))
        print(f"ok: {test.__name__} ({kind})", flush=True)
    errors = [entry["message"] for entry in browser.log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    check(not errors, f"the console says: {errors}")


if __name__ == "__main__":
    sys.exit(in_both(use))
