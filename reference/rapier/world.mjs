// A scene in Rapier. Conventions:
// - Everything is kept in float: the step, positions, velocities, forces. What is read is widened without loss.
// - translation() and linvel() are of a body's origin, which is its centre of mass here: mass and inertia are given by
//   setAdditionalMassProperties with principal moments and their frame (x, y, z, w), and colliders have no density.
// - angvel() and addTorque() are in world axes. Forces stay until they are reset: they are reset every step.
// - Quaternions are x, y, z, w.
// - Restitution and friction of a pair are combined from those of the colliders, in layers of them where one rule does not
//   give each pair its own: see coefficients.mjs. Rolling friction is refused; friction about the normal comes with the
//   solver's model and cannot be turned off.
// - A step is solver_iterations substeps, each of which integrates forces, the gyroscopic term among them, and positions.
//   No body moves faster than 400 length units a second or turns by more than pi/4 in a step: runs in which that happens
//   say so. Contacts are solved ahead of the touch, from prediction_distance on. No damping; no sleeping unless set.
// - Friction's impulses cannot be read (contactTangentImpulseX and Y are 0): they are not reported.
import { isNothing } from "../node/forces.mjs";
import { length, plus, principalAxes, scaled, toBody, toWorld } from "../node/rotation.mjs";
import { pairsInPlay, rotates, shapesMatter } from "../node/scene.mjs";
import { layersOf } from "./coefficients.mjs";
import { collidersOf } from "./colliders.mjs";
import { addJoint } from "./joints.mjs";

const vector = ([x, y, z]) => ({ x, y, z });
const array = ({ x, y, z }) => [x, y, z];
const rotation = ([w, x, y, z]) => ({ x, y, z, w });

export const FASTEST = 400; // length units a second
export const LARGEST_TURN_RAD = Math.PI / 4; // in a step

/** Layers of colliders that give each pair of materials its law (coefficients.mjs); null: there are none. */
export const contactLayers = (scene) => layersOf(scene.materials.length, pairsInPlay(scene));

/** A world of `rapier` (the package's module) for a scene (node/scene.mjs); `observe`: what it cuts is told. */
export class RapierWorld {
  constructor(rapier, scene, settings, observe) {
    Object.assign(this, {
      rapier,
      scene,
      settings,
      observe,
      bodies: [],
      bodyOf: new Map(),
      colliders: [],
      pushed: [],
      cut: new Set(),
    });
    this.world = new rapier.World(vector(scene.gravity_m_per_s2));
    this.set(this.world.integrationParameters);
    this.layers = contactLayers(scene);
    this.material = new Map(scene.materials.map((each, i) => [each.name, i]));
    scene.bodies.forEach((body, i) => this.add(body, i));
    const ground = scene.joints.length > 0 ? this.world.createRigidBody(rapier.RigidBodyDesc.fixed()) : null;
    scene.joints.forEach((_, j) => addJoint(this, j, ground));
  }

  set(parameters) {
    const { settings } = this;
    parameters.numSolverIterations = settings.solver_iterations;
    parameters.numInternalPgsIterations = settings.pgs_iterations;
    parameters.lengthUnit = settings.length_unit_m;
    parameters.normalizedAllowedLinearError = settings.allowed_linear_error;
    parameters.normalizedPredictionDistance = settings.prediction_distance;
    parameters.maxCcdSubsteps = settings.ccd_substeps;
    if (settings.contact_natural_frequency_Hz !== 30)
      parameters.contact_natural_frequency = settings.contact_natural_frequency_Hz;
  }

  add(body, i) {
    const { rapier, settings } = this,
      plane = body.fixed && Boolean(body.shape?.plane); // in world axes, for every pose of its body
    const description = body.fixed ? rapier.RigidBodyDesc.fixed() : rapier.RigidBodyDesc.dynamic();
    description
      .setCanSleep(settings.sleeping)
      .setCcdEnabled(settings.ccd)
      .setSoftCcdPrediction(settings.soft_ccd_prediction_m);
    if (!plane) description.setTranslation(...body.position_m).setRotation(rotation(body.orientation_wxyz));
    if (!body.fixed) this.setMass(description, body);
    this.bodies[i] = this.world.createRigidBody(description);
    this.addColliders(i);
    if (body.fixed) return;
    if (body.release_s > 0) this.bodies[i].setBodyType(rapier.RigidBodyType.Fixed, false);
    else this.setVelocity(i);
  }

  addColliders(i) {
    const body = this.scene.bodies[i],
      material = this.material.get(body.material) ?? 0;
    const own = this.layers.filter(({ groups }) => !groups || groups.has(material));
    for (const layer of own)
      for (const collider of collidersOf(this.rapier, body, this.settings)) this.addCollider(collider, i, material, layer);
  }

  addCollider({ description, p_B, q_B }, i, material, { restitution, friction, groups }) {
    const { CoefficientCombineRule } = this.rapier;
    description
      .setDensity(0)
      .setTranslation(...p_B)
      .setRotation(rotation(q_B))
      .setContactSkin(this.settings.contact_skin_m);
    description
      .setRestitution(restitution.values[material])
      .setRestitutionCombineRule(CoefficientCombineRule[restitution.rule]);
    description.setFriction(friction.values[material]).setFrictionCombineRule(CoefficientCombineRule[friction.rule]);
    if (groups) {
      const { member, filter } = groups.get(material);
      description.setCollisionGroups(((member << 16) | filter) >>> 0);
    }
    const collider = this.world.createCollider(description, this.bodies[i]);
    this.bodyOf.set(collider.handle, i);
    this.colliders.push(collider);
  }

