// What MuJoCo 3 is at Atwood's table: its methods and refusals. Settings: settings.mjs.
import { describePackage, loadPackage } from "../node/packages.mjs";
import { hasShape, lawsInPlay, shapesMatter } from "../node/scene.mjs";
import { refusedMechanism } from "./mechanism.mjs";
import { MOST_LISTED_PAIRS, listedPairs, precedences } from "./pair_laws.mjs";
import { settings, stiff } from "./settings.mjs";
import { MujocoWorld, overlaps } from "./world.mjs";

const presets = [
  {
    scheme: "default",
    doc: "MuJoCo 3 with default options: semi-implicit Euler, soft contacts by a convex problem that Newton's " +
      "method solves, a friction pyramid. No restitution: scenes with restitution are refused.",
  },
  {
    scheme: "tuned",
    doc: "MuJoCo 3 with the settings that a recorded search found for the class of the scene.",
    byClass: true,
  },
  {
    scheme: "stiff",
    doc: "MuJoCo 3 with its Runge-Kutta method of order 4, the elliptic cone, friction a hundred times stiffer " +
      "than the normal (impratio), stiffer contacts and a tighter solver: those of mujoco/stiff.",
    changes: stiff,
  },
  {
    scheme: "rk4",
    doc: "MuJoCo 3 with its Runge-Kutta method of order 4, all else as in default. Forces that the adapter " +
      "evaluates stay constant over the step.",
    changes: { integrator: "RK4" },
  },
  {
    scheme: "implicit",
    doc: "MuJoCo 3 with its integrator that is implicit in velocity, all else as in default.",
    changes: { integrator: "implicit" },
  },
  {
    scheme: "implicitfast",
    doc: "The same without the derivatives of Coriolis and centripetal forces.",
    changes: { integrator: "implicitfast" },
  },
];

function refusedShape(body) {
  if (body.shape?.rectangle) return `MuJoCo has no rectangle shape (a box of zero thickness); found one on \`${body.name}\``;
  if (body.shape?.mesh) return `MuJoCo replaces a mesh by its convex hull; found the mesh \`${body.name}\``;
  return "";
}

/** Why MuJoCo cannot represent the scene, beyond the refusals of every adapter; empty when it can. */
export function refusal(scene) {
  const mechanism = refusedMechanism(scene);
  if (mechanism || !shapesMatter(scene)) return mechanism;
  if (lawsInPlay(scene).some((law) => law.restitution !== 0)) return "MuJoCo has no restitution: expected restitution = 0";
  for (const body of scene.bodies) if (refusedShape(body)) return refusedShape(body);
  if (precedences(scene)) return "";
  const pairs = listedPairs(scene.bodies.filter(hasShape));
  if (pairs > MOST_LISTED_PAIRS) return `MuJoCo would need an explicit list of the friction of ${pairs} pairs`;
  if (scene.bodies.some((body) => body.shape?.compound))
    return "MuJoCo's adapter does not list pairs of parts of a compound, and these materials have no order of priorities";
  return "";
}

/** The rival (node/rival.mjs); `packages`: the folder that has node_modules; `folder`: that of these sources. */
export function mujocoRival(packages, folder) {
  const { entry, version } = describePackage(packages, "@mujoco/mujoco");
  let mujoco;
  return {
    name: "mujoco3",
    version: `${version} (WebAssembly)`,
    scalar: "double",
    folder,
    files: [entry, entry.replace(/\.js$/, ".wasm")],
    joints: true,
    source: "MuJoCo documentation, https://mujoco.readthedocs.io; the package @mujoco/mujoco, in double",
    settings,
    presets,
    refusal,
    async prepare() {
      mujoco ??= await (await loadPackage(packages, "@mujoco/mujoco")).module({ print: console.error, printErr: console.error });
    },
    make: (scene, chosen) => new MujocoWorld(mujoco, scene, chosen),
    overlaps: (scene, chosen) => overlaps(mujoco, scene, chosen),
    emptyStep() {
      const model = mujoco.MjModel.from_xml_string("<mujoco/>"),
        data = new mujoco.MjData(model);
      const free = () => [data, model].forEach((each) => each.delete());
      return Object.assign(() => mujoco.mj_step(model, data), { free });
    },
  };
}
