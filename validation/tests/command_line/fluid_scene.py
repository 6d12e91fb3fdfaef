"""A scene of vortices and an engine whose errors on it are known."""
import os

ENGINE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "fluid_engine.py")
# With a temperature the weakly compressible equations have no truth: none of its minutes here.
SCENE = """
id = "vortices"
[run]
t_end_s = 0.1
steps = [10]
samples = 2
spacings_m = [0.25, 0.125, 0.0625, 0.03125]
sound_speeds_m_per_s = [10, 20]
[domain]
dimensions = 2
periodic_m = [1, 1]
[[fluid]]
name = "water, still"
region.box = { min_m = [0, 0], max_m = [1, 1] }
arrangement = "disturbed"
density_kg_per_m3 = 1
viscosity_m2_per_s = 0.01
heat_capacity_J_per_kg_K = 1
initial = "taylor-green"
[[probe]]
kind = "pressure"
position_m = [0.5, 0.5]
[truth]
kind = "closed-form"
solution = "taylor-green"
""".replace("water, still", "water")


def known_error(row):
    return float(row["spacing_m"])**2 * (1 + float(row["spacing_m"]))
