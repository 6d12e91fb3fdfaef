// Joints of a scene in Rapier: impulse joints between bodies. Conventions:
// - a joint has a frame in each body, an anchor and a rotation; the x axis of both is the joint's axis. In the parent's the
//   scene's frame comes first, so that both coincide at coordinate 0 and limits count from there;
// - hinges and sliders are Rapier's revolute and prismatic joints, the others generic joints with locked axes;
// - a generic joint locks components of the relative rotation's quaternion. With one of them locked and two free its axes do
//   not stay orthogonal (by 13 degrees after half a second of a test): universal joints are refused;
// - springs, dampers and motors are evaluated by the adapter once a step, as wrenches. Reactions cannot be read.
// - Joints in reduced coordinates (createMultibodyJoint) begin at coordinate 0 whatever the poses: they are left out.
import { drivenRate, limitsOf, motionAtStart, placingJoints, turningPointMass } from "../node/joints.mjs";
import { cross, orthogonal, plus, product, quaternionOf, toWorld } from "../node/rotation.mjs";
import { rotates } from "../node/scene.mjs";

const vector = ([x, y, z]) => ({ x, y, z });
const rotation = ([w, x, y, z]) => ({ x, y, z, w });

/** Why Rapier cannot represent the scene's joints and ropes; empty: it can. */
export function refusedMechanism(scene) {
  if (scene.ropes.length > 0) return `rapier's ropes bound a length and do not hold it; found \`${scene.ropes[0].name}\``;
  for (const joint of scene.joints) {
    const limits = limitsOf(joint),
      named = `; found it on the joint \`${joint.name}\``;
    if (limits && limits.restitution !== 0)
      return `rapier's stops have no restitution: expected stop_restitution = 0 on the joint \`${joint.name}\``;
    if (joint.kind === "hinge" && limits && (limits.lower < -Math.PI || limits.upper > Math.PI))
      return `rapier's hinges have limits between -pi and pi${named}`;
    if (joint.kind === "universal")
      return `rapier has no universal joint: one locked angle does not keep two axes orthogonal${named}`;
    if (drivenRate(joint) !== undefined) return `rapier's motors are springs that yield: no prescribed rate${named}`;
  }
  const point = turningPointMass(scene),
    placing = placingJoints(scene);
  const moved = scene.joints
    .flatMap(({ parent, child }) => [parent, child])
    .find((i) => i >= 0 && placing[i] < 0 && !scene.bodies[i].fixed && !rotates(scene.bodies[i]));
  const found = point >= 0 ? point : moved;
  return found === undefined
    ? ""
    : `rapier requires an inertia of the point mass \`${scene.bodies[found].name}\`, which turns with its joint`;
}

/** A quaternion that turns x to a unit axis. */
function frameAlong(axis) {
  const y = orthogonal(axis),
    z = cross(axis, y);
  return quaternionOf([axis[0], y[0], z[0], axis[1], y[1], z[1], axis[2], y[2], z[2]]);
}

/** Of generic joints: the axes that are locked. */
const locked = {
  fixed: ["LinX", "LinY", "LinZ", "AngX", "AngY", "AngZ"],
  cylindrical: ["LinY", "LinZ", "AngY", "AngZ"],
  ball: ["LinX", "LinY", "LinZ"],
};

/** Adds joint j to a world (world.mjs); `ground`: the body that the scene's world is. */
export function addJoint({ rapier, world, scene, bodies }, j, ground) {
  const joint = scene.joints[j],
    [anchor, childAnchor] = joint.anchors_body_m,
    limits = limitsOf(joint),
    { JointData } = rapier;
  // the world's body and those of planes stand at the origin, whatever the pose in the scene
  const parent = scene.bodies[joint.parent],
    inWorldAxes = !parent || (parent.fixed && Boolean(parent.shape?.plane));
  const base = inWorldAxes ? motionAtStart(scene, joint.parent) : { p_WB: [0, 0, 0], q_WB: [1, 0, 0, 0] };
  const inChild = frameAlong(joint.axis_body ?? [1, 0, 0]);
  const inParent = product(product(base.q_WB, joint.frame_wxyz), inChild),
    at = vector(plus(base.p_WB, toWorld(base.q_WB, anchor)));
  const x = { x: 1, y: 0, z: 0 },
    of = vector(childAnchor),
    mask = locked[joint.kind];
  const data =
    joint.kind === "hinge"
      ? JointData.revolute(at, of, x)
      : joint.kind === "slider"
        ? JointData.prismatic(at, of, x)
        : JointData.generic(
            at,
            of,
            x,
            mask.reduce((all, name) => all | rapier.JointAxesMask[name], 0),
          );
  const made = world.createImpulseJoint(data, parent ? bodies[joint.parent] : ground, bodies[joint.child], true);
  made.setLocalFrame1(at, rotation(inParent));
  made.setLocalFrame2(of, rotation(inChild));
  made.setContactsEnabled(false);
  if (limits) made.setLimits(limits.lower, limits.upper);
}
