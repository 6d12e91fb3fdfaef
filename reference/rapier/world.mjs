// A scene in Rapier. Conventions:
// - Everything is kept in float: the step, positions, velocities, forces. What is read is widened without loss.
// - translation() and linvel() are of a body's origin, which is its centre of mass here: mass and inertia are given by
//   setAdditionalMassProperties with principal moments and their frame (x, y, z, w), and colliders have no density.
// - angvel() and addTorque() are in world axes. Forces stay until they are reset: they are reset every step.
// - Quaternions are x, y, z, w.
import { conjugate, isZero, normalised, principalAxes, toBody, toWorld } from "../node/rotation.mjs";
import { hasShape, rotates } from "../node/scene.mjs";
import { isNothing } from "../node/forces.mjs";

const vector = ([x, y, z]) => ({ x, y, z });
const array = ({ x, y, z }) => [x, y, z];
const rotation = ([w, x, y, z]) => ({ x, y, z, w });

/** A world of `rapier` (the package's module) for a scene (node/scene.mjs). */
export class RapierWorld {
  constructor(rapier, scene, settings) {
    Object.assign(this, { rapier, scene, settings, bodies: [], pushed: [] });
    this.world = new rapier.World(vector(scene.gravity_m_per_s2));
    scene.bodies.forEach((body, i) => this.add(body, i));
  }

  add(body, i) {
    const { RigidBodyDesc } = this.rapier;
    const description = body.fixed ? RigidBodyDesc.fixed() : RigidBodyDesc.dynamic();
    description.setCanSleep(this.settings.sleeping);
    description.setTranslation(...body.position_m);
    description.setRotation(rotation(body.orientation_wxyz));
    if (!body.fixed) this.setMass(description, body);
    this.bodies[i] = this.world.createRigidBody(description);
    if (body.fixed) return;
    if (body.release_s > 0) this.bodies[i].setBodyType(this.rapier.RigidBodyType.Fixed, false);
    else this.setVelocity(i);
  }

  setMass(description, body) {
    const { moments_kg_m2, q_BP } = principalAxes(body.inertia_kg_m2);
    description.setAdditionalMassProperties(body.mass_kg, vector([0, 0, 0]), vector(moments_kg_m2), rotation(q_BP));
    if (!rotates(body)) description.lockRotations();
  }

  setVelocity(i) {
    const body = this.scene.bodies[i];
    this.bodies[i].setLinvel(vector(body.velocity_m_per_s), true);
    if (rotates(body)) this.bodies[i].setAngvel(vector(toWorld(body.orientation_wxyz, body.angular_velocity_body_rad_per_s)), true);
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
  }

  motion(i) {
    const body = this.bodies[i], r = body.rotation(), q_WB = [r.w, r.x, r.y, r.z];
    return { p_WB: array(body.translation()), q_WB, v_WB: array(body.linvel()), w_WB_B: toBody(q_WB, array(body.angvel())) };
  }

  release(i) {
    this.bodies[i].setBodyType(this.rapier.RigidBodyType.Dynamic, true);
    this.setVelocity(i);
  }

  touches() {
    return [];
  }

  free() {
    this.world.free();
  }
}
