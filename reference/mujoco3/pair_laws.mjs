// Laws of pairs from MuJoCo's coefficients of geoms. The geom of higher priority decides a contact's friction. One priority
// and one law per material are therefore sufficient when the materials have an order in which each has the same law with all
// lower ones (and with itself, where two such bodies can touch).
import { lawsInPlay } from "../node/scene.mjs";

const same = (a, b) => a.friction === b.friction && a.rolling_friction_m === b.rolling_friction_m;

/** {priority, friction, rolling_friction_m} by the name of a material; null where no such order exists. */
export function precedences(scene) {
  let left = lawsInPlay(scene);
  const all = new Map();
  // From the highest priority: a material with the same law for all remaining ones determines these laws and is removed.
  for (let priority = scene.materials.length; left.length > 0; --priority) {
    const decided = scene.materials
      .map(({ name }) => name)
      .find((name) => {
        const its = left.filter((law) => law.between.includes(name));
        return its.length > 0 && its.every((law) => same(law, its[0]));
      });
    if (decided === undefined) return null;
    const { friction, rolling_friction_m } = left.find((law) => law.between.includes(decided));
    all.set(decided, { priority, friction, rolling_friction_m });
    left = left.filter((law) => !law.between.includes(decided));
  }
  return all;
}

/** Number of pairs of bodies that can touch: the length of an explicit list. */
export function listedPairs(bodies) {
  const fixed = bodies.filter((body) => body.fixed).length,
    moving = bodies.length - fixed;
  return (moving * (moving - 1)) / 2 + moving * fixed;
}
export const MOST_LISTED_PAIRS = 5000;
