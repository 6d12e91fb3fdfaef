// A scene in Jolt. Conventions:
// - everything is kept in float: the step, positions, velocities, forces. What is read is widened without loss;
// - a body's position is asked of its centre of mass; mass and inertia are set as their inverses, the inertia by principal
//   moments and their frame in the body's;
// - velocities, forces and torques are in world axes; quaternions are x, y, z, w;
// - AddForce and AddTorque last one step;
// - Jolt combines friction by the geometric mean and restitution by the larger coefficient: both bodies get the law where
//   the scene has one, and a contact listener gives each pair its own where it has several;
// - of a manifold's bodies the first has the smaller ID, which is the order of creation and of the scene; its normal points
//   from the first to the second, its depth is negative for speculative contacts.
import { isNothing } from "../node/forces.mjs";
import { dot, length, minus, plus, principalAxes, scaled, toBody, toWorld } from "../node/rotation.mjs";
import { Refusal, hasShape, lawsInPlay, rotates, shapesMatter } from "../node/scene.mjs";
import { addConstraint } from "./joints.mjs";
import { Memory } from "./memory.mjs";
import { Shapes } from "./shapes.mjs";

const FIXED = 0,
  MOVING = 1,
  TOUCHES_NOTHING = 2;
export const array = (v) => [v.GetX(), v.GetY(), v.GetZ()];

/** The tables of layers: FIXED touches MOVING, MOVING both, TOUCHES_NOTHING none. */
function layers(jolt, made) {
  const filter = new jolt.ObjectLayerPairFilterTable(3);
  filter.EnableCollision(FIXED, MOVING);
  filter.EnableCollision(MOVING, MOVING);
  const broad = new jolt.BroadPhaseLayerInterfaceTable(3, 3);
  for (const layer of [FIXED, MOVING, TOUCHES_NOTHING]) {
    const own = new jolt.BroadPhaseLayer(layer);
    broad.MapObjectToBroadPhaseLayer(layer, own);
    jolt.destroy(own);
  }
  made.mObjectLayerPairFilter = filter;
  made.mBroadPhaseLayerInterface = broad;
  made.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(broad, 3, filter, 3);
}

/** A JoltInterface for `count` bodies. */
export function makeInterface(jolt, count) {
  const made = new jolt.JoltSettings();
  layers(jolt, made);
  made.mMaxBodies = count + 16;
  made.mMaxBodyPairs = 64 * count + 1024;
  made.mMaxContactConstraints = 32 * count + 1024;
  made.mMaxWorkerThreads = 0;
  const system = new jolt.JoltInterface(made);
  jolt.destroy(made);
  return system;
}

function setPhysics(system, s) {
  const physics = system.GetPhysicsSettings();
  Object.assign(physics, {
    mNumVelocitySteps: s.velocity_steps,
    mNumPositionSteps: s.position_steps,
    mBaumgarte: s.baumgarte,
    mPenetrationSlop: s.penetration_slop_m,
    mSpeculativeContactDistance: s.speculative_contact_distance_m,
    mMinVelocityForRestitution: s.min_velocity_for_restitution_m_per_s,
    mManifoldTolerance: s.manifold_tolerance_m,
    mMaxPenetrationDistance: s.max_penetration_distance_m,
    mConstraintWarmStart: s.warm_start,
    mUseBodyPairContactCache: s.body_pair_cache,
    mUseManifoldReduction: s.manifold_reduction,
    mAllowSleeping: s.sleeping,
    mDeterministicSimulation: true,
  });
  system.SetPhysicsSettings(physics);
}

/** A world of `jolt` (the package's module) for a scene (node/scene.mjs). `observe`: touches() will be called. */
export class JoltWorld {
  constructor(jolt, scene, settings, observe) {
    Object.assign(this, { jolt, scene, settings, bodies: [], constraints: [], met: new Map(), before: null });
    this.memory = new Memory(jolt);
    this.collide = shapesMatter(scene);
    this.interface = makeInterface(jolt, scene.bodies.length);
    this.system = this.interface.GetPhysicsSystem();
    this.bodyInterface = this.system.GetBodyInterface();
    this.force = new jolt.Vec3();
    this.torque = new jolt.Vec3();
    setPhysics(this.system, settings);
    try {
      this.fill(observe);
    } catch (error) {
      this.free();
      throw error;
    }
  }
  fill(observe) {
    const { jolt, scene, settings, memory } = this;
    this.system.SetGravity(memory.vector(scene.gravity_m_per_s2));
    this.shapes = new Shapes(jolt, settings, memory);
    this.filter = scene.joints.length > 0 ? this.groups() : null;
    scene.bodies.forEach((body, i) => this.add(body, i));
    scene.joints.forEach((_, j) => addConstraint(this, j));
    this.listen(observe && this.collide);
    this.system.OptimizeBroadPhase();
    memory.drop();
  }

