// Joints and ropes of a scene in MuJoCo's terms. Conventions of MuJoCo:
// - the tree of joints is the tree of <body> elements: a child stands in its parent as at coordinates 0, and its anchor and
//   axes are in its own frame. A fixed joint is a body without joints, universal and cylindrical are two joints of one body;
//   qpos is then the scene's coordinates, and the rates of a ball are in the child's axes, as in the scene;
// - a closing joint is an equality constraint: ball `connect`, fixed `weld`, hinge two `connect` at points of the axis. A
//   rope over fixed points is the equality of a tendon through sites. These and the limits of joints are soft: solref and
//   solimp say how soft;
// - joint springs and dampers are MuJoCo's own. Motors are evaluated by the adapter once a step: the package has no callbacks.
import { conjugate, cross, dot, length, minus, plus, product, scaled, toBody, toWorld } from "../node/rotation.mjs";
import { drivenRate, limitsOf, passiveForce, placingJoints, turningPointMass } from "../node/joints.mjs";

export { placingJoints };

const text = (values) => values.join(" ");
const isGround = (scene, i) => i < 0 || scene.bodies[i].fixed;
const bodyName = (scene, i) => (isGround(scene, i) ? "world" : `b${i}`);
const origin = { p: [0, 0, 0], q: [1, 0, 0, 0] };

// What is tied to a fixed body is tied to the world: MuJoCo's body of a plane has another pose than the scene's.
function groundPose(scene, i) {
  if (i < 0 || !isGround(scene, i)) return origin;
  return { p: scene.bodies[i].position_m, q: scene.bodies[i].orientation_wxyz };
}
const placed = (frame, point) => plus(frame.p, toWorld(frame.q, point));

// No longer chain is known to compile: MuJoCo's compiler overruns the stack of WebAssembly beyond some 120 levels.
export const MOST_LEVELS = 100;

function levels(scene) {
  const placing = placingJoints(scene);
  return Math.max(
    0,
    ...scene.bodies.map((_, i) => {
      let count = 0;
      for (let b = i; b >= 0 && placing[b] >= 0; b = scene.joints[placing[b]].parent) ++count;
      return count;
    }),
  );
}

function refusedJoint(joint) {
  const named = `; found it on the joint \`${joint.name}\``,
    limits = limitsOf(joint);
  if (drivenRate(joint) !== undefined) return `MuJoCo has no joint with a prescribed motion${named}`;
  if (limits && limits.restitution !== 0) return `MuJoCo's stops have no restitution: expected stop_restitution = 0 on the joint \`${joint.name}\``;
  if (!joint.closes_loop) return "";
  if (!["ball", "fixed", "hinge"].includes(joint.kind))
    return `MuJoCo's equality constraints close loops only by fixed, hinge and ball joints${named}`;
  return limits ? `MuJoCo has no limits of a joint that closes a loop${named}` : "";
}

/** Why MuJoCo cannot represent the scene's joints and ropes; empty when it can. */
export function refusedMechanism(scene) {
  for (const joint of scene.joints) if (refusedJoint(joint)) return refusedJoint(joint);
  const closing = scene.jointForces.find((force) => scene.joints[force.joint].closes_loop);
  if (closing)
    return `MuJoCo has no forces of a joint that closes a loop; found one on \`${scene.joints[closing.joint].name}\``;
  const point = turningPointMass(scene),
    placing = placingJoints(scene);
  if (point >= 0 && scene.joints[placing[point]].kind !== "fixed")
    return `MuJoCo requires an inertia of the point mass \`${scene.bodies[point].name}\`, which turns with its parent`;
  const rope = scene.ropes.find(({ over_m }) => over_m.some((pulley) => pulley.radius_m || pulley.inertia_kg_m2));
  if (rope)
    return `MuJoCo's tendons slide over points without friction and turn no pulley: ` +
      `expected points (radius 0) under the rope \`${rope.name}\``;
  if (levels(scene) > MOST_LEVELS)
    return `MuJoCo's compiler overruns the stack of WebAssembly: expected chains of at most ${MOST_LEVELS} joints`;
  return "";
}

// ---- the model ------------------------------------------------------------------------------------------------------
/** The pose of a placed body at coordinates 0 in its parent's frame; in the world's where the parent is fixed or the world. */
export function placementAtZero(scene, joint) {
  const p = minus(joint.anchors_body_m[0], toWorld(joint.frame_wxyz, joint.anchors_body_m[1]));
  const base = groundPose(scene, joint.parent);
  return { p: placed(base, p), q: product(base.q, joint.frame_wxyz) };
}

