// Joints in the worlds of engines: coordinates from poses, the forces of joints that an engine lacks, and reactions of the
// joints of a tree. Notation and kinds of joints: docs/joints.md.
//
// A joint's state is {q, u}: coordinates (angle; offset; angle, offset; two angles; quaternion w, x, y, z) and rates. The
// world is body -1: at the origin, at rest.
import { conjugate, cross, dot, minus, plus, product, scaled, toBody, toWorld } from "./rotation.mjs";
import { rotates } from "./scene.mjs";

const NOTHING = [0, 0, 0];
const WORLD = { p_WB: NOTHING, q_WB: [1, 0, 0, 0], v_WB: NOTHING, w_WB_B: NOTHING };
const ANGLES = { hinge: 1, cylindrical: 1, universal: 2 };

export const motionAtStart = (scene, i) => {
  if (i < 0) return WORLD;
  const body = scene.bodies[i];
  return {
    p_WB: body.position_m,
    q_WB: body.orientation_wxyz,
    v_WB: body.velocity_m_per_s,
    w_WB_B: body.angular_velocity_body_rad_per_s,
  };
};

/** {lower, upper, restitution} of a hinge or slider with stops; null: it has none. */
export function limitsOf(joint) {
  const limits = joint.limits_rad ?? joint.limits_m;
  return limits ? { lower: limits[0], upper: limits[1], restitution: joint.stop_restitution ?? 0 } : null;
}
/** The rate of a prescribed motion [rad/s or m/s]; undefined: the joint is free. */
export const drivenRate = (joint) => joint.driven_rate_rad_per_s ?? joint.driven_rate_m_per_s;

/** The joint that places each body, -1: none. */
export function placingJoints(scene) {
  const placing = scene.bodies.map(() => -1);
  scene.joints.forEach((joint, j) => {
    if (!joint.closes_loop) placing[joint.child] = j;
  });
  return placing;
}

/** All bodies, the parent of a placed body ahead of it. */
function parentsFirst(scene, placing) {
  const order = [],
    listed = scene.bodies.map(() => false);
  scene.bodies.forEach((_, i) => {
    const path = [];
    for (let b = i; b >= 0 && !listed[b]; b = placing[b] < 0 ? -1 : scene.joints[placing[b]].parent) {
      path.push(b);
      listed[b] = true;
    }
    order.push(...path.reverse());
  });
  return order;
}

/** Whether a joint connects two bodies: they do not collide. */
export const joined = (scene, a, b) =>
  scene.joints.some(({ parent, child }) => (parent === a && child === b) || (parent === b && child === a));

/** A point mass that turns with its parent, whose inertia of zero few engines admit; -1: none. */
export function turningPointMass(scene) {
  const placing = placingJoints(scene),
    turns = [];
  for (const i of parentsFirst(scene, placing)) {
    const body = scene.bodies[i];
    if (placing[i] < 0) {
      turns[i] = !body.fixed && rotates(body);
      continue;
    }
    const joint = scene.joints[placing[i]];
    turns[i] = !["fixed", "slider"].includes(joint.kind) || (joint.parent >= 0 && turns[joint.parent]);
    if (turns[i] && !rotates(body)) return i;
  }
  return -1;
}

/** Anchors and axes in world axes: of hinge, slider and cylindrical one axis, of universal two. */
export function placeOf(joint, parent, child) {
  const [a, b] = joint.anchors_body_m;
  const place = {
    parentAnchor: plus(parent.p_WB, toWorld(parent.q_WB, a)),
    childAnchor: plus(child.p_WB, toWorld(child.q_WB, b)),
    axes: [],
  };
  if (joint.kind === "universal")
    place.axes = [toWorld(parent.q_WB, joint.axes_body[0]), toWorld(child.q_WB, joint.axes_body[1])];
  else if (joint.axis_body) place.axes = [toWorld(child.q_WB, joint.axis_body)];
  return place;
}

