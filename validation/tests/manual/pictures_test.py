"""The pictures of the concepts are what the program's runs give: drawn again, they have the same words and,
to a point and a half of the drawing, the same places."""
import json
import pathlib
import re
import sys
import unittest
import xml.etree.ElementTree as xml

from assembled import ATWOOD, ROOT
import gallery
import pictures
import reference_pages

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
ALLOWED = 1.5


def differs(one, other):
    """What differs between two drawings; None where nothing does."""
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return "the words or the shapes"
    for a, b in zip(NUMBER.findall(one), NUMBER.findall(other)):
        if abs(float(a) - float(b)) > ALLOWED:
            return f"{a} became {b}"
    return None


class Pictures(unittest.TestCase):
    def test_each_is_what_the_program_gives(self):
        for name in pictures.PICTURES:
            with self.subTest(picture=name):
                path = ROOT / f"docs/pictures/{name}.svg"
                wrong = differs(path.read_text(encoding="utf-8"), pictures.draw(str(ATWOOD), name))
                self.assertIsNone(wrong, f"packaging/manual/pictures.py PROGRAM docs/pictures {name} draws it anew")
                self.assertLess(path.stat().st_size, 20000)

    def test_a_difference_is_seen(self):
        drawn = (ROOT / "docs/pictures/window.svg").read_text(encoding="utf-8")
        first = NUMBER.search(drawn, drawn.index('polyline points="')).group(0)
        self.assertIsNone(differs(drawn, drawn))
        self.assertIsNotNone(differs(drawn, drawn.replace(first, str(float(first) + 2), 1)))
        self.assertIsNotNone(differs(drawn, drawn.replace("order", "Order", 1)))


class Gallery(unittest.TestCase):
    """Pictures of scenes: what is drawn, and where."""

    def drawn(self, scene, path=True):
        scenario = json.loads(reference_pages.ask(ATWOOD, "describe", scene, "--json"))
        poses = reference_pages.true_paths(ATWOOD, scenario) if path else []
        root = xml.fromstring(gallery.picture("a < b", scenario["scene"], poses))
        self.assertEqual(root.find("{*}title").text, "a < b")
        texts = [element.get("points") for element in root.iter() if element.get("points")]
        lines = [[tuple(map(float, point.split(","))) for point in text.split()] for text in texts]
        for x, y in (point for line in lines for point in line):
            self.assertTrue(0 <= x <= gallery.WIDTH and 0 <= y <= gallery.HEIGHT, (scene, x, y))
        return root, lines

    def test_an_orbit_is_seen_from_above(self):
        _, (orbit,) = self.drawn("kepler-e0.6")
        width, height = (max(p[i] for p in orbit) - min(p[i] for p in orbit) for i in (0, 1))
        self.assertAlmostEqual(height / width, 0.8, delta=0.01)  # sqrt(1 - e^2)

    def test_each_body_is_drawn_on_its_ground(self):
        root, lines = self.drawn("stack-10", path=False)
        self.assertEqual(len(root.findall(".//{*}polygon")), 10)
        (ground,) = [line for line in lines if len(line) == 5]
        self.assertEqual(ground[0], ground[-1])

    def test_joints_are_drawn_to_their_bodies(self):
        _, lines = self.drawn("double-pendulum-regular", path=False)
        self.assertEqual([len(line) for line in lines], [2, 2, 2])  # one anchor in the world, one between the bodies

    def test_a_body_that_flies_far_is_seen_from_its_centre(self):
        root, (path, _) = self.drawn("free-box-complex")
        (box,) = root.findall(".//{*}polygon")
        x, y = zip(*(map(float, p.split(",")) for p in box.get("points").split()))
        self.assertGreater(max(y) - min(y), 80)
        self.assertGreater(max(p[0] for p in path) - min(p[0] for p in path), max(x) - min(x))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
