"""Two runs of a heap of boxes end in the same bits: in one process, in two, and for Rapier in both of its builds. A heap is
chaotic, so that one bit of difference in any step shows. same_bits_test.py BIN_DIR; engines that are not built are left out."""
import os
import sys
import unittest

from workers import Run, Worker, body, exp, floor, law, scene

BIN_DIR = sys.argv[1]
ENGINES = [name for name in ("rapier", "jolt", "mujoco3") if os.path.exists(f"{BIN_DIR}/atwood-{name}")]
BUILDS = {"rapier": ["default", "deterministic"], "jolt": ["default"], "mujoco3": ["default"]}
BOXES = {"rapier": 40, "jolt": 40, "mujoco3": 16}  # a step of MuJoCo takes longest
T_END_S, STEPS = 4, 480


def heap(count, shift_m=0.0):
    """Boxes that fall on a heap, none of them level; `shift_m`: of the first one's start."""
    half, mass_kg = [0.1, 0.075, 0.05], 2.0
    a, b, c = (4 * x * x for x in half)
    inertia = [mass_kg / 12 * (b + c), 0, 0, 0, mass_kg / 12 * (a + c), 0, 0, 0, mass_kg / 12 * (a + b)]
    boxes = [body(f"box{k}", mass_kg=mass_kg, inertia_kg_m2=inertia, shape={"box": {"half_extents_m": half}},
                  position_m=[0.11 * (k % 2) + (shift_m if k == 0 else 0), 0.07 * (k % 3), 0.3 + 0.22 * k],
                  orientation_wxyz=exp([0.3 * (k % 5), 0.2 * (k % 7), 0.5 * (k % 3)])) for k in range(count)]
    return scene(floor(), *boxes, gravity=(0, 0, -9.81), laws=[law(friction=0.5)])


class SameBits(unittest.TestCase):
    def run_of(self, worker, method, of):
        run = Run(worker, method, of, T_END_S, STEPS, 4)
        self.assertEqual(run.done["status"], "ok", run.done)
        return run

    def rows(self, run):
        return [sample["bodies"] for sample in run.samples]

    def test_a_heap_of_boxes(self):
        for engine in ENGINES:
            one, other = Worker(BIN_DIR, engine), Worker(BIN_DIR, engine)
            for worker in (one, other):
                self.addCleanup(worker.close)
            with self.subTest(engine=engine):
                count = BOXES[engine]
                first = self.run_of(one, "default", heap(count))
                self.assertGreater(max(abs(x) for row in first.samples[-1]["bodies"][1:] for x in row[:2]), 0.3)  # it has spread
                # one of the sixth decimal is another heap: the comparison sees what happens
                self.assertNotEqual(self.rows(first)[-1], self.rows(self.run_of(one, "default", heap(count, 1e-6)))[-1])
                for method in BUILDS[engine]:
                    self.assertTrue(self.rows(first) == self.rows(self.run_of(one, method, heap(count))), f"{method}: the same process")
                    self.assertTrue(self.rows(first) == self.rows(self.run_of(other, method, heap(count))), f"{method}: another process")


if __name__ == "__main__":
    if not ENGINES:
        print("none of the engines is built")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
