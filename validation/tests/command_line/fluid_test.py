"""Fluids through the built program: the ladders of spacing and sound speed, errors and orders of an engine whose errors are
known, particles, probes and files for ParaView. Called with the program and the project's root."""
import base64
import csv
import io
import json
import os
import re
import struct
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ROOT, Case  # noqa: E402
from fluid_scene import ENGINE, SCENE, known_error  # noqa: E402


class Fluids(Case):
    def rows(self, *words, code=0, scene=SCENE):
        self.path("scene.toml", scene)
        out = self.path("rows.csv")
        self.ask("run", "--scenario", "scene.toml", "--engine", ENGINE, "--out", "out", "-o", "csv:" + out, "--no-timing",
                 *words, code=code)
        with open(out) as file:
            return list(csv.DictReader(file))

    def test_every_spacing_and_speed_is_a_cell_with_as_many_steps(self):
        rows = self.rows("--method", "known/vortices")
        cells = {(r["spacing_m"], r["sound_speed_m_per_s"], r["steps"]) for r in rows if r["metric"] == "velocity-l1"}
        self.assertEqual(cells, {(dx, c, str(10 * n * m)) for dx, n in (("0.25", 1), ("0.125", 2), ("0.0625", 4), ("0.03125", 8))
                                 for c, m in (("10", 1), ("20", 2))})

    def test_a_resolution_needs_a_fluid(self):
        self.ask("run", "--scenario", "ballistic", "--method", "atwood/rk4", "--spacing", "0.1", "--no-timing", code=2,
                 told=["--spacing: no scene of this run has a fluid"])
        for option in ("--spacing", "--sound-speed"):
            self.ask("trace", "taylor-green", "--method", "atwood/rk4+sph", option, "0", code=2, told=[option + ": found `0`; expected a number of metres"])

    def test_bodies_of_a_scene_that_has_none(self):
        self.ask("trace", "taylor-green", "--method", "atwood/rk4+sph", "--spacing", "0.125", "--samples", "1", "--steps", "100",
                 told=["--particles prints the particles"])

    def test_known_errors(self):
        rows = self.rows("--method", "known/vortices{space=1.0}")
        for r in rows:
            if r["metric"] in ("velocity-l1", "velocity-l2", "velocity-linf") and r["t_s"] in ("", "0.1"):
                self.assertAlmostEqual(float(r["value"]), known_error(r), delta=1e-12)
                self.assertIn("of the exact field's own norm", r["reason"])
            if r["metric"] == "pressure-l2":
                self.assertLess(float(r["value"]), 1e-12)
            if r["metric"] == "kinetic-energy-error":
                grown = (1 + known_error(r))**2 - 1
                self.assertGreater(float(r["value"]), 0.5 * grown)
                self.assertLess(float(r["value"]), grown)
            if r["metric"] == "closing-residual":
                self.assertLess(float(r["value"]), 1e-14)

    def test_an_engine_of_its_own_equations_on_a_scene_measured_in_parts(self):
        scene = SCENE.replace('kind = "closed-form"', 'kind = "semi-discrete"').replace("heat_capacity_J_per_kg_K = 1\n", "")
        self.path("scene.toml", scene)
        words = ["run", "--scenario", "scene.toml", "--engine", ENGINE, "--no-timing", "--spacing", "0.125", "--sound-speed", "10",
                 "--out", "out", "-o", "csv:rows.csv", "--method", "known/vortices"]
        told = self.ask(*words).stdout
        self.assertNotIn("no truth", told)
        self.assertIn("1 cell\n", told)
        with open(self.path("rows.csv")) as file:
            rows = list(csv.DictReader(file))
        metrics = {r["metric"] for r in rows}
        self.assertNotIn("truth", metrics)
        self.assertLessEqual({"velocity-l1", "model-error", "space-error"}, metrics)
        self.assertNotIn("time-error", metrics)
        # Without a solution nothing is measured of such an engine, and the report says so.
        self.path("scene.toml", scene.replace('solution = "taylor-green"\n', ""))
        told = " ".join(self.ask(*words, code=[0, 1]).stdout.split())
        self.assertIn("ended as unsupported", told)
        self.assertIn("Errors, orders and what else needs a truth are not measured.", told)

    def test_temperatures_below_0_kelvin_are_refused(self):
        for cold in ("-300", "-1e-9"):
            self.path("scene.toml", SCENE.replace("heat_capacity_J_per_kg_K = 1\n",
                                                  "heat_capacity_J_per_kg_K = 1\ntemperature_K = " + cold + "\n"))
            self.ask("describe", "scene.toml", code=2, told=["temperature_K", "at least 0"])

    def test_order_in_space(self):
        rows = self.rows("--method", "known/vortices{space=1.0}", "--sound-speed", "10", "--spacing", "0.25", "--spacing", "0.125",
                         "--spacing", "0.0625", "--spacing", "0.05", "--spacing", "0.03125", scene=SCENE.replace(
                             "viscosity_m2_per_s = 0.01", "viscosity_m2_per_s = 0.02"))
        orders = [r for r in rows if r["metric"] == "order-space"]
        self.assertEqual([(r["spacing_m"], r["sound_speed_m_per_s"], r["steps"]) for r in orders], [("", "10", "0")])
        self.assertAlmostEqual(float(orders[0]["value"]), 2, delta=0.05 + float(orders[0]["truth_bar"]))

    def test_a_cell_runs_again_alone(self):
        rows = self.rows("--method", "known/vortices", "--spacing", "0.125", "--sound-speed", "20", "--steps", "40")
        cells = {(r["spacing_m"], r["sound_speed_m_per_s"], r["steps"]) for r in rows if r["metric"] == "velocity-l1"}
        self.assertEqual(cells, {("0.125", "20", "40")})

    def test_gates_of_one_resolution(self):
        self.path("gates.toml", """
[[gate]]
scenario = "vortices"
method = "*"
metric = "velocity-l1"
spacing_m = 0.25
sound_speed_m_per_s = 20
max = 0.08
reason = "0.25^2 x 1.25 = 0.078"
[[gate]]
scenario = "vortices"
method = "*"
metric = "velocity-l1"
spacing_m = 0.125
max = 0.01
reason = "0.125^2 x 1.125 = 0.0176 is above it"
""")
        self.path("scene.toml", SCENE)
        told = self.ask("run", "--scenario", "scene.toml", "--engine", ENGINE, "--out", "out", "--no-timing", "--method",
                        "known/vortices", "--tolerances", "gates.toml", "--json", code=1)
        verdicts = [v for v in json.loads(told.stdout)["verdicts"] if v["metric"] == "velocity-l1"]
        self.assertEqual(sorted(v["judgement"] for v in verdicts), ["fail", "fail", "pass"])
        rerun = next(v for v in verdicts if v["judgement"] == "fail")["rerun"]
        self.assertIn("--spacing 0.125", rerun)
        self.assertRegex(rerun, "--sound-speed (10|20)")

    def test_other_engines_refuse_by_name(self):
        other = os.path.join(ROOT, "reference/your_engine/worker.py")
        rows = self.rows("--engine", other, "--method", "python/symplectic-euler", "--spacing", "0.25")
        rows = [r for r in rows if r["method"] == "python/symplectic-euler"]
        self.assertEqual({(r["status"], r["reason"]) for r in rows}, {("unsupported", "python simulates no fluids")})

    def test_a_number_that_is_not_finite_ends_the_cell(self):
        rows = self.rows("--method", "known/vortices{nan_at=2}", "--spacing", "0.25", "--sound-speed", "10", code=[0, 1])
        status = [r for r in rows if r["metric"] == "status"]
        self.assertEqual([r["status"] for r in status], ["not finite"])
        self.assertIn("particle 3 of the fluid `water` at t = 0.1 s", status[0]["reason"])

    def trace(self, *words, code=0, told=()):
        self.path("scene.toml", SCENE)
        return self.ask("trace", "scene.toml", "--engine", ENGINE, "--method", "known/vortices", *words, code=code, told=told)

    def test_particles(self):
        rows = list(csv.reader(io.StringIO(self.trace("--particles", "--spacing", "0.125").stdout)))
        self.assertEqual(",".join(rows[0]),
                         "t_s,fluid,particle,px_m,py_m,pz_m,vx_m_per_s,vy_m_per_s,vz_m_per_s,density_kg_per_m3,pressure_Pa,"
                         "temperature_K")
        self.assertEqual(len(rows), 1 + 3 * 64)
        self.assertEqual(rows[1][:3], ["0", "water", "0"])
        self.assertEqual(rows[-1][:3], ["0.1", "water", "63"])

    def test_probes(self):
        rows = list(csv.reader(io.StringIO(self.trace("--probes", "--spacing", "0.03125").stdout)))
        self.assertEqual(rows[0], ["t_s", "probe", "value", "unit"])
        self.assertEqual([r[1] for r in rows[1:]], ["pressure"] * 3)
        self.assertAlmostEqual(float(rows[1][2]), -0.5, delta=0.03)  # -rho U^2 / 4 (1 + 1)
        self.assertEqual(rows[1][3], "Pa")

    def test_a_probe_without_particles_around_it_says_so(self):
        far = SCENE.replace("periodic_m = [1, 1]", "periodic_m = [0, 0]").replace("position_m = [0.5, 0.5]", "position_m = [0.5, 50]")
        self.path("scene.toml", far.replace('[truth]\nkind = "closed-form"\nsolution = "taylor-green"', '[truth]\nkind = "none"')
                  .replace('initial = "taylor-green"\n', ""))
        told = self.ask("trace", "scene.toml", "--engine", ENGINE, "--method", "known/vortices", "--probes", "--spacing", "0.25")
        self.assertEqual([r.split(",")[2] for r in told.stdout.splitlines()[1:]], [""] * 3)
        self.assertIn("the probe `pressure` has no value at 3 of 3 samples: no particle is within 0.75 m of [0.5, 50] m",
                      told.stderr)

    def test_files_for_paraview(self):
        self.trace("-o", "vtk:pv", "--spacing", "0.25")
        self.assertEqual(sorted(os.listdir(self.path("pv"))),
                         ["vortices-0000.vtp", "vortices-0001.vtp", "vortices-0002.vtp", "vortices.pvd"])
        with open(self.path("pv/vortices.pvd")) as file:
            self.assertIn('timestep="0.05" part="0" file="vortices-0001.vtp"', file.read())
        with open(self.path("pv/vortices-0002.vtp")) as file:
            text = file.read()
        self.assertIn('NumberOfPoints="16" NumberOfVerts="16"', text)
        arrays = {name: base64.b64decode(data) for name, data in
                  re.findall(r'Name="(\w+)"[^>]*format="binary">([^<]*)<', text)}
        self.assertEqual(struct.unpack("<Q", arrays["position"][:8])[0], 16 * 3 * 8)
        self.assertEqual(len(arrays["position"]), 8 + 16 * 3 * 8)
        csv_rows = list(csv.DictReader(io.StringIO(self.trace("--particles", "--spacing", "0.25").stdout)))[-16:]
        velocities = struct.unpack("<48d", arrays["velocity"][8:])
        self.assertEqual(list(velocities[::3]), [float(r["vx_m_per_s"]) for r in csv_rows])
        self.assertEqual(list(struct.unpack("<16q", arrays["offsets"][8:])), list(range(1, 17)))

    def test_the_exact_field_where_particles_start(self):
        self.path("scene.toml", SCENE)
        told = self.ask("trace", "scene.toml", "--method", "truth", "--particles", "--spacing", "0.25")
        rows = list(csv.DictReader(io.StringIO(told.stdout)))
        self.assertEqual(len(rows), 3 * 16)
        self.assertIn("vx_m_per_s_bar", rows[0])

    def test_a_cube_floats_where_it_displaces_its_mass(self):
        with open(os.path.join(ROOT, "validation", "scenarios", "fluid", "floating-cube.toml")) as file:
            cube = file.read()
        # A quarter of the density of water: a quarter of it is under water.
        light = cube.replace("mass_kg = 80", "mass_kg = 40").replace("[0.6, 0.6, 0]", "[0.6, 0.7, 0]")
        for scene, at in ((cube, 0.6), (light, 0.7)):
            told = self.ask("trace", self.path("cube.toml", scene), "--method", "atwood/rk4+sph{density_diffusion=0.1}",
                            "--limit", "200").stdout
            heights = [float(row["py_m"]) for row in csv.DictReader(io.StringIO(told)) if row["body"] == "cube"]
            self.assertEqual(len(heights), 11)
            for y in heights:
                self.assertAlmostEqual(y, at, delta=3e-3)

    def refused_before_any_cell(self, scene, method, told, *more):
        for words in (["trace", scene, "--particles", "--method", method],
                      ["run", "--scenario", scene, "--no-timing", "--method", method],
                      ["compare", method, method.replace("rk4", "heun"), "--scenario", scene],
                      ["advise", scene, "--metric", "volume-error", "--error", "0.1", "--method", method]):
            self.ask(*words, *more, code=2, told=told)
            self.assertFalse(os.path.exists(self.path("atwood-out/store.db")))

    def test_a_kernel_wider_than_half_the_period_is_refused_before_any_cell(self):
        self.path("scene.toml", SCENE)
        told = ["`vortices`", "0.65 m at a spacing of 0.25 m, more than half the period of 1 m along x",
                "a spacing of at most 0.1923 m"]
        self.refused_before_any_cell("scene.toml", "atwood/rk4+sph", told)
        self.refused_before_any_cell("scene.toml", "atwood/rk4+sph{smoothing=2.1}", ["0.525 m at a spacing of 0.125 m"],
                                     "--spacing", "0.125")
        self.refused_before_any_cell("scene.toml", "atwood/rk4+polynomial", ["the support of the fits is 0.775 m"])
        # Some spacing of a glob's methods fits: the others are cells that say so.
        out = self.ask("run", "--scenario", "scene.toml", "--method", "atwood/heu*+sph", "--sound-speed", "10", "--no-timing",
                       "--spacing", "0.25", "--spacing", "0.125", "--json", code=[0, 1]).stdout
        status = [r for r in json.loads(out)["rows"] if r["metric"] == "status"]
        self.assertEqual([(r["status"], r["spacing_m"]) for r in status], [("unsupported", 0.25)])

    def test_a_free_surface_wants_degree_2(self):
        self.ask("trace", "elliptic-drop", "--method", "atwood/rk4+polynomial", "--particles", code=2,
                 told=["degree=4, the default, of +polynomial has no free surface", "expected degree=2"])

    def test_scenes_that_cannot_be_simulated_are_refused_with_the_figure(self):
        still = SCENE.replace('kind = "closed-form"', 'kind = "none"').replace('solution = "taylor-green"\n', "")
        slab = """
[[body]]
name = "slab"
fixed = true
shape.box = { half_extents_m = [0.1, 0.15, 0.1] }
position_m = [0.5, 0.5, 0]
[[fluid_boundary]]
body = "slab"
"""
        fine = still.replace("spacings_m = [0.25, 0.125, 0.0625, 0.03125]", "spacings_m = [0.0625]")
        self.path("slab.toml", fine + slab)
        self.refused_before_any_cell("slab.toml", "atwood/rk4+sph",
                                     ["`slab` is 0.2 m thick and leaks at a spacing of 0.125 m", "0.25 m"], "--spacing", "0.125")
        self.path("silent.toml", SCENE.replace("sound_speeds_m_per_s = [10, 20]", "sound_speeds_m_per_s = [0]"))
        self.refused_before_any_cell("silent.toml", "atwood/rk4+sph", ["`sound_speeds_m_per_s` in [run] is 0"])
        self.path("scene.toml", SCENE)
        self.refused_before_any_cell("scene.toml", "atwood/rk4+sph", ["1 m along x is 3.33333 spacings of 0.3 m"],
                                     "--spacing", "0.3")

    def test_a_number_that_is_not_finite_ends_the_engine_s_run_with_where_and_when(self):
        self.path("huge.toml", SCENE.replace('initial = "taylor-green"', "velocity_gradient_per_s = [[1e308, 0], [0, -1e308]]")
                  .replace('kind = "closed-form"', 'kind = "none"').replace('solution = "taylor-green"\n', ""))
        told = self.ask("trace", "huge.toml", "--method", "atwood/rk4+sph", "--particles", "--spacing", "0.125", code=1)
        self.assertRegex(told.stderr, r"particle 0 of `water` is not finite at t = 0.005 s; it was at \[0.07\d*, 0.08\d*\] m")

    def test_words_that_make_no_sense(self):
        self.trace("--particles", "--probes", code=2)
        self.trace("-o", "csv:x", code=2, told=["expected vtk:DIR"])
        self.trace("--particles", "--spacing", "0.3", code=2, told=["0.3", "does not fill"])
        self.ask("trace", "kepler-e0.6", "--method", "atwood/rk4", "--particles", code=2, told=["has no fluid"])

    def test_describe(self):
        self.path("scene.toml", SCENE)
        self.ask("describe", "scene.toml", told=["`water`: 16 particles on a disturbed lattice", "starts as `taylor-green`",
                                                 "period 1 m along x"])

    def test_describe_asks_foreign_engines_whether_they_take_the_scene(self):
        self.path("scene.toml", SCENE)
        self.assertRegex(self.ask("describe", "scene.toml", "--engine", ENGINE).stdout, r"runs in .*\bknown\b")
        with open(ENGINE) as file:
            picky = file.read().replace('request["request"] == "run"', "False").replace("runs alone", "takes no vortices")
        told = self.ask("describe", "scene.toml", "--engine", self.path("picky.py", picky, 0o755)).stdout
        self.assertNotRegex(told, r"runs in .*\bknown\b")
        self.assertRegex(told, r"not in +known: takes no vortices")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