const softness = (s, suffix) =>
  `solref${suffix}="${s.joint_solref_time_constant_s} ${s.joint_solref_damping_ratio}" ` +
  `solimp${suffix}="${s.joint_solimp_least} ${s.joint_solimp_most} ${s.solimp_width_m} ${s.solimp_midpoint} ${s.solimp_power}"`;

export function jointElements(scene, settings, j) {
  const joint = scene.joints[j],
    limits = limitsOf(joint);
  const element = (coordinate, type, axis) => {
    const { stiffness, rest, damping } = passiveForce(scene, j, coordinate);
    return (
      `<joint name="j${j}${coordinate ? "b" : ""}" type="${type}" pos="${text(joint.anchors_body_m[1])}"` +
      (axis ? ` axis="${text(axis)}"` : "") +
      (damping > 0 ? ` damping="${damping}"` : "") +
      (stiffness > 0 ? ` stiffness="${stiffness}" springref="${rest}"` : "") +
      (limits ? ` limited="true" range="${limits.lower} ${limits.upper}" ${softness(settings, "limit")}` : "") +
      "/>"
    );
  };
  switch (joint.kind) {
    case "hinge":
      return element(0, "hinge", joint.axis_body);
    case "slider":
      return element(0, "slide", joint.axis_body);
    case "cylindrical":
      return element(0, "hinge", joint.axis_body) + element(1, "slide", joint.axis_body);
    case "universal": // axes in the child's frame at coordinates 0
      return element(0, "hinge", toBody(joint.frame_wxyz, joint.axes_body[0])) + element(1, "hinge", joint.axes_body[1]);
    case "ball":
      return element(0, "ball");
    default:
      return "";
  }
}

/** Sites of ropes in the element of body i; -1: in the world's. */
export function ropeSites(scene, i) {
  return scene.ropes
    .map((rope, r) => {
      const ends = rope.bodies.map((at, end) =>
        (isGround(scene, at) ? -1 : at) === i
          ? `<site name="r${r}e${end}" pos="${text(placed(groundPose(scene, at), rope.points_body_m[end]))}"/>`
          : "",
      );
      const between = i < 0 ? rope.over_m.map((pulley, p) => `<site name="r${r}p${p}" pos="${text(pulley.axle_m)}"/>`) : [];
      return [...ends, ...between].join("");
    })
    .join("");
}

// Equality constraints are numbered in this order: joints that close loops (a hinge has two), then ropes.
function equalitiesOf(scene) {
  let count = 0;
  const ofJoint = scene.joints.map((joint) => {
    const first = count;
    if (joint.closes_loop) count += joint.kind === "hinge" ? 2 : 1;
    return joint.closes_loop ? first : -1;
  });
  return { ofJoint, ofRope: scene.ropes.map(() => count++) };
}

/** <equality> and <tendon>. */
export function constraintElements(scene, settings) {
  const words = softness(settings, "");
  const closing = scene.joints
    .filter((joint) => joint.closes_loop)
    .map(({ kind, parent, child }) => {
      const between = `body1="${bodyName(scene, parent)}" body2="${bodyName(scene, child)}" ${words}`;
      return kind === "fixed"
        ? `<weld ${between}/>\n`
        : `<connect ${between} anchor="0 0 0"/>\n`.repeat(kind === "hinge" ? 2 : 1);
    });
  const equalities = [...closing, ...scene.ropes.map((_, r) => `<tendon tendon1="r${r}" ${words}/>\n`)];
  const tendons = scene.ropes.map(
    ({ over_m }, r) =>
      `<spatial name="r${r}"><site site="r${r}e0"/>` +
      over_m.map((_, p) => `<site site="r${r}p${p}"/>`).join("") +
      `<site site="r${r}e1"/></spatial>\n`,
  );
  if (equalities.length === 0) return "";
  return (
    `<equality>\n${equalities.join("")}</equality>\n` + (tendons.length > 0 ? `<tendon>\n${tendons.join("")}</tendon>\n` : "")
  );
}

/** <exclude>: bodies with a common joint do not collide. */
export const excludedPairs = (scene) =>
  scene.joints
    .filter((joint) => joint.parent >= 0)
    .map(({ parent, child }) => `<exclude body1="b${parent}" body2="b${child}"/>\n`)
    .join("");

