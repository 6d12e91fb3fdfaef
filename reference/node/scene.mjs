// The resolved scene of a request, with indices in place of names, and what every adapter refuses.
import { uncoveredForce } from "./forces.mjs";
import { isZero } from "./rotation.mjs";

/** How a run ends that an engine cannot do: the reason, in words. */
export class Refusal extends Error {}

export const rotates = (body) => !isZero(body.inertia_kg_m2);
export const hasShape = (body) => Object.keys(body.shape ?? {}).length > 0;
export const shapeName = (body) => Object.keys(body.shape ?? { none: {} })[0];

/**
 * The request's scene with `indexOf(name)`; forces have the indices of their bodies, joints those of parent and child (-1: the
 * world).
 */
export function readScene(json) {
  const index = new Map(json.bodies.map((body, i) => [body.name, i]));
  const indexOf = (name) => (name === "world" ? -1 : index.get(name));
  const material = new Map(json.materials.map((each, i) => [each.name, i]));
  const laws = new Map();
  for (const law of json.pairs) {
    const [a, b] = law.between.map((name) => material.get(name));
    laws.set(`${a} ${b}`, law).set(`${b} ${a}`, law);
  }
  const materials = json.bodies.map((body) => material.get(body.material) ?? 0);
  const jointIndex = new Map((json.joints ?? []).map((joint, j) => [joint.name, j]));
  return {
    ...json,
    forces: json.forces ?? [],
    joints: (json.joints ?? []).map((joint) => ({
      ...joint,
      parent: indexOf(joint.bodies[0]),
      child: indexOf(joint.bodies[1]),
    })),
    ropes: (json.ropes ?? []).map((rope) => ({ ...rope, bodies: rope.bodies.map(indexOf), over_m: rope.over_m ?? [] })),
    jointForces: (json.joint_forces ?? []).map((force) => ({ ...force, joint: jointIndex.get(force.joint) })),
    indexOf,
    forcesByIndex: (json.forces ?? []).map((force) => ({
      force,
      indices: (force.bodies ?? (force.body ? [force.body] : [])).map(indexOf),
    })),
    /** The law of two bodies: restitution, friction, rolling_friction_m. */
    pairLaw: (a, b) => laws.get(`${materials[a]} ${materials[b]}`),
  };
}

/** Whether shapes have an effect: two bodies have one, and at least one of them is mobile. */
export function shapesMatter(scene) {
  const shaped = scene.bodies.filter(hasShape);
  return shaped.length > 1 && shaped.some((body) => !body.fixed);
}

/** Pairs [i, j, law] of materials, i <= j, that two bodies with shapes have, at least one of them not fixed. */
export function pairsInPlay(scene) {
  const index = new Map(scene.materials.map((each, i) => [each.name, i])),
    pairs = new Map();
  const kinds = Array.from({ length: Math.max(1, index.size) }, () => ({ fixed: [], mobile: [] }));
  scene.bodies.forEach((body, i) => {
    if (hasShape(body)) kinds[index.get(body.material) ?? 0][body.fixed ? "fixed" : "mobile"].push(i);
  });
  kinds.forEach((one, a) =>
    kinds.forEach((other, b) => {
      const second = a === b ? (one.mobile[1] ?? one.fixed[0]) : (other.mobile[0] ?? other.fixed[0]);
      if (one.mobile.length === 0 || second === undefined) return;
      const [i, j] = [Math.min(a, b), Math.max(a, b)];
      pairs.set(`${i} ${j}`, [i, j, scene.pairLaw(one.mobile[0], second)]);
    }),
  );
  return [...pairs.values()];
}

/** The laws of these pairs. */
export const lawsInPlay = (scene) => [...new Set(pairsInPlay(scene).map(([, , law]) => law))];

/** Throws the Refusals of every adapter. `engine` is its name, `scalar` its precision. */
export function refuseScene(engine, scalar, scene) {
  if (scene.problem)
    throw new Refusal(`${engine} simulates bodies and cannot integrate the bare equations \`${scene.problem}\``);
  if (scene.fluids?.length) throw new Refusal(`${engine} simulates no fluids`);
  if (scalar === "float") refuseBeyondFloat(engine, scene);
  const force = uncoveredForce(scene);
  if (force) throw new Refusal(`${engine}'s adapter has ${force}`);
  const matter = shapesMatter(scene);
  for (const body of scene.bodies) {
    const moves = !isZero(body.velocity_m_per_s) || !isZero(body.angular_velocity_body_rad_per_s);
    if (body.fixed && moves)
      throw new Refusal(`${engine}'s adapter has no prescribed motion of fixed bodies; \`${body.name}\` moves`);
    if (body.fixed) continue;
    if (!(body.mass_kg > 0)) throw new Refusal(`${engine} requires a mass of mobile bodies; \`${body.name}\` has none`);
    if (matter && body.shape?.plane) throw new Refusal(`${engine} has fixed planes only; \`${body.name}\` is mobile`);
  }
  if (scene.simultaneous_impacts === "together" && impactsMayCoincide(scene))
    throw new Refusal(
      `${engine} does not solve all impacts of one instant as one problem: the scene's simultaneous_impacts is together`,
    );
  if (lawsInPlay(scene).some((law) => law.contact_law && law.contact_law !== "rigid"))
    throw new Refusal(`${engine}'s adapter has no compliant contact laws (contact_law)`);
}

/** Whether two pairs of bodies with rigid contact laws may have impacts at one instant. */
const impactsMayCoincide = (scene) =>
  shapesMatter(scene) &&
  lawsInPlay(scene).some((law) => !law.contact_law || law.contact_law === "rigid") &&
  scene.bodies.filter(hasShape).length > 2;

/** What the cell of an engine states that has its own order for impacts of one instant; "": nothing. */
export const conventionNote = (engine, scene) =>
  scene.simultaneous_impacts === "sequential" && impactsMayCoincide(scene)
    ? `${engine} has its own order for impacts of one instant: the scene's simultaneous_impacts = sequential is not followed`
    : "";

function numbersIn(value) {
  if (typeof value === "number") return [value];
  return value && typeof value === "object" ? Object.values(value).flatMap(numbersIn) : [];
}

/** Throws a Refusal where a float has no room for a body's shape, mass or inertia: it would be infinite or nothing. */
function refuseBeyondFloat(engine, scene) {
  const beyond = (x) => x !== 0 && (Math.fround(x) === 0 || !Number.isFinite(Math.fround(x)));
  for (const { name, shape, mass_kg, inertia_kg_m2 } of scene.bodies) {
    const found = numbersIn([shape, mass_kg, inertia_kg_m2]).find(beyond);
    if (found !== undefined)
      throw new Refusal(`${engine} computes in float, which has no room for ${found}: shape, mass or inertia of \`${name}\``);
  }
}
