"""Drawings as SVG, small and legible on light and dark pages."""
import html
import math

# Text and lines follow the reader's theme; the colours of data (Okabe, Ito 2008) are legible on both.
STYLE = ("<style>text{font:12px sans-serif;fill:#333}.faint{fill:#666;font-size:11px}.ink{stroke:#333}"
         "@media(prefers-color-scheme:dark){svg{filter:brightness(1.3)}"
         "text{fill:#ddd}.faint{fill:#aaa}.ink{stroke:#ddd}}</style>")
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8c6bb1", "#7f7f7f"]


def number(x):
    return f"{x:.1f}".rstrip("0").rstrip(".") if "." in f"{x:.1f}" else f"{x:.1f}"


def text(x, y, words, anchor="start", more=""):
    return f'<text x="{number(x)}" y="{number(y)}" text-anchor="{anchor}"{more}>{html.escape(words)}</text>'


def polyline(points, colour, width=1.6, more=""):
    path = " ".join(f"{number(x)},{number(y)}" for x, y in points)
    return (f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}" '
            f'stroke-linejoin="round"{more}/>')


def document(width, height, title, parts):
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" role="img">'
            f"<title>{html.escape(title)}</title>{STYLE}{''.join(parts)}</svg>\n")


class Axis:
    """From values to places: linear, or logarithmic for `log`."""

    def __init__(self, low, high, start, end, log=False):
        self.low, self.high, self.start, self.end, self.log = low, high, start, end, log

    def at(self, value):
        f = math.log10 if self.log else float
        return self.start + (f(value) - f(self.low)) / (f(self.high) - f(self.low)) * (self.end - self.start)

    def ticks(self):
        """(value, words)."""
        if self.log:
            first, last = math.ceil(math.log10(self.low) - 1e-9), math.floor(math.log10(self.high) + 1e-9)
            step = max(1, math.ceil((last - first) / 7))
            return [(10.0**k, {0: "1", 1: "10"}.get(k, f"1e{k}")) for k in range(first, last + 1, step)]
        raw = (self.high - self.low) / 5
        size = 10 ** math.floor(math.log10(raw))
        step = next(m * size for m in (1, 2, 5, 10) if m * size >= raw)
        first = math.ceil(self.low / step - 1e-9)
        return [(k * step, f"{k * step:g}") for k in range(first, math.floor(self.high / step + 1e-9) + 1)]


class Plot:
    """Curves over two axes, named at their right ends where there is room."""

    def __init__(self, title, x, y, x_name, y_name, width=640, height=360, right=150):
        self.title, self.width, self.height, self.parts, self.names = title, width, height, [], []
        self.x = Axis(*x[:2], 70, width - right, *x[2:])
        self.y = Axis(*y[:2], height - 48, 22, *y[2:])
        for value, words in self.x.ticks():
            at = self.x.at(value)
            self.parts += [polyline([(at, self.y.start), (at, self.y.end)], "#8884", 1),
                           text(at, self.y.start + 16, words, "middle")]
        for value, words in self.y.ticks():
            at = self.y.at(value)
            self.parts += [polyline([(self.x.start, at), (self.x.end, at)], "#8884", 1),
                           text(self.x.start - 6, at + 4, words, "end")]
        self.parts.append(text((self.x.start + self.x.end) / 2, height - 10, x_name, "middle"))
        self.parts.append(text(14, 14, y_name))

    def curve(self, points, colour, name="", marks=True, dashed=False, width=1.8, at_end=False):
        placed = [(self.x.at(x), self.y.at(y)) for x, y in points
                  if self.y.low <= y <= self.y.high and self.x.low <= x <= self.x.high]
        if not placed:
            raise ValueError(f"{self.title}: no point of `{name}` lies within the axes")
        self.parts.append(polyline(placed, colour, width, ' stroke-dasharray="5 4"' if dashed else ""))
        if marks:
            self.parts += [f'<circle cx="{number(x)}" cy="{number(y)}" r="2.6" fill="{colour}"/>' for x, y in placed]
        if name:
            last = placed[-1] if at_end else max(placed)
            self.names.append([last[1], last[0], name, colour])

    def band(self, low, high, words, colour="#0072b2"):
        """A horizontal stripe between two values of y."""
        top, bottom = self.y.at(min(high, self.y.high)), self.y.at(max(low, self.y.low))
        self.parts.append(f'<rect x="{number(self.x.start)}" y="{number(top)}" '
                          f'width="{number(self.x.end - self.x.start)}" height="{number(bottom - top)}" '
                          f'fill="{colour}" opacity=".15"/>')
        if words:
            self.parts.append(text(self.x.start + 6, bottom - 5, words, more=' class="faint"'))

    def column(self, low, high, words, colour="#009e73"):
        """A vertical stripe between two values of x."""
        a, b = sorted((self.x.at(low), self.x.at(high)))
        self.parts.append(f'<rect x="{number(a)}" y="{number(self.y.end)}" width="{number(b - a)}" '
                          f'height="{number(self.y.start - self.y.end)}" fill="{colour}" opacity=".13"/>')
        self.parts.append(text((a + b) / 2, self.y.end + 13, words, "middle", ' class="faint"'))

    def note(self, x, y, words, anchor="start"):
        self.parts.append(text(self.x.at(x), self.y.at(y), words, anchor, ' class="faint"'))

    def svg(self):
        placed = -1e9
        for y, x, name, colour in sorted(self.names):
            placed = max(y + 4, placed + 14)
            self.parts.append(polyline([(x + 4, y), (self.x.end + 8, placed - 4)], colour, 0.7))
            self.parts.append(text(self.x.end + 11, placed, name, more=f' style="fill:{colour}"'))
        return document(self.width, self.height, self.title, self.parts)
