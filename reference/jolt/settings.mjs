// Settings of the Jolt rows, with Jolt's defaults (PhysicsSettings, BodyCreationSettings) except where the scene's physics
// says otherwise: no damping, no limits of velocity, the gyroscopic term, no sleeping.
import { substepsSetting } from "../node/rival.mjs";

const said = (name, value) => ({ name, value, doc: "", printed: true });
const flag = (name, value, doc) => ({ name, value, doc });
const count = (name, value, [least, most], doc) => ({ name, value, least, most, doc });
const real = (name, value, [least, most], doc, unit = "") => ({ name, value, real: true, least, most, doc, unit });

export const settings = [
  substepsSetting,
  said("step", "JoltInterface.Step(h, 1), semi-implicit Euler"),
  said("solver", "sequential impulses, then position corrections"),
  said("pair_law", "the scene's: of the bodies where there is one law, else by a contact listener"),
  said("forces", "all but uniform gravity: evaluated by the adapter once a step, at its beginning"),
  said("restitution", "Jolt's: of approaches above min_velocity_for_restitution_m_per_s"),
  said("friction_model", "two directions at each contact point, cut together at mu times the normal impulse: a circle"),
  said("spinning_friction", "none: friction of several points alone resists turning about the normal"),
  said("rolling_friction", "none: Jolt has no coefficient; scenes that ask for one are refused"),
  said("continuous_collision", false),
  said("rectangle", "two triangles, of a fixed body"),
  said("plane", "a square of 20 km about its point nearest the origin"),
  said(
    "contact_forces",
    "Jolt does not tell them: from the change of momentum where each contact has a body with no other; else none",
  ),
  said(
    "joints",
    "FixedConstraint, Hinge, Slider, Point (ball), SixDOF (cylindrical, universal); jointed bodies do not collide",
  ),
  said("stops", "limits of the constraint, without restitution"),
  said(
    "joint_forces",
    "springs, dampers and motors: evaluated by the adapter once a step, explicitly: a damper is unstable beyond c h = 2 I",
  ),
  said("driven_joints", "the constraint's motor with an unbounded force"),
  said("reactions", "not reported: Jolt gives the impulse of each constraint row only"),
  said("threads", 1),
  said("deterministic", true),
  said("active_edges_only", true),
  said("body_pair_cache_limits", "of pairs that move by up to 1 mm and turn by up to 2 degrees"),
  said("contact_cache_limits", "impulses of points that move by up to 1 cm, along normals that turn by up to 5 degrees"),
  count("velocity_steps", 10, [2, 1000], "Sweeps of the velocity solver in a step (mNumVelocitySteps)."),
  count("position_steps", 2, [0, 1000], "Sweeps of the position solver in a step (mNumPositionSteps)."),
  real("baumgarte", 0.2, [0, 1], "Share of an overlap that a position sweep takes away (mBaumgarte)."),
  real("penetration_slop_m", 0.02, [0, 1000], "Overlap that is left alone (mPenetrationSlop).", "m"),
  real("speculative_contact_distance_m", 0.02, [0, 1000], "Gap up to which a contact enters the solver.", "m"),
  real("min_velocity_for_restitution_m_per_s", 1, [0, 1e6], "Approaches slower than this do not bounce.", "m/s"),
  real("manifold_tolerance_m", 1e-3, [0, 1000], "Distance up to which contact points are one manifold's.", "m"),
  real("max_penetration_distance_m", 0.2, [0, 1000], "Most overlap that a step corrects.", "m"),
  real(
    "convex_radius_m",
    0.05,
    [0, 1000],
    "Rounding of edges: of boxes and cylinders at most a tenth of the smallest half extent, of hulls of the farthest point's distance.",
    "m",
  ),
  flag("warm_start", true, "The sweeps start from the last step's impulses."),
  flag("body_pair_cache", true, "Contacts of pairs that hardly moved are taken from the last step."),
  flag("manifold_reduction", true, "Manifolds of like normals of a pair become one."),
  flag("enhanced_internal_edge_removal", false, "Contacts at the inner edges of a mesh get its faces' normals. For each body."),
  flag("gyroscopic", true, "mApplyGyroscopicForce: without it a body keeps its angular velocity. Jolt's own default is false."),
  real("linear_damping_per_s", 0, [0, 1000], "dv/dt = -c v. Jolt's own default is 0.05.", "1/s"),
  real("angular_damping_per_s", 0, [0, 1000], "dw/dt = -c w. Jolt's own default is 0.05.", "1/s"),
  real("max_linear_velocity_m_per_s", 1e9, [0, 1e15], "Speeds are cut to it. Jolt's own default is 500.", "m/s"),
  real("max_angular_velocity_rad_per_s", 1e9, [0, 1e15], "Rates are cut to it. Jolt's own default is 47.1.", "rad/s"),
  flag("sleeping", false, "Slow bodies are put to sleep. Jolt's own default is true."),
];