  setMass(description, body) {
    const { moments_kg_m2, q_BP } = principalAxes(body.inertia_kg_m2);
    description.setAdditionalMassProperties(body.mass_kg, vector([0, 0, 0]), vector(moments_kg_m2), rotation(q_BP));
    if (!rotates(body)) description.lockRotations();
  }

  setVelocity(i) {
    const body = this.scene.bodies[i];
    this.bodies[i].setLinvel(vector(body.velocity_m_per_s), true);
    if (rotates(body))
      this.bodies[i].setAngvel(vector(toWorld(body.orientation_wxyz, body.angular_velocity_body_rad_per_s)), true);
  }

  step(h_s, wrenches) {
    for (const i of this.pushed) {
      this.bodies[i].resetForces(false);
      this.bodies[i].resetTorques(false);
    }
    this.pushed = [];
    wrenches.forEach((wrench, i) => {
      if (this.scene.bodies[i].fixed || isNothing(wrench)) return;
      this.bodies[i].addForce(vector(wrench.force_N), true);
      this.bodies[i].addTorque(vector(wrench.torque_N_m), true);
      this.pushed.push(i);
    });
    this.world.timestep = h_s;
    this.world.step();
    this.h_s = h_s;
    if (this.observe) this.watch();
  }

  /** Whether Rapier cut a body's motion in this step. */
  watch() {
    const fastest = 0.9999 * FASTEST * this.settings.length_unit_m,
      most = (0.9999 * LARGEST_TURN_RAD) / this.h_s;
    this.bodies.forEach((body, i) => {
      if (this.scene.bodies[i].fixed) return;
      if (length(array(body.linvel())) > fastest)
        this.cut.add(`speeds are cut at ${FASTEST * this.settings.length_unit_m} m/s`);
      if (length(array(body.angvel())) > most) this.cut.add("rates are cut at a turn of pi/4 a step");
    });
  }

  /** What gives each pair its law in this scene: "restitution by Average, friction by Max", or the number of layers. */
  pairLaws() {
    if (!shapesMatter(this.scene) || !this.layers.length) return "";
    if (this.layers.length > 1) return `laws of pairs by ${this.layers.length} layers of colliders`;
    const [{ restitution, friction }] = this.layers;
    return `laws of pairs: restitution by Rapier's rule ${restitution.rule}, friction by ${friction.rule}`;
  }

  complaints() {
    return [this.pairLaws(), ...this.cut].filter(Boolean).join("; ");
  }

  motion(i) {
    const body = this.bodies[i],
      r = body.rotation(),
      q_WB = [r.w, r.x, r.y, r.z];
    return { p_WB: array(body.translation()), q_WB, v_WB: array(body.linvel()), w_WB_B: toBody(q_WB, array(body.angvel())) };
  }

  release(i) {
    this.bodies[i].setBodyType(this.rapier.RigidBodyType.Dynamic, true);
    this.setVelocity(i);
  }

  touches() {
    return this.points().filter(({ impulse_n_N_s }) => impulse_n_N_s > 0);
  }

  /** All points of the manifolds that the last step found at its start. */
  points() {
    const all = [];
    for (const one of this.colliders)
      this.world.contactPairsWith(one, (other) => {
        if (one.handle < other.handle)
          this.world.contactPair(one, other, (manifold, flipped) =>
            this.take(all, manifold, flipped ? [other, one] : [one, other]),
          );
      });
    return all;
  }

  /** Points of a manifold between two colliders: its normal points from the first to the second. */
  take(all, manifold, [first, second]) {
    const a = this.bodyOf.get(first.handle),
      b = this.bodyOf.get(second.handle),
      sign = a < b ? 1 : -1;
    const normal = scaled(sign, array(manifold.normal())),
      whole = manifold.numSolverContacts() === manifold.numContacts();
    for (let k = 0; k < manifold.numContacts(); ++k) {
      const x_m = whole ? array(manifold.solverContactPoint(k)) : this.worldPoint(first, manifold.localContactPoint1(k));
      const smooth = this.scene.pairLaw(a, b).friction === 0;
      all.push({
        body_a: Math.min(a, b),
        body_b: Math.max(a, b),
        x_m,
        normal,
        gap_m: manifold.contactDist(k),
        impulse_n_N_s: manifold.contactImpulse(k),
        impulse_t_N_s: smooth ? [0, 0, 0] : [NaN, NaN, NaN],
      });
    }
  }

  worldPoint(collider, local) {
    const { x, y, z, w } = collider.rotation();
    return plus(array(collider.translation()), toWorld([w, x, y, z], array(local)));
  }

  free() {
    this.world.free();
  }
}

/** Where bodies at rest overlap, or nearly (node/contacts.mjs): what a step that is too short to move them finds. */
export function overlaps(rapier, scene, settings) {
  const world = new RapierWorld(rapier, scene, settings, false);
  try {
    world.step(1e-6, []);
    return world.points();
  } finally {
    world.free();
  }
}
