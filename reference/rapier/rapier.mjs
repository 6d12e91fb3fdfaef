// What Rapier is at Atwood's table: its methods, settings and refusals. Conventions: world.mjs.
import { describePackage, loadPackage } from "../node/packages.mjs";
import { substepsSetting } from "../node/rival.mjs";
import { length } from "../node/rotation.mjs";
import { lawsInPlay, shapesMatter } from "../node/scene.mjs";
import { refusedShape } from "./colliders.mjs";
import { refusedMechanism } from "./joints.mjs";
import { FASTEST, LARGEST_TURN_RAD, RapierWorld, contactLayers, overlaps } from "./world.mjs";

const settings = [
  substepsSetting,
  {
    name: "build",
    value: "standard",
    choices: ["standard", "deterministic"],
    doc: "rapier3d-compat, or rapier3d-deterministic-compat with bits that do not depend on the platform.",
  },
  {
    name: "solver_iterations",
    value: 4,
    least: 1,
    most: 1000,
    doc: "Substeps that the solver makes of a step: constraints, integration.",
  },
  {
    name: "pgs_iterations",
    value: 1,
    least: 1,
    most: 1000,
    doc: "Sweeps of projected Gauss-Seidel over the constraints in each of them.",
  },
  {
    name: "contact_natural_frequency_Hz",
    value: 30,
    real: true,
    least: 0,
    least_excluded: true,
    most: 1e6,
    unit: "Hz",
    doc: "Of the spring that an overlap is corrected by.",
  },
  {
    name: "contact_damping_ratio",
    value: 10,
    real: true,
    printed: true,
    doc: "Of that spring; not to be set from JavaScript.",
  },
  {
    name: "allowed_linear_error",
    value: 0.005,
    real: true,
    least: 0,
    most: 1e3,
    doc: "Overlap that is left uncorrected, in length units.",
  },
  {
    name: "prediction_distance",
    value: 0.02,
    real: true,
    least: 0,
    most: 1e3,
    doc: "Gap below which contacts are solved ahead of the touch, in length units.",
  },
  {
    name: "length_unit_m",
    value: 1,
    real: true,
    least: 0,
    least_excluded: true,
    most: 1e9,
    unit: "m",
    doc: "The size of an object that is neither small nor large.",
  },
  {
    name: "contact_skin_m",
    value: 0,
    real: true,
    least: 0,
    most: 1e3,
    unit: "m",
    doc: "A margin around every shape that counts as contact.",
  },
  { name: "ccd", value: false, doc: "Continuous collision detection: fast bodies are stopped at their first touch." },
  { name: "ccd_substeps", value: 1, least: 0, most: 1000, doc: "Most substeps of it; 0 turns all of it off." },
  {
    name: "soft_ccd_prediction_m",
    value: 0,
    real: true,
    least: 0,
    most: 1e6,
    unit: "m",
    doc: "How far ahead contacts of fast bodies are predicted.",
  },
  { name: "smooth_inner_edges", value: false, doc: "Normals at inner edges of meshes are those of the faces." },
  { name: "sleeping", value: false, doc: "Bodies at rest are put to sleep; Rapier's own default is true." },
  {
    name: "friction_model",
    value: "simplified",
    printed: true,
    doc: "Two directions and a twist of each manifold; not to be set from JavaScript.",
  },
  { name: "gyroscopic", value: true, printed: true, doc: "The term w x I w acts, in float." },
  {
    name: "max_linear_speed",
    value: FASTEST,
    real: true,
    printed: true,
    doc: "No body is faster, in length units a second.",
  },
  {
    name: "max_turn_rad",
    value: LARGEST_TURN_RAD,
    real: true,
    printed: true,
    unit: "rad",
    doc: "No body turns further in a step.",
  },
];

/** Why Rapier cannot represent a scene; empty: it can. */
function refusal(scene, chosen) {
  const fastest = FASTEST * chosen.length_unit_m,
    fast = scene.bodies.find((body) => !body.fixed && length(body.velocity_m_per_s) > fastest);
  if (fast) return `rapier moves no body faster than ${fastest} m/s (400 length units a second): \`${fast.name}\``;
  const mechanism = refusedMechanism(scene);
  if (mechanism || !shapesMatter(scene)) return mechanism;
  const shape = scene.bodies.map(refusedShape).find(Boolean);
  if (shape) return shape;
  if (lawsInPlay(scene).some((law) => law.rolling_friction_m > 0)) return "rapier has no rolling friction";
  return contactLayers(scene)
    ? ""
    : "rapier combines the coefficients of two materials: its rules and 16 collision groups do not give each pair its law " +
        "(of 32 materials at most)";
}

/** The rival (node/rival.mjs): `names` of packages by build, under `packages`; `folder`: that of these sources. */
export function rapierRival(packages, names, folder) {
  const loaded = {},
    described = Object.values(names).map((name) => describePackage(packages, name));
  const module = (chosen) => loaded[chosen.build];
  return {
    name: "rapier",
    version: `${described[0].version} (WebAssembly)`,
    scalar: "float",
    folder,
    files: described.map(({ entry }) => entry),
    async prepare({ build }) {
      if (loaded[build]) return;
      const { module: rapier } = await loadPackage(packages, names[build]);
      await rapier.init();
      loaded[build] = rapier;
    },
    source:
      "Rapier for JavaScript, https://rapier.rs: @dimforge/rapier3d-compat and rapier3d-deterministic-compat, both in float",
    settings,
    joints: true,
    presets: [
      {
        scheme: "default",
        doc:
          "Rapier's rigid bodies with the library's default settings: symplectic Euler in four substeps a step, " +
          "soft contacts solved ahead of the touch. Only sleeping is off, and pairs have the contact law of the scene.",
      },
      {
        scheme: "tuned",
        doc: "Rapier with the settings that a recorded search found for the class of the scene.",
        byClass: true,
      },
      {
        scheme: "deterministic",
        doc: "The same from the package whose results do not depend on the platform.",
        changes: { build: "deterministic" },
      },
    ],
    refusal,
    make: (scene, chosen, observe) => new RapierWorld(module(chosen), scene, chosen, observe),
    overlaps: (scene, chosen) => overlaps(module(chosen), scene, chosen),
    emptyStep(chosen) {
      const world = new (module(chosen).World)({ x: 0, y: 0, z: 0 });
      return Object.assign(() => world.step(), { free: () => world.free() });
    },
  };
}
