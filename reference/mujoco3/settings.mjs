// Settings of the MuJoCo 3 rows, with MuJoCo's defaults (mj_defaultOption and the compiler's defaults for geoms), and what
// the preset `stiff` changes.
import { substepsSetting } from "../node/rival.mjs";

const said = (name, value) => ({ name, value, doc: "", printed: true });
const saidReal = (name, value, unit) => ({ ...said(name, value), real: true, unit });
const flag = (name, value, doc) => ({ name, value, doc });
const word = (name, value, choices, doc) => ({ name, value, choices, doc });
const count = (name, value, doc) => ({ name, value, least: name === "noslip_iterations" ? 0 : 1, most: 100000, doc });
const real = (name, value, [least, most], doc, unit = "") => ({ name, value, real: true, least, most, doc, unit });
const positive = (...all) => ({ ...real(...all), least_excluded: true });

export const settings = [
  substepsSetting,
  said("step", "mj_step"),
  said("pair_law", "the scene's: by geom priorities, or pair by pair where these can't say it"),
  said("restitution", "none: MuJoCo has no coefficient; scenes that ask for one are refused"),
  said("rolling_friction", "MuJoCo's: contacts of six rows (condim) where the pair has some"),
  said("spinning_friction", "MuJoCo's least, 1e-5, where rolling friction is asked for; else none"),
  said(
    "forces",
    "all but uniform gravity: evaluated by the adapter once a step, at its beginning, for RK4's stages too: the package has no mjcb_passive",
  ),
  said("sleeping", "off, as by default"),
  said("autoreset", "off: MuJoCo would restart a scene whose state is not finite"),
  saidReal("linear_damping", 0, "1/s"),
  saidReal("angular_damping", 0, "1/s"),
  said("gyroscopic", true),
  said("max_velocities", "none"),
  said("continuous_collision", false),
  said("plane", "MuJoCo's plane, of the world's body"),
  said("contact_forces", "normal and friction forces of each contact, of the step that ends at the sample"),
  said("threads", 1),
  word("integrator", "Euler", ["Euler", "RK4", "implicit", "implicitfast", "discrete"], "Integrator of a step."),
  flag("eulerdamp", true, "Euler is implicit in the damping of joints."),
  word("solver", "Newton", ["PGS", "CG", "Newton"], "Solver of the convex contact problem."),
  count("iterations", 100, "Most iterations of the solver."),
  real("tolerance", 1e-8, [0, 1], "Improvement, scaled by MuJoCo, at which the solver ends."),
  count("ls_iterations", 50, "Most iterations of its line search."),
  real("ls_tolerance", 0.01, [0, 1], "Gradient, over the start's, at which the line search ends."),
  count("noslip_iterations", 0, "Iterations of the no-slip solver after it."),
  real("noslip_tolerance", 1e-6, [0, 1], "Improvement at which the no-slip solver ends."),
  word("cone", "pyramidal", ["pyramidal", "elliptic"], "Model of the friction cone."),
  positive("impratio", 1, [0, 1e6], "Stiffness of friction over that of normal forces."),
  word("jacobian", "auto", ["dense", "sparse", "auto"], "Storage of the contact Jacobian."),
  flag("warm_start", true, "The solver starts from the last step's accelerations."),
  flag("islands", true, "Groups of touching bodies are solved apart, where the solver can."),
  flag("refsafe", true, "The contact's time constant is at least two steps."),
  flag("nativeccd", true, "MuJoCo's own convex collision; off: libccd."),
  flag("multiccd", true, "Several contact points of a convex pair."),
  count("ccd_iterations", 35, "Most iterations of convex collision."),
  real("ccd_tolerance", 1e-6, [0, 1], "Tolerance of convex collision."),
  positive("solref_time_constant_s", 0.02, [0, 1000], "Time constant of a contact (solref).", "s"),
  positive("solref_damping_ratio", 1, [0, 1000], "Damping over critical damping of a contact (solref)."),
  real("solimp_least", 0.9, [0, 1], "Impedance at no overlap (solimp)."),
  real("solimp_most", 0.95, [0, 1], "Impedance at overlaps beyond the width (solimp)."),
  real("solimp_width_m", 0.001, [0, 1000], "Overlap over which the impedance rises (solimp).", "m"),
  real("solimp_midpoint", 0.5, [0, 1], "Where it rises steepest, over the width (solimp)."),
  real("solimp_power", 2, [1, 1000], "Power of its rise (solimp)."),
  real("margin_m", 0, [0, 1000], "Gap up to which a contact is detected.", "m"),
  real("gap_m", 0, [0, 1000], "Part of the margin in which a contact has no force.", "m"),
  said("joints", "the tree of bodies; closing joints are equality constraints, softened by joint_sol*"),
  said("joint_forces", "springs and dampers are MuJoCo's; motors by the adapter once a step: the package has no callbacks"),
  said("stops", "limits of MuJoCo's joints, soft, without restitution"),
  said("reactions", "from the masses' accelerations and all other forces on them (Newton and Euler)"),
  real("mechanism_tolerance", 1e-8, [0, 1], "The solver's tolerance in scenes with joints or ropes."),
  positive("joint_solref_time_constant_s", 0.02, [0, 1000], "Time constant of closing joints, ropes, stops (solref).", "s"),
  real("joint_solref_time_constant_steps", 0, [0, 1000], "The same as a number of steps; 0: as in seconds."),
  positive("joint_solref_damping_ratio", 1, [0, 1000], "Their damping over critical damping (solref)."),
  real("joint_solimp_least", 0.9, [0, 1], "Their impedance without violation (solimp)."),
  real("joint_solimp_most", 0.95, [0, 1], "Their impedance at violations beyond solimp_width_m (solimp)."),
];

// Those of MuJoCo 2.2.2's preset of that name.
export const stiff = {
  integrator: "RK4",
  cone: "elliptic",
  impratio: 100,
  tolerance: 1e-10,
  solref_time_constant_s: 0.01,
  solimp_least: 0.99,
  solimp_most: 0.999,
  mechanism_tolerance: 0,
  joint_solref_time_constant_steps: 2,
  joint_solimp_least: 0.9999,
  joint_solimp_most: 0.9999,
};
