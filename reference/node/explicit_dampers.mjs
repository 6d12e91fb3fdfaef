// Dampers that an adapter evaluates once a step, at its start: c u acts on a rate u with the inertia I for the whole step h,
// so that u becomes (1 - c h / I) u, which grows beyond c h = 2 I. A load is six numbers a body: force and torque.
import { constraintPart, effortWrenches, motionAtStart, passiveForce, placeOf } from "./joints.mjs";
import { cross, length, minus, plus, principalAxes, product, scaled, toBody, toWorld } from "./rotation.mjs";
import { rotates } from "./scene.mjs";

const RATES = { fixed: 0, hinge: 1, slider: 1, cylindrical: 2, universal: 2, ball: 3 };
const AXES = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const nothing = (scene) => scene.bodies.map(() => ({ force_N: [0, 0, 0], torque_N_m: [0, 0, 0] }));
const flat = (wrenches) => Float64Array.from(wrenches.flatMap(({ force_N, torque_N_m }) => [...force_N, ...torque_N_m]));
const powerOf = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);

/** The accelerations of free bodies under a load. */
function accelerator(scene, motions) {
  const axes = scene.bodies.map((body) => (!body.fixed && rotates(body) ? principalAxes(body.inertia_kg_m2) : null));
  return (load) => {
    const all = new Float64Array(load.length);
    scene.bodies.forEach((body, i) => {
      if (body.fixed) return;
      for (let k = 0; k < 3; ++k) all[6 * i + k] = load[6 * i + k] / body.mass_kg;
      if (!axes[i]) return;
      const q_WP = product(motions[i].q_WB, axes[i].q_BP),
        torque = toBody(q_WP, Array.from(load.subarray(6 * i + 3, 6 * i + 6)));
      all.set(
        toWorld(
          q_WP,
          torque.map((x, k) => x / axes[i].moments_kg_m2[k]),
        ),
        6 * i + 3,
      );
    });
    return all;
  };
}

/**
 * A function that takes from a load the reactions to it. They are orthonormal, a^T M^-1 b, by Gram and Schmidt's process:
 * M^-1 P is the projection onto what joints admit.
 */
function reactionRemover(scene, motions, accelerations) {
  const reactions = [];
  const without = (load) => {
    const left = Float64Array.from(load);
    for (const [reaction, acceleration] of reactions) {
      const share = powerOf(acceleration, left);
      reaction.forEach((x, k) => (left[k] -= share * x));
    }
    return left;
  };
  for (const joint of scene.joints) {
    const of = (i) => (i < 0 ? motionAtStart(scene, -1) : motions[i]),
      place = placeOf(joint, of(joint.parent), of(joint.child));
    for (let k = 0; k < 6; ++k) {
      const unit = { force_N: k < 3 ? AXES[k] : [0, 0, 0], torque_N_m: k < 3 ? [0, 0, 0] : AXES[k - 3] };
      const { force_N, torque_N_m } = constraintPart(joint, place, unit),
        wrenches = nothing(scene);
      for (const [body, sign] of [
        [joint.child, 1],
        [joint.parent, -1],
      ])
        if (body >= 0)
          wrenches[body] = {
            force_N: scaled(sign, force_N),
            torque_N_m: scaled(sign, plus(torque_N_m, cross(minus(place.childAnchor, of(body).p_WB), force_N))),
          };
      const load = flat(wrenches),
        left = without(without(load)), // twice is enough (Kahan, Parlett)
        acceleration = accelerations(left),
        squared = powerOf(left, acceleration);
      if (!(squared > 1e-12 * powerOf(load, accelerations(load)))) continue; // other reactions do the same
      const size = 1 / Math.sqrt(squared);
      reactions.push([left.map((x) => size * x), acceleration.map((x) => size * x)]);
    }
  }
  return without;
}

