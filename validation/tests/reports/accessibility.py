"""Whether a page can be read and used without a mouse and by a screen reader: Chromium's own tree, and the contrast of text."""
from chromium import check


def accessible(browser, landmarks=("banner", "navigation", "main")):
    """Chromium's own tree: landmarks, one of each, the order of headings, a name for everything that can be used, reached by Tab."""
    browser.devtools("Accessibility.enable")
    nodes = [n for n in browser.devtools("Accessibility.getFullAXTree")["nodes"] if not n.get("ignored")]
    role = lambda n: n.get("role", {}).get("value", "")
    name = lambda n: str(n.get("name", {}).get("value", "")).strip()
    roles = [role(n) for n in nodes]
    for landmark in landmarks:
        check(roles.count(landmark) == 1, f"{roles.count(landmark)} landmarks of the kind {landmark}")
    levels = [(next(p["value"]["value"] for p in n["properties"] if p["name"] == "level"), name(n)) for n in nodes if role(n) == "heading"]
    check(levels[0][0] == 1 and sum(level == 1 for level, _ in levels) == 1, f"the first heading: {levels[0]}")
    jumps = [(a, b) for a, b in zip(levels, levels[1:]) if b[0] > a[0] + 1]
    check(not jumps, f"headings that skip a level: {jumps}")
    nameless = [role(n) for n in nodes if role(n) in ("button", "combobox", "link", "slider", "searchbox", "textbox", "image", "img", "table", "region", "dialog", "DisclosureTriangle") and not name(n)]
    check(not nameless, f"without a name: {nameless}")
    unreached = browser.run("return [...document.querySelectorAll('#app [onclick], #app a, #app button, #app select, #app input, #app summary, #app .plot')].filter(e => e.tabIndex < 0 && !e.closest('.matrix') && !e.closest('[hidden]')).map(e => e.outerHTML.slice(0, 80))")
    check(not unreached, f"not reached by Tab: {unreached}")


def luminance(parts):
    return sum(w * (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4) for w, p in zip((0.2126, 0.7152, 0.0722), (p / 255 for p in parts)))


def contrast(browser, least=9):
    """Of every text with what stands behind it, mixed colours among them; at least `least` pairs of colours are found."""
    script = """const ink = document.createElement('canvas').getContext('2d', {willReadFrequently: true}), known = new Map();
        const rgb = colour => { if (!known.has(colour)) { ink.clearRect(0, 0, 1, 1); ink.fillStyle = colour; ink.fillRect(0, 0, 1, 1); known.set(colour, [...ink.getImageData(0, 0, 1, 1).data]); } return known.get(colour); };
        const seen = new Map(), walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
        for (let node = walk.nextNode(); node; node = walk.nextNode()) {
          const e = node.parentElement; if (!node.data.trim() || !e.checkVisibility() || e.closest('script, style, svg, :disabled')) continue;
          let b = e, back; do { back = rgb(getComputedStyle(b).backgroundColor); b = b.parentElement; } while (b && back[3] === 0);
          const pair = [rgb(getComputedStyle(e).color), back]; seen.set(pair.join(' '), [...pair, node.data.trim().slice(0, 30), e.className]); }
        return [...seen.values()];"""
    found = browser.run(script)
    check(len(found) >= least, f"only {len(found)} colours of text were found")
    for ink, back, words, kind in found:
        light, dark = sorted((luminance(ink[:3]), luminance(back[:3])), reverse=True)
        check((light + 0.05) / (dark + 0.05) >= 4.5, f"contrast {(light + 0.05) / (dark + 0.05):.2f} of {words!r} ({kind}): {ink} on {back}")
