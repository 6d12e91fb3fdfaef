"""What decides a figure is printed with it: settings of the engines under Node.js, beside those that the loaded packages have.
settings_test.py BIN_DIR ROOT; engines that are not built are left out."""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

from workers import Run, Worker, ball, body, floor, law, scene

BIN_DIR, ROOT = (os.path.abspath(path) for path in sys.argv[1:3])
ENGINES = [name for name in ("rapier", "jolt", "mujoco3") if os.path.exists(f"{BIN_DIR}/atwood-{name}")]
SCALAR = {"rapier": "float", "jolt": "float", "mujoco3": "double"}
# of every engine: precision, units, the step and its solver, laws of pairs, forces, joints, what is told, what is left out
COMMON = ["scalar", "units", "substeps", "step", "solver", "warm_start", "threads", "pair_law", "restitution", "rolling_friction",
          "spinning_friction", "forces", "gyroscopic", "sleeping", "plane", "contact_forces", "joints", "stops", "joint_forces", "reactions"]
# friction's model, damping, the margin of contacts, limits of velocities, continuous collision, softness, sweeps
OWN = {"rapier": ["friction_model", "linear_damping", "angular_damping", "prediction_distance", "contact_skin_m", "max_linear_speed",
                  "max_turn_rad", "ccd", "ccd_substeps", "soft_ccd_prediction_m", "build", "length_unit_m", "allowed_linear_error",
                  "contact_natural_frequency_Hz", "contact_damping_ratio", "solver_iterations", "pgs_iterations", "rectangle"],
       "jolt": ["friction_model", "linear_damping_per_s", "angular_damping_per_s", "speculative_contact_distance_m",
                "max_linear_velocity_m_per_s", "max_angular_velocity_rad_per_s", "continuous_collision", "driven_joints", "baumgarte",
                "penetration_slop_m", "velocity_steps", "position_steps", "min_velocity_for_restitution_m_per_s", "rectangle",
                "deterministic", "active_edges_only", "body_pair_cache_limits", "contact_cache_limits"],
       "mujoco3": ["cone", "impratio", "linear_damping", "angular_damping", "margin_m", "gap_m", "max_velocities", "continuous_collision",
                   "integrator", "iterations", "tolerance", "solref_time_constant_s", "solimp_least", "solimp_most", "autoreset"]}
TOLD = {"rapier": {"rolling_friction": "none: ", "reactions": "none: ", "forces": "once a step", "joint_forces": "once a step"},
        "jolt": {"rolling_friction": "none: ", "reactions": "not reported: ", "forces": "once a step", "joint_forces": "once a step"},
        "mujoco3": {"restitution": "none: ", "forces": "once a step", "joint_forces": "once a step"}}

# What the packages have before anything is set; of MuJoCo only its options, which all are in the table.
DEFAULTS = """
import { pathToFileURL } from "node:url";
const [packages, root, engine] = process.argv.slice(1);
const { loadPackage } = await import(pathToFileURL(`${root}/reference/node/packages.mjs`).href);
async function rapier() {
  const { module } = await loadPackage(packages, "@dimforge/rapier3d-compat");
  await module.init();
  const world = new module.World({ x: 0, y: 0, z: 0 }), own = world.integrationParameters;
  const body = world.createRigidBody(module.RigidBodyDesc.dynamic()), collider = world.createCollider(module.ColliderDesc.ball(1));
  return { solver_iterations: own.numSolverIterations, pgs_iterations: own.numInternalPgsIterations, length_unit_m: own.lengthUnit,
    allowed_linear_error: own.normalizedAllowedLinearError, prediction_distance: own.normalizedPredictionDistance,
    ccd_substeps: own.maxCcdSubsteps, ccd: body.isCcdEnabled(), soft_ccd_prediction_m: body.softCcdPrediction(),
    contact_skin_m: collider.contactSkin(), linear_damping: body.linearDamping(), angular_damping: body.angularDamping() };
}
async function jolt() {
  const { module } = await loadPackage(packages, "jolt-physics"), jolt = await module();
  const own = new jolt.PhysicsSettings(), body = new jolt.BodyCreationSettings(), degrees = (cosine) => (Math.acos(cosine) * 180) / Math.PI;
  return { velocity_steps: own.mNumVelocitySteps, position_steps: own.mNumPositionSteps, baumgarte: own.mBaumgarte,
    penetration_slop_m: own.mPenetrationSlop, speculative_contact_distance_m: own.mSpeculativeContactDistance,
    min_velocity_for_restitution_m_per_s: own.mMinVelocityForRestitution, manifold_tolerance_m: own.mManifoldTolerance,
    max_penetration_distance_m: own.mMaxPenetrationDistance, warm_start: own.mConstraintWarmStart,
    body_pair_cache: own.mUseBodyPairContactCache, manifold_reduction: own.mUseManifoldReduction, deterministic: own.mDeterministicSimulation,
    active_edges_only: own.mCheckActiveEdges, continuous_collision: body.mMotionQuality !== jolt.EMotionQuality_Discrete,
    enhanced_internal_edge_removal: body.mEnhancedInternalEdgeRemoval,
    caches: [Math.sqrt(own.mBodyPairCacheMaxDeltaPositionSq), 2 * degrees(own.mBodyPairCacheCosMaxDeltaRotationDiv2),
      Math.sqrt(own.mContactPointPreserveLambdaMaxDistSq), degrees(own.mContactNormalCosMaxDeltaRotation)] };
}
async function mujoco3() {
  const { module } = await loadPackage(packages, "@mujoco/mujoco"), mujoco = await module();
  const { opt } = mujoco.MjModel.from_xml_string("<mujoco/>");
  return { iterations: opt.iterations, tolerance: opt.tolerance, ls_iterations: opt.ls_iterations, ls_tolerance: opt.ls_tolerance,
    noslip_iterations: opt.noslip_iterations, noslip_tolerance: opt.noslip_tolerance, ccd_iterations: opt.ccd_iterations,
    ccd_tolerance: opt.ccd_tolerance, impratio: opt.impratio };
}
console.log(JSON.stringify(await { rapier, jolt, mujoco3 }[engine]()));
process.exit();
"""