// Of a unit quaternion that is a rotation about this axis; in [-pi, pi].
function angleAbout(axis, q) {
  const sine = dot(axis, q.slice(1));
  return q[0] < 0 ? 2 * Math.atan2(-sine, -q[0]) : 2 * Math.atan2(sine, q[0]);
}
const angleFromTo = (axis, a, b) => Math.atan2(dot(axis, cross(a, b)), dot(a, b));

// The slide s = axis . d with the axis fixed in the child: s' = axis . (d' - w_child x d).
function slideOf(place, parent, child, w_parent, w_child) {
  const axis = place.axes[0],
    d = minus(place.childAnchor, place.parentAnchor);
  const v_child = plus(child.v_WB, cross(w_child, minus(place.childAnchor, child.p_WB)));
  const v_parent = plus(parent.v_WB, cross(w_parent, minus(place.parentAnchor, parent.p_WB)));
  return { q: dot(axis, d), u: dot(axis, minus(minus(v_child, v_parent), cross(w_child, d))) };
}

/** Coordinates and rates that the motions of its bodies give a joint. Angles lie in [-pi, pi]. */
export function stateFromMotions(joint, parent, child) {
  const place = placeOf(joint, parent, child),
    [axis, second] = place.axes,
    frame = joint.frame_wxyz;
  const turn = product(conjugate(frame), product(conjugate(parent.q_WB), child.q_WB));
  const w_parent = toWorld(parent.q_WB, parent.w_WB_B),
    w_child = toWorld(child.q_WB, child.w_WB_B),
    w = minus(w_child, w_parent);
  const slide = () => slideOf(place, parent, child, w_parent, w_child);
  const angle = () => ({ q: angleAbout(joint.axis_body, turn), u: dot(axis, w) });
  const of = (...parts) => ({ q: parts.map((part) => part.q), u: parts.map((part) => part.u) });
  if (joint.kind === "hinge") return of(angle());
  if (joint.kind === "slider") return of(slide());
  if (joint.kind === "cylindrical") return of(angle(), slide());
  if (joint.kind === "ball") return { q: turn, u: toBody(child.q_WB, w) };
  if (joint.kind !== "universal") return { q: [], u: [] };
  const secondAtZero = toWorld(parent.q_WB, toWorld(frame, joint.axes_body[1]));
  const firstInChild = toBody(child.q_WB, axis),
    firstAtZero = toBody(frame, joint.axes_body[0]);
  return {
    q: [angleFromTo(axis, secondAtZero, second), angleFromTo(joint.axes_body[1], firstInChild, firstAtZero)],
    u: [dot(axis, w), dot(second, w)],
  };
}

/** `now` continued from `last`: whole turns are added to angles, and the sign of a ball's quaternion is kept. */
function continued(joint, last, now) {
  const turns = (x, k) => (k < (ANGLES[joint.kind] ?? 0) ? x + 2 * Math.PI * Math.round((last.q[k] - x) / (2 * Math.PI)) : x);
  const flipped = joint.kind === "ball" && now.q.reduce((sum, x, k) => sum + x * last.q[k], 0) < 0;
  return { q: flipped ? now.q.map((x) => -x) : now.q.map(turns), u: now.u };
}

// ---- the states of a scene's joints during a run --------------------------------------------------------------------
export const startOfJoints = (scene) => scene.joints.map((joint) => ({ q: joint.coordinates ?? [], u: joint.rates ?? [] }));

/**
 * Sets `states` to those of now. `motion(i)`: of body i. `stored(j)`: the engine's own state of joint j, unwrapped, or
 * nothing. Right if no angle changed by half a turn since.
 */
export function followJoints(scene, states, motion, stored = () => null) {
  const of = (i) => (i < 0 ? WORLD : motion(i));
  scene.joints.forEach((joint, j) => {
    const own = stored(j);
    const now = own ?? stateFromMotions(joint, of(joint.parent), of(joint.child));
    states[j] = own && joint.kind !== "ball" ? own : continued(joint, states[j], now);
  });
}

