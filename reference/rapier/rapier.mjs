// What Rapier is at Atwood's table: its methods and refusals. Settings: settings.mjs; conventions: world.mjs.
import { describePackage, loadPackage } from "../node/packages.mjs";
import { length } from "../node/rotation.mjs";
import { lawsInPlay, shapesMatter } from "../node/scene.mjs";
import { refusedShape } from "./colliders.mjs";
import { refusedMechanism } from "./joints.mjs";
import { settings } from "./settings.mjs";
import { FASTEST, RapierWorld, contactLayers, overlaps } from "./world.mjs";

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