def caught(run):
    """The outcome's reason; the run must have ended well."""
    if run.done["status"] != "ok":
        raise AssertionError(run.done)
    return run.done["reason"]


class Settings(unittest.TestCase):
    def hello(self, engine):
        worker = Worker(BIN_DIR, engine)
        self.addCleanup(worker.close)
        return worker.hello()

    def test_every_method_prints_what_decides_its_figures(self):
        for engine in ENGINES:
            hello = self.hello(engine)
            self.assertEqual(hello["scalar"], SCALAR[engine])
            for method in hello["methods"]:
                settings = method["settings"]
                self.assertEqual([name for name in COMMON + OWN[engine] if name not in settings], [], method["id"])
                self.assertEqual(settings["scalar"], SCALAR[engine])
                for name, part in TOLD[engine].items():
                    self.assertIn(part, settings[name], name)
                for name in ("linear_damping", "angular_damping"):
                    self.assertEqual(settings.get(name, settings.get(f"{name}_per_s")), 0)
                self.assertIn(settings["sleeping"], (False, "off, as by default"))
                self.assertIs(settings["gyroscopic"], True)

    def test_what_is_printed_is_what_the_loaded_package_has(self):
        for engine in ENGINES:
            printed = next(method for method in self.hello(engine)["methods"] if method["id"].endswith("/default"))["settings"]
            ended = subprocess.run([shutil.which("node"), "--input-type=module", "-e", DEFAULTS, f"{BIN_DIR}/../node", ROOT, engine],
                                   text=True, capture_output=True, timeout=60)
            self.assertEqual(ended.returncode, 0, ended.stderr)
            found = json.loads(ended.stdout)
            for wanted, has in zip((1e-3, 2, 1e-2, 5), found.pop("caches", ())):  # body_pair_cache_limits, contact_cache_limits
                self.assertAlmostEqual(has / wanted, 1, delta=1e-3)
            self.assertGreaterEqual(len(found), 9)
            for name, value in found.items():
                if isinstance(value, bool):
                    self.assertIs(printed[name], value, name)
                else:
                    self.assertAlmostEqual(printed[name], value, delta=1e-6 * abs(value), msg=name)

    def test_slow_approaches_bounce_as_is_printed(self):
        """Rapier: at any speed; Jolt: above min_velocity_for_restitution_m_per_s, which is 1."""
        for engine, speed, bounces in (("rapier", 1, 0.5), ("rapier", 1e-3, 0.5), ("jolt", 1.5, 0.5), ("jolt", 0.9, 0)):
            if engine in ENGINES:
                worker = Worker(BIN_DIR, engine)
                self.addCleanup(worker.close)
                of = scene(floor(), ball(position_m=[0, 0, 0.1 + 0.1 * speed], velocity_m_per_s=[0, 0, -speed]), laws=[law(restitution=0.5)])
                run = Run(worker, "default", of, 0.5, 240)
                self.assertAlmostEqual(run.body(1)["v"][2] / speed, bounces, delta=1e-5, msg=f"{engine} at {speed} m/s")

    @unittest.skipUnless("rapier" in ENGINES, "rapier is not built")
    def test_a_run_of_rapier_says_which_rule_gives_pairs_their_laws(self):
        worker = Worker(BIN_DIR, "rapier")
        self.addCleanup(worker.close)
        one = ball(position_m=[0, 0, 0.5])
        self.assertEqual(caught(Run(worker, "default", scene(one), 0.1, 24)), "")  # nothing to touch
        of = scene(floor(), one, laws=[law(restitution=0.5, friction=0.3)])
        self.assertEqual(caught(Run(worker, "default", of, 0.1, 24)), "laws of pairs: restitution by Rapier's rule Average, friction by Average")
        # a with a, b with b, a with b, and both with the floor: no rule combines these
        laws = [law(*pair, restitution=e) for *pair, e in (("a", "a", 0.8), ("b", "b", 0.3), ("a", "b", 0.1), ("f", "a", 0.2), ("f", "b", 0.9),
                                                          ("f", "f", 0))]
        balls = [ball(f"{name}{k}", material=name, position_m=[i, k, 0.5]) for i, name in enumerate("ab") for k in (0, 1)]
        found = caught(Run(worker, "default", scene(floor(material="f"), *balls, laws=laws), 0.1, 24))
        self.assertRegex(found, r"^laws of pairs by [2-5] layers of colliders$")

    @unittest.skipUnless(ENGINES and os.path.exists(f"{BIN_DIR}/atwood"), "atwood is not built")
    def test_the_rows_of_a_study_hold_them(self):
        engine = ENGINES[0]
        with tempfile.TemporaryDirectory() as out:
            ended = subprocess.run([f"{BIN_DIR}/atwood", "run", "--scenario", "bounce-e0", "--method", f"{engine}/default", "--steps", "120",
                                    "--no-timing", "--json", "--out", out], text=True, capture_output=True, cwd=ROOT, timeout=120)
        report = json.loads(ended.stdout)
        text = json.dumps(report["ran"]) + json.dumps(report["engines"])
        self.assertEqual([name for name in COMMON + OWN[engine] if f'"{name}"' not in text], [])


if __name__ == "__main__":
    if not ENGINES:
        print("none of the engines is built")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