  /** Bodies with a common joint do not collide. */
  groups() {
    const table = this.memory.counted(new this.jolt.GroupFilterTable(this.scene.bodies.length));
    for (const { parent, child } of this.scene.joints) if (parent >= 0) table.DisableCollision(parent, child);
    return table;
  }

  add(body, i) {
    const { jolt, settings, memory } = this,
      { EMotionType_Static, EMotionType_Dynamic, EMotionQuality_Discrete } = jolt;
    const plane = body.fixed && Boolean(body.shape?.plane); // in world axes, for every pose of its body
    const [w, x, y, z] = plane ? [1, 0, 0, 0] : body.orientation_wxyz,
      [px, py, pz] = plane ? [0, 0, 0] : body.position_m;
    const layer = !this.collide || !hasShape(body) ? TOUCHES_NOTHING : body.fixed ? FIXED : MOVING;
    const shape = this.shapes.of(body),
      held = !body.fixed && body.release_s > 0,
      stands = body.fixed || held;
    const made = new jolt.BodyCreationSettings(
      shape,
      memory.point([px, py, pz]),
      memory.quaternion([w, x, y, z]).Normalized(),
      stands ? EMotionType_Static : EMotionType_Dynamic,
      layer,
    );
    Object.assign(made, {
      mLinearDamping: settings.linear_damping_per_s,
      mAngularDamping: settings.angular_damping_per_s,
      mMaxLinearVelocity: settings.max_linear_velocity_m_per_s,
      mMaxAngularVelocity: settings.max_angular_velocity_rad_per_s,
      mApplyGyroscopicForce: settings.gyroscopic,
      mAllowSleeping: settings.sleeping,
      mMotionQuality: EMotionQuality_Discrete,
      mAllowDynamicOrKinematic: held,
      mEnhancedInternalEdgeRemoval: settings.enhanced_internal_edge_removal,
      mUserData: i,
    });
    if (!body.fixed) {
      // whatever the shape's density says, the scene's mass follows below
      made.mOverrideMassProperties = jolt.EOverrideMassProperties_MassAndInertiaProvided;
      made.mMassPropertiesOverride.SetMassAndInertiaOfSolidBox(memory.vector([1, 1, 1]), 1);
      if (!rotates(body))
        made.mAllowedDOFs = jolt.EAllowedDOFs_TranslationX | jolt.EAllowedDOFs_TranslationY | jolt.EAllowedDOFs_TranslationZ;
    }
    if (this.filter) made.mCollisionGroup = memory.own(new jolt.CollisionGroup(this.filter, 0, i));
    const one = this.bodyInterface.CreateBody(made);
    jolt.destroy(made);
    this.bodies[i] = one;
    this.bodyInterface.AddBody(one.GetID(), jolt.EActivation_Activate);
    if (stands) return;
    this.setMass(i);
    this.setVelocity(i);
  }

  setMass(i) {
    const body = this.scene.bodies[i],
      properties = this.bodies[i].GetMotionProperties();
    properties.SetInverseMass(1 / body.mass_kg);
    if (!rotates(body)) return;
    const { moments_kg_m2, q_BP } = principalAxes(body.inertia_kg_m2);
    const inverse = this.memory.vector(moments_kg_m2.map((moment) => 1 / moment));
    properties.SetInverseInertia(inverse, this.memory.quaternion(q_BP));
  }
  setVelocity(i) {
    const body = this.scene.bodies[i],
      { memory } = this;
    this.bodies[i].SetLinearVelocity(memory.vector(body.velocity_m_per_s));
    if (rotates(body))
      this.bodies[i].SetAngularVelocity(memory.vector(toWorld(body.orientation_wxyz, body.angular_velocity_body_rad_per_s)));
  }

  /** Gives pairs their laws, and notes contacts where `observe`. */
  listen(observe) {
    const { jolt, scene } = this,
      laws = this.collide ? lawsInPlay(scene) : [];
    const [law] = laws,
      friction = Math.fround(law?.friction ?? 0);
    const one =
      laws.every((each) => each.friction === law.friction && each.restitution === law.restitution) &&
      Math.fround(Math.sqrt(Math.fround(friction * friction))) === friction;
    for (const body of one && law ? this.bodies : []) {
      body.SetFriction(law.friction);
      body.SetRestitution(law.restitution);
    }
    if (one && !observe) return;
    const index = new Map(this.bodies.map((body, i) => [jolt.getPointer(body), i]));
    const listener = (this.listener = new jolt.ContactListenerJS());
    listener.OnContactValidate = () => jolt.ValidateResult_AcceptAllContactsForThisBodyPair;
    listener.OnContactRemoved = () => {};
    listener.OnContactAdded = listener.OnContactPersisted = (first, second, manifold, ioSettings) => {
      const a = index.get(first),
        b = index.get(second);
      if (!one) {
        const own = scene.pairLaw(a, b),
          combined = jolt.wrapPointer(ioSettings, jolt.ContactSettings);
        combined.mCombinedFriction = own.friction;
        combined.mCombinedRestitution = own.restitution;
      }
      if (observe) this.note(a, b, jolt.wrapPointer(manifold, jolt.ContactManifold));
    };
    this.system.SetContactListener(listener);
  }