/** Rows of a sample: coordinates, rates and, where reported, force and torque on the child at its anchor (world axes). */
export const jointRows = (scene, states, reactions) =>
  states.map(({ q, u }, j) => [...q, ...u, ...(reactions ? [...reactions[j].force_N, ...reactions[j].torque_N_m] : [])]);

// ---- forces along coordinates ---------------------------------------------------------------------------------------
const isOn = (on_s, t_s) => !on_s?.length || on_s.some(([from, to]) => from <= t_s && t_s < to);
const stiffnessOf = (f) => f.stiffness_N_m_per_rad ?? f.stiffness_N_per_m ?? 0;
const dampingOf = (f) => f.damping_N_m_s_per_rad ?? f.damping_N_s_per_m ?? 0;
const restOf = (f) => f.rest_rad ?? f.rest_m ?? 0;

/** All springs and dampers of one coordinate as one: stiffness = sum of k, rest = sum of k rest / stiffness. */
export function passiveForce(scene, j, coordinate) {
  const sum = { stiffness: 0, rest: 0, damping: 0 };
  let moment = 0;
  for (const f of scene.jointForces) {
    if (f.kind !== "joint-spring" || f.joint !== j || (f.coordinate ?? 0) !== coordinate) continue;
    sum.stiffness += stiffnessOf(f);
    sum.damping += dampingOf(f);
    moment += stiffnessOf(f) * restOf(f);
    sum.rest = restOf(f); // of a single spring: exactly its own
  }
  if (sum.stiffness > 0 && moment !== sum.stiffness * sum.rest) sum.rest = moment / sum.stiffness;
  return sum;
}

/** What motors apply along each rate of each joint [N m or N] at t_s; on or off as at switch_s. */
export function motorEfforts(scene, t_s, switch_s) {
  const efforts = scene.joints.map(() => [0, 0, 0]);
  for (const f of scene.jointForces) {
    if (f.kind !== "joint-torque" || !isOn(f.on_s, switch_s)) continue;
    const phase = (f.angular_frequency_rad_per_s ?? 0) * t_s + (f.phase_rad ?? 0);
    efforts[f.joint][f.coordinate ?? 0] += (f.torque_N_m ?? f.force_N) * Math.cos(phase);
  }
  return efforts;
}

/** The mean power of all dampers over a step that began with the rates `earlier` of each joint and ended with `states`. */
export function damperPower(scene, earlier, states) {
  let power = 0;
  for (const f of scene.jointForces) {
    if (f.kind !== "joint-spring") continue;
    const ks = scene.joints[f.joint].kind === "ball" ? [0, 1, 2] : [f.coordinate ?? 0];
    for (const k of ks) power -= (dampingOf(f) * earlier[f.joint][k] * (earlier[f.joint][k] + states[f.joint].u[k])) / 2;
  }
  return power;
}

/** The same of springs, dampers and motors. */
export function jointEfforts(scene, t_s, switch_s, states) {
  const efforts = motorEfforts(scene, t_s, switch_s);
  for (const f of scene.jointForces) {
    if (f.kind !== "joint-spring") continue;
    const { q, u } = states[f.joint],
      k = f.coordinate ?? 0;
    if (scene.joints[f.joint].kind === "ball") efforts[f.joint] = minus(efforts[f.joint], scaled(dampingOf(f), u));
    else efforts[f.joint][k] -= stiffnessOf(f) * (q[k] - restOf(f)) + dampingOf(f) * u[k];
  }
  return efforts;
}

function push(wrench, force, torque) {
  wrench.force_N = plus(wrench.force_N, force);
  wrench.torque_N_m = plus(wrench.torque_N_m, torque);
}

