// What Rapier is at Atwood's table: its methods, settings and refusals.
import { substepsSetting } from "../node/rival.mjs";
import { shapesMatter } from "../node/scene.mjs";
import { RapierWorld } from "./world.mjs";

const settings = [
  substepsSetting,
  { name: "sleeping", value: false, doc: "Bodies at rest are put to sleep. Rapier's own default is true." },
];

/** The rival (node/rival.mjs) of a loaded package (node/packages.mjs); `folder`: that of these sources. */
export function rapierRival({ module: rapier, version, entry }, folder) {
  return {
    name: "rapier", version, scalar: "float", folder, files: [entry],
    source: "Rapier 0.21 for JavaScript, https://rapier.rs; the build @dimforge/rapier3d-compat, in float",
    settings,
    presets: [{ scheme: "default", doc: "Rapier's rigid bodies with the library's default settings. Only sleeping is off." }],
    refusal: (scene) => (shapesMatter(scene) ? "rapier's adapter takes no contacts yet" : ""),
    make: (scene, chosen) => new RapierWorld(rapier, scene, chosen),
    emptyStep() {
      const world = new rapier.World({ x: 0, y: 0, z: 0 });
      return () => world.step();
    },
  };
}
