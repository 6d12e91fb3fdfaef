#!/usr/bin/env python3
"""The manual's pages of methods and metrics, which the program writes, give the formula and the source of each: of every method and
response of the engine, of every metric. Formulas have matched brackets, and those with numbers satisfy what they must.
formulas_test.py ATWOOD ROOT"""
import fractions
import json
import pathlib
import re
import sys
import unittest

PROGRAM, ROOT = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
sys.path.insert(0, str(ROOT / "packaging/manual"))
import reference_pages  # noqa: E402


def closed(text):
    """Whether all brackets of a formula match, those of norms aside."""
    open_ones = []
    for sign in text:
        if sign in "({":
            open_ones.append(sign)
        elif sign in ")}" and (not open_ones or "({".index(open_ones.pop()) != ")}".index(sign)):
            return False
    return not open_ones


class Formulas(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.data = json.loads(reference_pages.ask(PROGRAM, "list", "--json"))
        cls.methods = {m["id"]: m for m in cls.data["methods"] + cls.data["responses"] if m["id"].startswith(("atwood/", "+"))}
        cls.formulas = {id: m["formula"] for id, m in cls.methods.items()}

    def test_every_method_has_a_formula_and_a_source(self):
        self.assertGreater(len(self.methods), 90)
        for id, formula in self.formulas.items():
            with self.subTest(id):
                self.assertTrue(re.search(r"[a-z)'_] (=|>=) \S|[DKSBRTEC]\*?\(", formula), f"no formula: {formula!r}")
                self.assertTrue(closed(formula), formula)
                self.assertRegex(self.methods[id]["source"], r"\d{4}|Hairer|GDC", "no source")

    def test_equations_stand_on_lines_of_their_own(self):
        """A separator outside brackets is followed by no second equation."""
        for id, formula in self.formulas.items():
            for line in formula.splitlines():
                with self.subTest(id, line=line):
                    outside = re.sub(r"\([^()]*\)", "", re.sub(r"\([^()]*\)", "", line))
                    self.assertLessEqual(sum(" = " in part for part in re.split(r"[,;] ", outside)), 1 if id.startswith("atwood/") else 9)
        described = reference_pages.ask(PROGRAM, "describe", "atwood/rk4")
        self.assertIn("\n  Formula:\n    k_1 = f(t, y)\n    k_2 = f(t + h/2, y + h/2 k_1)\n", described)

    def test_every_metric_has_a_formula_and_a_source(self):
        self.assertGreater(len(self.data["metrics"]), 150)
        for metric in self.data["metrics"]:
            with self.subTest(metric["name"]):
                if metric["name"] in ("status", "truth"):  # words, no figures
                    self.assertEqual((metric["formula"], metric["source"]), ("", ""))
                    continue
                self.assertTrue(closed(metric["formula"]) and len(metric["formula"]) > 3, metric["formula"])
                self.assertRegex(metric["source"], r"^here|\d{4}|\(2nd ed\.\)|xxHash")

    def test_the_pages_show_them(self):
        page = reference_pages.methods_page(self.data)
        self.assertEqual(page.count("\nFormula:\n\n```text\n"), len(self.methods))
        self.assertEqual(len(re.findall(r"^Source: \S", page, re.M)), len(self.methods))
        lines = [line for line in reference_pages.metrics_page(self.data).splitlines() if line.startswith("| <span")]
        self.assertEqual(len(lines), len(self.data["metrics"]))
        for line in lines:
            self.assertEqual(len(re.split(r"(?<!\\)\|", line)), 7, line)

    def test_coefficients_of_multistep_methods(self):
        """Each formula of order k integrates polynomials of degree k - 1 exactly."""
        for order in range(2, 9):
            for kind, newest, at in (("bashforth", "f_n", 0), ("moulton", "f_(n+1)", 1)):
                formula = self.formulas[f"atwood/adams-{kind}{order}"]
                inner = formula.split("h (", 1)[1].split(")\nnabla")[0]
                terms = re.split(r" (?=[+-] )", inner)
                self.assertEqual(len(terms), order, formula)
                coefficients = [fractions.Fraction(1)] + [fractions.Fraction(term.split()[0] + term.split()[1]) for term in terms[1:]]
                # int_0^1 of s^m equals the formula's value for f(s) = s^m, rates at s = at, at - 1, ...
                for power in range(order):
                    value = lambda s: fractions.Fraction(s) ** power
                    row, total = [value(at - k) for k in range(order)], fractions.Fraction(0)
                    for c in coefficients:
                        total += c * row[0]
                        row = [a - b for a, b in zip(row, row[1:])]
                    self.assertEqual(total, fractions.Fraction(1, power + 1), f"{kind}{order}, s^{power}")

    def test_steps_of_compositions_satisfy_order_conditions(self):
        """The order conditions of a composition of a symmetric map, of order 6 and above, whose steps sum to 1: sum w^3 = sum w^5 = 0."""
        for id, count in (("atwood/yoshida6", 3), ("atwood/yoshida8", 7), ("atwood/kahan-li8", 8), ("atwood/boris6", 4), ("atwood/rattle6", 4)):
            w = {int(k): float(x) for k, x in re.findall(r"w_(\d) = (-?[\d.]+\d)(?=[,;.]|$)", self.formulas[id], re.M)}
            w.pop(0, None)
            self.assertEqual(sorted(w), list(range(1, count + 1)), self.formulas[id])
            middle = 1 - 2 * sum(w.values())
            for power in (3, 5):
                self.assertAlmostEqual(2 * sum(x ** power for x in w.values()) + middle ** power, 0, delta=1e-11, msg=f"{id}, sum w^{power}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
