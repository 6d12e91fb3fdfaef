// Settings of the Rapier rows, with Rapier's defaults except for sleeping; those that JavaScript can't set are printed.
import { substepsSetting } from "../node/rival.mjs";
import { FASTEST, LARGEST_TURN_RAD } from "./world.mjs";

const said = (name, value, doc) => ({ name, value, doc, printed: true });
const saidReal = (name, value, doc, unit = "") => ({ name, value, doc, unit, real: true, printed: true });
const flag = (name, value, doc) => ({ name, value, doc });
const count = (name, value, [least, most], doc) => ({ name, value, least, most, doc });
const real = (name, value, most, doc, unit = "") => ({ name, value, real: true, least: 0, most, doc, unit });
const positive = (...all) => ({ ...real(...all), least_excluded: true });

const how = [
  said("step", "World.step(), symplectic Euler in solver_iterations substeps", "How a step is made."),
  said("solver", "projected Gauss-Seidel on soft constraints", "How contacts and joints are solved."),
  said("warm_start", "Rapier's", "Of the solver; not to be set or read from JavaScript."),
  said(
    "pair_law",
    "the scene's: coefficients of colliders under the mean, the larger, the smaller or the product, else several colliders " +
      "a body in collision groups; a run's outcome says which",
    "Restitution and friction of each pair.",
  ),
  said("restitution", "added after friction, at any speed of approach", "How a bounce is made."),
  said("rolling_friction", "none: Rapier has no coefficient; scenes that ask for one are refused", "Resistance to rolling."),
  said("spinning_friction", "the twist of friction_model: no coefficient of its own", "Against turns about the normal."),
  said("friction_model", "simplified", "Two directions and a twist of each manifold; not to be set from JavaScript."),
  said("forces", "all but uniform gravity: evaluated by the adapter once a step, at its beginning", "How forces act."),
  said("gyroscopic", true, "The term w x I w acts, in float."),
  saidReal("linear_damping", 0, "dv/dt = -c v, Rapier's default.", "1/s"),
  saidReal("angular_damping", 0, "dw/dt = -c w, Rapier's default.", "1/s"),
  saidReal("max_linear_speed", FASTEST, "No body is faster, in length units a second."),
  saidReal("max_turn_rad", LARGEST_TURN_RAD, "No body turns further in a step.", "rad"),
  said("plane", "a half-space", "Shape of a plane."),
  said("rectangle", "two triangles, of a fixed body", "Shape of a rectangle."),
  said("threads", 1, "Threads of a step."),
];

const told = [
  said(
    "contact_forces",
    "normal impulses; those of friction cannot be read, and are not a number where a pair has friction",
    "What is told of contacts.",
  ),
  said(
    "joints",
    "impulse joints: revolute (hinge), prismatic (slider), generic with locked axes (fixed, cylindrical, ball); jointed " +
      "bodies do not collide; softness is Rapier's and cannot be set or read",
    "How joints are made.",
  ),
  said("stops", "limits of the joint, without restitution", "Stops of hinges and sliders."),
  said(
    "joint_forces",
    "springs, dampers and motors: evaluated by the adapter once a step, explicitly: a damper is unstable beyond c h = 2 I",
    "How forces of joints act.",
  ),
  said("reactions", "none: impulses of joints cannot be read", "What is told of joints' reactions."),
];

export const settings = [
  substepsSetting,
  ...how,
  {
    name: "build",
    value: "standard",
    choices: ["standard", "deterministic"],
    doc: "rapier3d-compat, or rapier3d-deterministic-compat with bits that do not depend on the platform.",
  },
  count("solver_iterations", 4, [1, 1000], "Substeps that the solver makes of a step: constraints, integration."),
  count("pgs_iterations", 1, [1, 1000], "Sweeps of projected Gauss-Seidel over the constraints in each of them."),
  positive("contact_natural_frequency_Hz", 30, 1e6, "Of the spring that an overlap is corrected by.", "Hz"),
  saidReal("contact_damping_ratio", 10, "Of that spring; not to be set from JavaScript."),
  real("allowed_linear_error", 0.005, 1e3, "Overlap that is left uncorrected, in length units."),
  real("prediction_distance", 0.02, 1e3, "Gap below which contacts are solved ahead of the touch, in length units."),
  positive("length_unit_m", 1, 1e9, "The size of an object that is neither small nor large.", "m"),
  real("contact_skin_m", 0, 1e3, "A margin around every shape that counts as contact.", "m"),
  flag("ccd", false, "Continuous collision detection: fast bodies are stopped at their first touch."),
  count("ccd_substeps", 1, [0, 1000], "Most substeps of it; 0 turns all of it off."),
  real("soft_ccd_prediction_m", 0, 1e6, "How far ahead contacts of fast bodies are predicted.", "m"),
  flag("smooth_inner_edges", false, "Normals at inner edges of meshes are those of the faces."),
  flag("sleeping", false, "Bodies at rest are put to sleep; Rapier's own default is true."),
  ...told,
];
