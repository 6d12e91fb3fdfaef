// What Jolt is at Atwood's table: its methods and refusals. Settings: settings.mjs.
import { describePackage, loadPackage } from "../node/packages.mjs";
import { length } from "../node/rotation.mjs";
import { lawsInPlay, shapesMatter } from "../node/scene.mjs";
import { overlaps } from "./contacts.mjs";
import { refusedMechanism } from "./joints.mjs";
import { settings } from "./settings.mjs";
import { refusedShape } from "./shapes.mjs";
import { JoltWorld, makeInterface } from "./world.mjs";

const presets = [
  {
    scheme: "default",
    doc: "Jolt with the library's default settings, but with the scene's physics: no damping, no limits of velocity, " +
      "the gyroscopic term, no sleeping.",
  },
  { scheme: "tuned", doc: "Jolt with the settings that a recorded search found for the class of the scene.", byClass: true },
];

/** A start that Jolt would cut to its largest velocities. */
function refusedStart(body, settings) {
  const [v, w] = [body.velocity_m_per_s, body.angular_velocity_body_rad_per_s].map(length);
  const { max_linear_velocity_m_per_s: most, max_angular_velocity_rad_per_s: mostRate } = settings;
  if (!(v <= most)) return `Jolt moves no body faster than ${most} m/s (max_linear_velocity_m_per_s): \`${body.name}\``;
  if (!(w <= mostRate)) return `Jolt turns no body faster than ${mostRate} rad/s (max_angular_velocity_rad_per_s): \`${body.name}\``;
  return "";
}

/** Why Jolt cannot represent the scene, beyond the refusals of every adapter; empty when it can. */
export function refusal(scene, settings) {
  for (const body of scene.bodies) if (refusedStart(body, settings)) return refusedStart(body, settings);
  const mechanism = refusedMechanism(scene);
  if (mechanism || !shapesMatter(scene)) return mechanism;
  for (const body of scene.bodies) if (refusedShape(body)) return refusedShape(body);
  if (lawsInPlay(scene).some((law) => law.rolling_friction_m > 0))
    return "Jolt has no rolling friction: expected rolling_friction_m = 0";
  return "";
}

/** The rival (node/rival.mjs); `packages`: the folder that has node_modules; `folder`: that of these sources. */
export function joltRival(packages, folder) {
  const { entry, version } = describePackage(packages, "jolt-physics");
  let jolt;
  return {
    name: "jolt",
    version: `${version} (WebAssembly)`,
    scalar: "float",
    folder,
    files: [entry],
    joints: true,
    source: "Jolt Physics, https://jrouwe.github.io/JoltPhysics; the package jolt-physics, in float (it has no double build)",
    settings,
    presets,
    refusal,
    async prepare() {
      jolt ??= await (await loadPackage(packages, "jolt-physics")).module({ print: console.error, printErr: console.error });
    },
    make: (scene, chosen, observe) => new JoltWorld(jolt, scene, chosen, observe),
    overlaps: (scene, chosen) => overlaps(jolt, scene, chosen),
    emptyStep() {
      const empty = makeInterface(jolt, 0);
      return Object.assign(() => empty.Step(1 / 240, 1), { free: () => jolt.destroy(empty) });
    },
  };
}