/** Adds the efforts to the wrenches of both bodies of each joint, for engines without forces along coordinates. */
export const jointWrenches = (scene, t_s, switch_s, states, motions, wrenches) =>
  effortWrenches(scene, jointEfforts(scene, t_s, switch_s, states), motions, wrenches);
export function effortWrenches(scene, efforts, motions, wrenches) {
  const of = (i) => (i < 0 ? WORLD : motions[i]);
  scene.joints.forEach((joint, j) => {
    if (efforts[j].every((x) => x === 0)) return;
    const parent = of(joint.parent),
      child = of(joint.child),
      { axes, childAnchor } = placeOf(joint, parent, child);
    const [first, second] = efforts[j],
      along = joint.kind === "slider" ? first : joint.kind === "cylindrical" ? second : 0;
    const force = along === 0 ? NOTHING : scaled(along, axes[0]);
    let torque = NOTHING;
    if (joint.kind === "ball") torque = toWorld(child.q_WB, efforts[j]);
    else if (joint.kind !== "slider") torque = scaled(first, axes[0]);
    if (joint.kind === "universal") torque = plus(torque, scaled(second, axes[1]));
    push(wrenches[joint.child], force, plus(torque, cross(minus(childAnchor, child.p_WB), force)));
    if (joint.parent >= 0)
      push(wrenches[joint.parent], scaled(-1, force), scaled(-1, plus(torque, cross(minus(childAnchor, parent.p_WB), force))));
  });
}

/** The kinds of the scene's joint forces but `own`, as "joint-spring, joint-torque"; empty: none. */
export const namesOfJointForces = (scene, own = []) =>
  [...new Set(scene.jointForces.map((f) => f.kind))]
    .filter((kind) => !own.includes(kind))
    .sort()
    .join(", ");

// ---- reactions ------------------------------------------------------------------------------------------------------
/** Of all that a joint transmits to its child the constraint's part: what has no power along the free rates. */
export function constraintPart(joint, place, total) {
  if (drivenRate(joint) !== undefined) return total;
  const [axis, second] = place.axes,
    without = (v) => minus(v, scaled(dot(axis, v), axis));
  let { force_N, torque_N_m } = total;
  if (joint.kind === "slider" || joint.kind === "cylindrical") force_N = without(force_N);
  if (joint.kind === "hinge" || joint.kind === "cylindrical") torque_N_m = without(torque_N_m);
  if (joint.kind === "ball") torque_N_m = NOTHING;
  if (joint.kind === "universal") {
    const normal = cross(axis, second);
    torque_N_m = scaled(dot(normal, torque_N_m) / dot(normal, normal), normal);
  }
  return { force_N, torque_N_m };
}

/**
 * Reactions of the joints of the tree by Newton's and Euler's equations of each subtree. `missing`: for each body what its
 * motion requires (m a, I alpha + w x I w about its centre of mass) less all that acts on it besides the joints of the
 * tree. `closing`: reactions of the joints that close loops. {force_N, torque_N_m} on the child at its anchor, world axes.
 */
export function subtreeReactions(scene, motions, missing, closing) {
  const placing = placingJoints(scene),
    reactions = [...closing];
  for (const i of parentsFirst(scene, placing).reverse()) {
    if (placing[i] < 0) continue;
    const joint = scene.joints[placing[i]],
      parent = joint.parent < 0 ? WORLD : motions[joint.parent];
    const place = placeOf(joint, parent, motions[i]),
      { force_N } = missing[i];
    const torque_N_m = minus(missing[i].torque_N_m, cross(minus(place.childAnchor, motions[i].p_WB), force_N));
    reactions[placing[i]] = constraintPart(joint, place, { force_N, torque_N_m });
    if (joint.parent >= 0)
      push(missing[joint.parent], force_N, plus(torque_N_m, cross(minus(place.childAnchor, parent.p_WB), force_N)));
  }
  return reactions;
}