  /** A manifold of the step between bodies a < b, its normal from a to b; the deepest of a pair's is kept. */
  note(a, b, manifold) {
    const gap_m = -manifold.mPenetrationDepth,
      key = `${a} ${b}`,
      known = this.met.get(key);
    if (known && known.gap_m <= gap_m) return;
    const points = manifold.mRelativeContactPointsOn1.size();
    let sum = [0, 0, 0];
    for (let k = 0; k < points; ++k) sum = plus(sum, array(manifold.GetWorldSpaceContactPointOn1(k)));
    this.met.set(key, { a, b, x_m: scaled(1 / points, sum), gap_m, normal: array(manifold.mWorldSpaceNormal) });
  }

  step(h_s, wrenches) {
    wrenches.forEach((wrench, i) => {
      if (isNothing(wrench) || this.bodies[i].IsStatic()) return;
      this.force.Set(...wrench.force_N);
      this.torque.Set(...wrench.torque_N_m);
      this.bodies[i].AddForce(this.force);
      this.bodies[i].AddTorque(this.torque);
    });
    if (this.listener) {
      this.met.clear();
      this.before = { h_s, wrenches, v: this.bodies.map((body) => array(body.GetLinearVelocity())) };
    }
    this.interface.Step(h_s, 1);
  }

  motion(i) {
    const body = this.bodies[i],
      r = body.GetRotation(),
      q_WB = [r.GetW(), r.GetX(), r.GetY(), r.GetZ()];
    return {
      p_WB: array(body.GetCenterOfMassPosition()),
      q_WB,
      v_WB: array(body.GetLinearVelocity()),
      w_WB_B: toBody(q_WB, array(body.GetAngularVelocity())),
    };
  }

  release(i) {
    this.bodyInterface.SetMotionType(this.bodies[i].GetID(), this.jolt.EMotionType_Dynamic, this.jolt.EActivation_Activate);
    this.setMass(i);
    this.setVelocity(i);
    this.memory.drop();
  }

  /** What the contacts of the last step gave body i [N s], world axes: its change of momentum less that of all else. */
  impulseOn(i) {
    const { h_s, wrenches, v } = this.before,
      m = this.scene.bodies[i].mass_kg;
    const gained = scaled(m, minus(array(this.bodies[i].GetLinearVelocity()), v[i]));
    const applied = plus(scaled(m * h_s, this.scene.gravity_m_per_s2), scaled(h_s, wrenches[i]?.force_N ?? [0, 0, 0]));
    return minus(gained, applied);
  }

  /** As node/run.mjs has them; null where a contact's impulse cannot be told from others or from a joint's. */
  touches() {
    if (this.met.size === 0) return [];
    if (this.scene.joints.length > 0) return null;
    const count = this.scene.bodies.map(() => 0),
      all = [];
    for (const { a, b } of this.met.values()) for (const i of [a, b]) ++count[i];
    for (const { a, b, x_m, normal, gap_m } of this.met.values()) {
      const decides = [b, a].find((i) => !this.scene.bodies[i].fixed && count[i] === 1);
      if (decides === undefined) return null;
      const onB = scaled(decides === b ? 1 : -1, this.impulseOn(decides)),
        impulse_n_N_s = dot(onB, normal);
      const weight =
        this.scene.bodies[decides].mass_kg *
        (length(this.before.v[decides]) + length(scaled(this.before.h_s, this.scene.gravity_m_per_s2)));
      if (impulse_n_N_s > 4 * 2 ** -23 * weight)
        // round-off of the velocities is no impulse
        all.push({
          body_a: a,
          body_b: b,
          x_m,
          normal,
          gap_m,
          impulse_n_N_s,
          impulse_t_N_s: minus(onB, scaled(impulse_n_N_s, normal)),
        });
    }
    return all;
  }

  free() {
    for (const constraint of this.constraints) this.system.RemoveConstraint(constraint);
    for (const body of this.bodies) {
      this.bodyInterface.RemoveBody(body.GetID());
      this.bodyInterface.DestroyBody(body.GetID());
    }
    this.memory.free();
    this.jolt.destroy(this.interface);
    for (const one of [this.listener, this.force, this.torque]) if (one) this.jolt.destroy(one);
  }
}
