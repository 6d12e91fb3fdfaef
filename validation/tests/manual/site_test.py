"""The manual as a site: mkdocs builds it without a complaint, it asks for nothing outside its folder, and from a disk a
browser shows it, searches it, and fits it to a telephone."""
import re
import sys
import unittest

from assembled import Assembled, build
import chromium
import pages

SKIPPED = 77
# Scenes of each kind whose truth takes little time: their pictures are drawn, those of the others with `ninja manual`.
DRAWN = {"ballistic", "kepler-e0.6", "bounce-e0.5", "asymmetric-top", "slide-20", "double-pendulum-regular"}
FETCHED = re.compile(r"""<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)=["']?([^"'\s>$]+)""")


class Site(Assembled):
    drawn = DRAWN

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.code = build.site(cls.output)
        cls.site = cls.output / "site"

    def test_it_is_built_without_a_complaint(self):
        self.assertEqual((self.faults, self.code), ([], 0))

    def test_it_asks_for_nothing_outside(self):
        for page in self.site.rglob("*.html"):
            for address in FETCHED.findall(page.read_text(encoding="utf-8")):
                self.assertTrue(pages.is_local(address) or address.startswith("data:"), f"{page.name}: {address}")
                if page.name != "404.html":
                    self.assertTrue((page.parent / re.split("[#?]", address)[0]).exists(), f"{page.name}: {address}")

    def test_headings_have_the_names_that_links_are_checked_by(self):
        for page in self.docs.rglob("*.md"):
            if "files" in page.relative_to(self.docs).parts:
                continue
            shown = (self.site / page.relative_to(self.docs).with_suffix(".html")).read_text(encoding="utf-8")
            ids = set(re.findall(r'<h[1-6] id="([^"]+)"', shown))
            self.assertLessEqual(ids, pages.anchors(page.read_text(encoding="utf-8")), page.name)

    def test_bars_in_tables_are_bars(self):
        shown = (self.site / "commands.html").read_text(encoding="utf-8")
        self.assertIn("<code>atwood list [scenarios|methods|", shown)
        shown = (self.site / "reference/metrics.html").read_text(encoding="utf-8")
        self.assertIn("Largest | |q| - 1 | over the samples", shown)

    def test_from_a_disk_in_a_browser(self):
        programs = chromium.programs()
        if not programs:
            self.skipTest("no browser")
        browser = chromium.Browser(*programs)
        try:
            self.in_browser(browser)
        finally:
            browser.close()

    def in_browser(self, browser):
        browser.post("/url", {"url": (self.site / "concepts.html").as_uri()})
        sizes = browser.run("return [...document.querySelectorAll('article img')].map(i => i.naturalWidth)")
        self.assertEqual(len(sizes), 7)
        self.assertTrue(all(sizes), sizes)
        browser.post("/url", {"url": (self.site / "reference/scenarios.html").as_uri()})
        browser.run("document.querySelectorAll('article img').forEach((i) => { i.loading = 'eager'; })")
        shown = chromium.until("the gallery's pictures are loaded", lambda: browser.run(
            "const all = [...document.querySelectorAll('figure img')];"
            "return all.length && all.every((i) => i.naturalWidth) ? all.map((i) => i.closest('figure').id) : null"))
        self.assertEqual(set(shown), {scene.replace(".", "-") for scene in DRAWN})
        browser.post("/url", {"url": (self.site / "concepts.html").as_uri()})
        browser.run("document.querySelector('[data-md-component=search-query]').focus()")
        browser.type("[data-md-component=search-query]", "horizon")
        chromium.until("search finds the word", lambda: browser.run(
            "return [...document.querySelectorAll('.md-search-result__link')].map(a => a.href)"))
        found = browser.run("return [...document.querySelectorAll('.md-search-result__link')].map(a => a.href)")
        self.assertTrue(any("glossary.html" in address for address in found), found)
        self.assertTrue(all(address.startswith(self.site.as_uri()) for address in found), found)
        browser.devtools("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
        for name in ("index", "tutorial", "concepts", "gates", "reference/scenarios", "reference/metrics"):
            browser.post("/url", {"url": (self.site / f"{name}.html").as_uri()})
            self.assertLessEqual(browser.run("return document.scrollingElement.scrollWidth"), 390, name)
        severe = [entry["message"] for entry in browser.log("browser") if entry["level"] == "SEVERE"]
        self.assertEqual(severe, [])
        for entry in browser.log("performance"):
            self.assertNotRegex(entry["message"], r'"url":"https?:', "a request left the disk")


if __name__ == "__main__":
    if not build.can_build_sites():
        print("skipped: mkdocs with its Material theme is not installed (apt-get install mkdocs-material)")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