/** Points of the connects of a closing joint, in the parent's and the child's axes. */
function connectsOf(joint) {
  const [a, b] = joint.anchors_body_m;
  if (joint.kind === "ball") return [{ parent: a, child: b }];
  if (joint.kind !== "hinge") return [];
  const inChild = scaled(Math.max(length(a), length(b)) || 1, joint.axis_body);
  const inParent = toWorld(joint.frame_wxyz, inChild); // the frame's rotation leaves the axis of the hinge
  return [
    { parent: plus(a, inParent), child: plus(b, inChild) },
    { parent: minus(a, inParent), child: minus(b, inChild) },
  ];
}

/**
 * MuJoCo finds the points of a connect and the length of a tendon from the poses at coordinates 0, where loops are open and
 * ropes have other lengths. These are the scene's; the state of `data` is that of the start.
 */
export function setConstraints(mujoco, scene, model, data) {
  const { ofJoint } = equalitiesOf(scene),
    size = mujoco.mjNEQDATA,
    points = model.eq_data;
  const put = (equality, at, values) => values.forEach((x, k) => (points[size * equality + at + k] = x));
  scene.joints.forEach((joint, j) => {
    if (ofJoint[j] < 0) return;
    const base = groundPose(scene, joint.parent);
    if (joint.kind === "fixed") {
      // anchor in the child; anchor and orientation of the child in the parent
      put(ofJoint[j], 0, joint.anchors_body_m[1]);
      put(ofJoint[j], 3, placed(base, joint.anchors_body_m[0]));
      put(ofJoint[j], 6, product(base.q, joint.frame_wxyz));
    }
    connectsOf(joint).forEach(({ parent, child }, k) => {
      put(ofJoint[j] + k, 0, placed(base, parent));
      put(ofJoint[j] + k, 3, child);
    });
  });
  if (scene.ropes.length === 0) return;
  mujoco.mj_fwdPosition(model, data);
  model.tendon_length0.set(data.ten_length);
}

/** The time constant of the softness, where it is a number of steps. */
export function setSoftness(mujoco, settings, h_s, model) {
  const steps = settings.joint_solref_time_constant_steps;
  if (steps === 0) return;
  for (const [count, solref] of [
    [model.neq, model.eq_solref],
    [model.njnt, model.jnt_solref],
  ])
    for (let k = 0; k < count; ++k) solref[mujoco.mjNREF * k] = steps * h_s;
}

// ---- reactions ------------------------------------------------------------------------------------------------------
/** Forces of the rows of one equality constraint; zeros where it has no rows. */
function rowForces(mujoco, data, equality) {
  const kind = mujoco.mjtConstraint.mjCNSTR_EQUALITY.value,
    { efc_type, efc_id, efc_force, nefc } = data,
    forces = [];
  for (let i = 0; i < nefc; ++i) if (efc_type[i] === kind && efc_id[i] === equality) forces.push(efc_force[i]);
  return [...forces, 0, 0, 0, 0, 0, 0].slice(0, 6);
}

// Rows of a weld's orientation: e' = 1/2 vec(q_child^* w q_parent F), w = w_parent - w_child, in world axes.
function weldTorqueOnParent(joint, parent, child, rows) {
  const turned = product(parent.q_WB, joint.frame_wxyz);
  return [0, 1, 2].map((k) => {
    const unit = [0, 0, 0, 0];
    unit[k + 1] = 1;
    return 0.5 * dot(rows, product(product(conjugate(child.q_WB), unit), turned).slice(1));
  });
}

/** {force_N, torque_N_m} of a closing joint on its child at its anchor, world axes. */
export function closingReaction(mujoco, scene, j, parent, child, data) {
  const joint = scene.joints[j],
    first = equalitiesOf(scene).ofJoint[j];
  const anchor = plus(child.p_WB, toWorld(child.q_WB, joint.anchors_body_m[1]));
  if (joint.kind === "fixed") {
    const rows = rowForces(mujoco, data, first);
    return { force_N: scaled(-1, rows), torque_N_m: scaled(-1, weldTorqueOnParent(joint, parent, child, rows.slice(3))) };
  }
  const sum = { force_N: [0, 0, 0], torque_N_m: [0, 0, 0] };
  connectsOf(joint).forEach((points, k) => {
    const force = scaled(-1, rowForces(mujoco, data, first + k)),
      at = plus(child.p_WB, toWorld(child.q_WB, points.child));
    sum.force_N = plus(sum.force_N, force);
    sum.torque_N_m = plus(sum.torque_N_m, cross(minus(at, anchor), force));
  });
  return sum;
}

export const tensionOf = (mujoco, scene, r, data) => -rowForces(mujoco, data, equalitiesOf(scene).ofRope[r])[0];