/** [{name, c, along}]: `along` is the load of a unit effort; its rate is that load's power. */
function jointDampers(scene, motions) {
  return scene.joints.flatMap((joint, j) =>
    Array.from({ length: RATES[joint.kind] }, (_, k) => {
      const { damping: c } = passiveForce(scene, j, joint.kind === "ball" ? 0 : k),
        efforts = scene.joints.map(() => [0, 0, 0]),
        wrenches = nothing(scene);
      efforts[j][k] = 1;
      effortWrenches(scene, efforts, motions, wrenches);
      return { name: `the damper of the joint \`${joint.name}\``, c, along: flat(wrenches) };
    }),
  );
}
function dragDampers(scene, force, indices) {
  return indices.flatMap((i) =>
    [force.coefficient_kg_per_s ?? 0, force.angular_coefficient_N_m_s ?? 0].flatMap((c, part) =>
      AXES.map((axis) => {
        const along = new Float64Array(6 * scene.bodies.length);
        along.set(axis, 6 * i + 3 * part);
        return { name: `the drag of \`${scene.bodies[i].name}\``, c, along };
      }),
    ),
  );
}
/** Along the spring, or along every axis where its ends coincide. */
function dashpots(scene, force, indices, motions) {
  const arms = indices.map((i, k) => toWorld(motions[i].q_WB, force.points_body_m?.[k] ?? [0, 0, 0]));
  const ends = indices.map((i, k) => plus(motions[i].p_WB, arms[k])),
    d = minus(ends[0], ends[1] ?? force.anchor_m);
  return (length(d) > 0 ? [scaled(1 / length(d), d)] : AXES).map((direction) => {
    const wrenches = nothing(scene);
    indices.forEach((i, k) => {
      const push = scaled(k === 0 ? 1 : -1, direction);
      wrenches[i].force_N = plus(wrenches[i].force_N, push);
      wrenches[i].torque_N_m = plus(wrenches[i].torque_N_m, cross(arms[k], push));
    });
    const name = `the damping of the spring of \`${scene.bodies[indices[0]].name}\``;
    return { name, c: force.damping_N_s_per_m ?? 0, along: flat(wrenches) };
  });
}

/** The largest eigenvalue of a symmetric matrix whose eigenvalues are 0 or more, by the power method. */
function largestEigenvalue(matrix) {
  let v = matrix.map((_, k) => 1 + ((0.618 * k) % 1)), // no symmetry of a scene is orthogonal to it
    value = 0;
  for (let sweep = 0; sweep < 200; ++sweep) {
    const next = matrix.map((row) => powerOf(row, v)),
      norm = Math.hypot(...next),
      last = value;
    if (!(norm > 0)) break;
    value = powerOf(v, next) / powerOf(v, v);
    if (Math.abs(value - last) <= 1e-9 * value) break;
    v = next.map((x) => x / norm);
  }
  return Math.max(value, ...matrix.map((row, k) => row[k]));
}

/**
 * {stiffest, largest_s} of the dampers that the adapter evaluates: of joints (if `ofJoints`), linear drag and the dashpots of
 * springs, at the scene's start, where joints hold the bodies together. Null: there is none.
 */
export function explicitDampers(scene, ofJoints) {
  const motions = scene.bodies.map((_, i) => motionAtStart(scene, i));
  const dampers = ofJoints ? jointDampers(scene, motions) : [];
  for (const { force, indices } of scene.forcesByIndex) {
    if (force.kind === "drag" && force.model === "linear") dampers.push(...dragDampers(scene, force, indices));
    if (force.kind === "spring") dampers.push(...dashpots(scene, force, indices, motions));
  }
  const acting = dampers.filter(({ c }) => c > 0);
  if (acting.length === 0) return null;
  const accelerations = accelerator(scene, motions),
    without = reactionRemover(scene, motions, accelerations);
  const left = acting.map(({ along }) => without(along)),
    answers = left.map(accelerations);
  const rates = acting.map((a, k) => acting.map((b, l) => Math.sqrt(a.c * b.c) * powerOf(left[k], answers[l])));
  const stiffest = acting.reduce((best, _, k) => (rates[k][k] > rates[best][best] ? k : best), 0),
    fastest = largestEigenvalue(rates),
    free = Math.max(...acting.map(({ c, along }) => c * powerOf(along, accelerations(along))));
  // Where the joints leave no rate to damp, there is no bound.
  return fastest > 1e-12 * free ? { stiffest: acting[stiffest].name, largest_s: 2 / fastest } : null;
}

/** What a row says of a run with steps beyond that; empty: its steps are within it. */
export function beyondExplicitDampers(dampers, h_s) {
  if (!dampers || !(h_s > dampers.largest_s)) return "";
  const [bound, step] = [dampers.largest_s, h_s].map((x) => Number(x.toPrecision(3)));
  return `${dampers.stiffest} is explicit, evaluated by the adapter once a step, and unstable beyond c h = 2 I: h = ${bound} s; the step is ${step} s`;
}
