"""Every shape that an engine has, laid at rest on a plane and on a box, stays where it was laid, to the slop that the engine
documents; validation/tests/rivals/rest_test.cpp asks the others. rest_test.py BIN_DIR NAME; skipped where it is not built."""
import math
import os
import sys
import unittest

from workers import Run, Worker, angle_between, body, has_node, law, scene

BIN_DIR, NAME = sys.argv[1], sys.argv[2]
GRAVITY, RATE_HZ = 9.81, 240
STEP_FALL_M = GRAVITY / RATE_HZ**2  # of a step without a contact
# The overlap at which a contact of the default settings carries a body.
SLOP_M = {"jolt": 0.02,  # PhysicsSettings.h: mPenetrationSlop
          "rapier": 0.005,  # the row's allowed_linear_error: IntegrationParameters.normalizedAllowedLinearError
          # MuJoCo, Computation: solver parameters. At rest r = (1 - d) g / (d k), k = d / (dmax timeconst)^2, d = 0.9 at
          # least; twice that where the points of a contact share the load unevenly.
          "mujoco3": 2 * (1 - 0.9) / 0.9**2 * GRAVITY * (0.95 * 0.02) ** 2}[NAME]
S = math.sqrt(0.5)
UP, LYING = [1, 0, 0, 0], [S, 0, S, 0]


def corners(a, b, c):
    return [[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)]


def box(*half_extents_m):
    return {"box": {"half_extents_m": list(half_extents_m)}}


PARTS = [{"half_extents_m": [0.1, 0.2, 0.05], "position_body_m": [-0.1, 0, 0], "orientation_wxyz": UP},
         {"half_extents_m": [0.1, 0.1, 0.05], "position_body_m": [0.1, 0, 0], "orientation_wxyz": UP}]
LAID = {"sphere": ({"sphere": {"radius_m": 0.1}}, 0.1, UP), "box": (box(0.1, 0.1, 0.1), 0.1, UP), "thin box": (box(0.3, 0.2, 0.01), 0.01, UP),
        "lying capsule": ({"capsule": {"radius_m": 0.1, "half_length_m": 0.2}}, 0.1, LYING),
        "cylinder": ({"cylinder": {"radius_m": 0.1, "half_length_m": 0.1}}, 0.1, UP),
        "lying cylinder": ({"cylinder": {"radius_m": 0.1, "half_length_m": 0.2}}, 0.1, LYING),
        "cube as a hull": ({"convex": {"points_m": corners(0.1, 0.1, 0.1)}}, 0.1, UP),
        "thin plate as a hull": ({"convex": {"points_m": corners(0.3, 0.2, 0.01)}}, 0.01, UP),
        "tall hull": ({"convex": {"points_m": corners(0.05, 0.05, 0.2)}}, 0.2, UP),
        "pyramid": ({"convex": {"points_m": [[0.1, 0.1, -0.05], [-0.1, 0.1, -0.05], [0, -0.2, -0.05], [0, 0, 0.15]]}}, 0.05, UP),
        "compound": ({"compound": {"boxes": PARTS}}, 0.05, UP)}
FLOORS = {"plane": ({"plane": {"normal": [0, 0, 1], "offset_m": 0}}, 0), "box": (box(1, 1, 0.5), -0.5)}
# What does not rest by the engine's own doing; the test notices when it does.
LOSSES = {"rapier": {("lying cylinder", "box")}}.get(NAME, set())  # rolls by the round-off of float


class Rest(unittest.TestCase):
    def test_every_shape_stays_to_the_documented_slop(self):
        worker = Worker(BIN_DIR, NAME)
        self.addCleanup(worker.close)
        allowed_m = SLOP_M + 2 * STEP_FALL_M
        for name, (shape, height_m, q) in LAID.items():
            for under, (floor, z_m) in FLOORS.items():
                start = [0.02, 0.01, height_m]
                mover = body("mover", shape=shape, position_m=start, orientation_wxyz=q, inertia_kg_m2=[0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01])
                ground = body("ground", fixed=True, shape=floor, position_m=[0, 0, z_m])
                run = Run(worker, "default", scene(ground, mover, gravity=(0, 0, -GRAVITY), laws=[law(friction=0.5)]), 1, RATE_HZ, samples=60)
                with self.subTest(shape=name, floor=under):
                    self.assertEqual(run.done["status"], "ok", run.done)
                    rows = [sample["bodies"][1] for sample in run.samples]
                    centre_m = max(math.dist(row[:3], start) for row in rows)
                    turn_m = max(0.1 * angle_between(row[3:7], q) for row in rows)
                    stays = centre_m <= allowed_m and turn_m <= allowed_m
                    self.assertEqual(stays, (name, under) not in LOSSES, f"{centre_m} m, {turn_m} m by the turn, of {allowed_m} m")


if __name__ == "__main__":
    if not has_node() or not os.path.exists(f"{BIN_DIR}/atwood-{NAME}"):
        print(f"atwood-{NAME} is not built, or there is no Node.js of version 18.3 or newer")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
