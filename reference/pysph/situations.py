"""Compiles what PySPH needs for the scenes of the catalogue, before a cell's time limit runs: one small scene for each kind.

PySPH's code depends on a scheme's equations and kernel, and not on numbers: on whether the fluid is viscous, whether it has
a free surface (edac), and on the kinds of its walls.
"""
import sys

import schemes
from run import Run
from scene import Fluid

PERIODIC = [1, 1]
CHANNEL = [1, 0]
OPEN = [0, 0]
# Periods, slips of the walls at y = 0 and y = 1, viscosity, equation of state.
KINDS = {"vortices": (PERIODIC, (), 0.01, "linear"), "channel": (CHANNEL, ("no-slip", "no-slip"), 0.01, "linear"),
         "sound": (PERIODIC, (), 0, "linear"), "patch": (OPEN, (), 0, "linear"), "drop": (OPEN, (), 0, "tait"),
         "column": (CHANNEL, ("free-slip",), 0.01, "tait")}


def scene(periods, slips, viscosity, equation_of_state, cells=20):
    at = [(i + 0.5) / cells for i in range(cells)]
    planes = [([0, 1, 0], 0), ([0, -1, 0], -1)]
    bodies = [{"name": f"wall {n}", "fixed": True, "shape": {"plane": {"normal": normal, "offset_m": offset}},
               "position_m": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0], "velocity_m_per_s": [0, 0, 0],
               "angular_velocity_body_rad_per_s": [0, 0, 0]} for n, (normal, offset) in enumerate(planes[:len(slips)])]
    particles = {"position_m": [[x, y] for x in at for y in at], "velocity_m_per_s": 0, "mass_kg": 1 / cells**2,
                 "density_kg_per_m3": 1, "temperature_K": 0}
    fluid = {"name": "fluid", "region": {"box": {"min_m": [0, 0], "max_m": [1, 1]}}, "spacing_m": 1 / cells,
             "density_kg_per_m3": 1, "sound_speed_m_per_s": 10, "equation_of_state": equation_of_state,
             "viscosity_m2_per_s": viscosity, "particles": particles}
    return {"gravity_m_per_s2": [0, 0, 0], "bodies": bodies, "domain": {"dimensions": 2, "periodic_m": periods},
            "fluids": [fluid], "fluid_boundaries": [{"body": body["name"], "slip": slip} for body, slip in zip(bodies, slips)]}


def compile_all():
    for name, scheme, settings in schemes.presets():
        for kind, parts in KINDS.items():
            fluid = Fluid(scene(*parts))
            if schemes.refusal(name, scheme, fluid):
                continue
            print(f"compiling pysph/{name}: {kind}", file=sys.stderr)
            Run(fluid, scheme, settings, 1.0, 100)
