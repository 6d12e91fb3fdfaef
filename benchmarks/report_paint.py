#!/usr/bin/env python3
"""How soon a report shows in headless Chromium: report_paint.py REPORT.html [RUNS]
Prints the size of the file, and the median and largest of the first contentful paint and of the whole page's drawing, in
milliseconds from the start of the navigation. Goals: under 4 MB, first paint within 1000 ms on two cores."""
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "validation" / "tests" / "reports"))
from chromium import SKIPPED, Browser, programs, until  # noqa: E402

TIMES = """const paint = performance.getEntriesByType('paint').find(e => e.name === 'first-contentful-paint');
    return [paint?.startTime ?? null, Number(document.documentElement.dataset.drawn ?? NaN)]"""


def main():
    found = programs()
    if not found:
        return SKIPPED
    path = pathlib.Path(sys.argv[1]).resolve()
    paints, drawn = [], []
    for _ in range(int(sys.argv[2]) if len(sys.argv) > 2 else 5):
        browser = Browser(*found)
        try:
            browser.post("/url", {"url": path.as_uri()})
            until("the report is drawn", lambda: browser.run("return document.documentElement.dataset.ready === 'true'"), 60)
            paint, whole = until("the report is painted", lambda: (lambda t: t if t[0] is not None else None)(browser.run(TIMES)))
            paints.append(paint)
            drawn.append(whole)
        finally:
            browser.close()
    print(f"{path.stat().st_size / 1e6:.2f} MB")
    for name, times in (("first paint", paints), ("all drawn", drawn)):
        print(f"{name}: median {statistics.median(times):.0f} ms, largest {max(times):.0f} ms of {len(times)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
