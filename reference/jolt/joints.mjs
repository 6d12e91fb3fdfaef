// Joints of a scene in Jolt: constraints between bodies, in local space of their centres of mass. Conventions:
// - the first body is the parent, the second the child; the world and fixed bodies are Jolt's body that is fixed to the world;
// - a hinge's angle turns the child's normal axis from the parent's, a slider's offset is of the child's point along the
//   parent's axis: as in the scene. Their limits have to hold 0 between them: the parent's normal axis or point is moved to
//   the middle of the scene's;
// - cylindrical and universal joints are SixDOF: X free to slide and turn; rotation = swing about the parent's Y, then twist
//   about the child's X;
// - springs, dampers and motors are evaluated by the adapter once a step, as wrenches.
import { drivenRate, limitsOf, motionAtStart, placingJoints, turningPointMass } from "../node/joints.mjs";
import { orthogonal, plus, product, scaled, toBody, toWorld, turnAbout } from "../node/rotation.mjs";
import { rotates } from "../node/scene.mjs";

/** Why Jolt cannot represent the scene's joints and ropes; empty when it can. */
export function refusedMechanism(scene) {
  if (scene.ropes.length > 0) return `Jolt's adapter takes no ropes; found \`${scene.ropes[0].name}\``;
  for (const joint of scene.joints) {
    const limits = limitsOf(joint),
      named = `; found it on the joint \`${joint.name}\``;
    if (limits && limits.restitution !== 0) return `Jolt's stops have no restitution: expected stop_restitution = 0 on the joint \`${joint.name}\``;
    if (joint.kind === "hinge" && limits && limits.upper - limits.lower > 2 * Math.PI)
      return `Jolt's hinges have limits of at most one turn${named}`;
  }
  const point = turningPointMass(scene),
    placing = placingJoints(scene);
  const moved = scene.joints
    .flatMap(({ parent, child }) => [parent, child])
    .find((i) => i >= 0 && placing[i] < 0 && !scene.bodies[i].fixed && !rotates(scene.bodies[i]));
  for (const i of [point, moved ?? -1])
    if (i >= 0) return `Jolt requires an inertia of the point mass \`${scene.bodies[i].name}\`, which turns with its joint`;
  return "";
}

/** Adds the constraint of joint j to a world (world.mjs). */
export function addConstraint(world, j) {
  const { jolt, scene } = world,
    joint = scene.joints[j],
    [anchor, childAnchor] = joint.anchors_body_m,
    limits = limitsOf(joint);
  const ground = joint.parent < 0 || scene.bodies[joint.parent].fixed;
  const base = ground ? motionAtStart(scene, joint.parent) : { p_WB: [0, 0, 0], q_WB: [1, 0, 0, 0] };
  const frame = product(base.q_WB, joint.frame_wxyz),
    point = plus(base.p_WB, toWorld(base.q_WB, anchor));
  const { memory } = world,
    at = (p) => memory.point(p),
    vector = (v) => memory.vector(v);
  const axis = joint.axis_body,
    normal = axis && orthogonal(axis),
    middle = limits ? (limits.lower + limits.upper) / 2 : 0;
  const half = limits ? (limits.upper - limits.lower) / 2 : 0,
    inParent = (v) => vector(toWorld(frame, v));
  const make = (Settings, members) =>
    Object.assign(memory.counted(new Settings()), { mSpace: jolt.EConstraintSpace_LocalToBodyCOM }, members);
  const stops = limits ? { mLimitsMin: -half, mLimitsMax: half } : {};
  let settings;
  if (joint.kind === "hinge") {
    settings = make(jolt.HingeConstraintSettings, {
      mPoint1: at(point),
      mHingeAxis1: inParent(axis),
      mNormalAxis1: inParent(toWorld(turnAbout(axis, middle), normal)),
      mPoint2: at(childAnchor),
      mHingeAxis2: vector(axis),
      mNormalAxis2: vector(normal),
      ...stops,
    });
  } else if (joint.kind === "slider") {
    settings = make(jolt.SliderConstraintSettings, {
      mAutoDetectPoint: false,
      mPoint1: at(plus(point, scaled(middle, toWorld(frame, axis)))),
      mSliderAxis1: inParent(axis),
      mNormalAxis1: inParent(normal),
      mPoint2: at(childAnchor),
      mSliderAxis2: vector(axis),
      mNormalAxis2: vector(normal),
      ...stops,
    });
  } else if (joint.kind === "ball") {
    settings = make(jolt.PointConstraintSettings, { mPoint1: at(point), mPoint2: at(childAnchor) });
  } else if (joint.kind === "fixed") {
    settings = make(jolt.FixedConstraintSettings, {
      mAutoDetectPoint: false,
      mPoint1: at(point),
      mAxisX1: inParent([1, 0, 0]),
      mAxisY1: inParent([0, 1, 0]),
      mPoint2: at(childAnchor),
      mAxisX2: vector([1, 0, 0]),
      mAxisY2: vector([0, 1, 0]),
    });
  } else {
    const twist = axis ?? joint.axes_body[1],
      swing = normal ?? toBody(joint.frame_wxyz, joint.axes_body[0]);
    settings = make(jolt.SixDOFConstraintSettings, {
      mPosition1: at(point),
      mAxisX1: inParent(twist),
      mAxisY1: inParent(swing),
      mPosition2: at(childAnchor),
      mAxisX2: vector(twist),
      mAxisY2: vector(swing),
    });
    const axes = ["TranslationX", "TranslationY", "TranslationZ", "RotationX", "RotationY", "RotationZ"];
    const free = joint.kind === "cylindrical" ? ["TranslationX", "RotationX"] : ["RotationX", "RotationY"];
    for (const name of axes) {
      const which = jolt[`SixDOFConstraintSettings_EAxis_${name}`];
      if (free.includes(name)) settings.MakeFreeAxis(which);
      else settings.MakeFixedAxis(which);
    }
  }
  const parent = ground
    ? (world.interface.sGetFixedToWorldBody?.() ?? jolt.JoltInterface.prototype.sGetFixedToWorldBody())
    : world.bodies[joint.parent];
  const constraint = settings.Create(parent, world.bodies[joint.child]);
  world.system.AddConstraint(constraint);
  world.constraints.push(constraint);
  drive(jolt, joint, constraint);
}

/** Prescribed motion: the joint's motor, which holds a rate without a limit of its force. */
function drive(jolt, joint, constraint) {
  const rate = drivenRate(joint);
  if (rate === undefined) return;
  const driven = jolt.castObject(constraint, joint.kind === "hinge" ? jolt.HingeConstraint : jolt.SliderConstraint);
  driven.SetMotorState(jolt.EMotorState_Velocity);
  if (joint.kind === "hinge") driven.SetTargetAngularVelocity(rate);
  else driven.SetTargetVelocity(rate);
}
