// One scene in one MjModel and MjData: motion, contacts, joints. Conventions:
// - everything is kept in double; contacts are found at the start of a step;
// - contacts are soft: a force grows with the overlap, so that a body at rest overlaps the floor a little;
// - arrays of model and data are views of WebAssembly's memory, which are lost when it grows: they are taken anew then;
// - a contact's frame has its axes in rows; the first is the normal, from geom1 to geom2, and the force is on geom2;
// - xfrc_applied is force, then torque, at the centre of mass, in world axes.
import { motionAtStart, motorEfforts, subtreeReactions } from "../node/joints.mjs";
import { cross, minus, plus, scaled, times, toBody, toWorld } from "../node/rotation.mjs";
import { Refusal, rotates } from "../node/scene.mjs";
import { closingReaction, placingJoints, setConstraints, setSoftness, tensionOf } from "./mechanism.mjs";
import { xmlOf } from "./model.mjs";

const COORDINATES = { fixed: 0, hinge: 1, slider: 1, cylindrical: 2, universal: 2, ball: 4 };
const RATES = { ...COORDINATES, ball: 3 };
const three = (values, at = 0) => [values[at], values[at + 1], values[at + 2]];

/** What every contact has; its normal from body a to body b, a < b. */
const pointOf = (contact, first, second) => ({
  body_a: Math.min(first, second),
  body_b: Math.max(first, second),
  x_m: three(contact.pos),
  normal: scaled(first < second ? 1 : -1, three(contact.frame)),
  gap_m: contact.dist,
});

export class MujocoWorld {
  ownJointForces = ["joint-spring"];

  /** `mujoco`: the package's module; `scene`: node/scene.mjs. Throws a Refusal with MuJoCo's message. */
  constructor(mujoco, scene, settings) {
    Object.assign(this, { mujoco, scene, settings, h_s: 0 });
    this.held = scene.bodies.map((body) => !body.fixed && body.release_s > 0);
    this.placing = placingJoints(scene);
    this.buffer = new mujoco.DoubleBuffer(6);
    this.build();
    scene.bodies.forEach((_, i) => this.floats(i) && this.setMotion(i, motionAtStart(scene, i)));
    scene.joints.forEach(
      (joint, j) => this.jointIds[j] >= 0 && this.setJoint(j, { q: joint.coordinates ?? [], u: joint.rates ?? [] }),
    );
    setConstraints(mujoco, scene, this.model, this.data);
  }

  build() {
    const { mujoco } = this,
      { mjOBJ_BODY, mjOBJ_JOINT } = mujoco.mjtObj;
    try {
      this.model = mujoco.MjModel.from_xml_string(xmlOf(this.scene, this.settings, this.held));
    } catch (error) {
      throw new Refusal(
        `mujoco3: ${String(error?.message ?? error)
          .split("\n")
          .filter(Boolean)
          .join(" ")}`,
      );
    }
    this.data = new mujoco.MjData(this.model);
    this.option = this.model.opt;
    this.views = {};
    const id = (kind, name) => mujoco.mj_name2id(this.model, kind.value, name);
    this.ids = this.scene.bodies.map((_, i) => id(mjOBJ_BODY, `b${i}`));
    this.jointIds = this.scene.joints.map((_, j) => id(mjOBJ_JOINT, `j${j}`));
    const owners = new Map(this.ids.map((each, i) => [each, i])),
      firstJoint = this.model.body_jntadr;
    this.owners = Array.from(this.model.geom_bodyid, (each) => owners.get(each));
    const positions = this.model.jnt_qposadr,
      velocities = this.model.jnt_dofadr;
    this.at = this.ids.map((each) => ({ q: positions[firstJoint[each]], v: velocities[firstJoint[each]] }));
    this.jointAt = this.jointIds.map((each) => ({ q: positions[each], v: velocities[each] }));
  }

  /** An array of the data, as a view that is valid now. */
  array(name, data = this.data) {
    if (data !== this.data) return data[name];
    const kept = this.views[name];
    return kept && kept.length > 0 ? kept : (this.views[name] = data[name]);
  }
  moves(i) {
    return !this.scene.bodies[i].fixed && !this.held[i];
  }
  floats(i) {
    return this.moves(i) && this.placing[i] < 0;
  }

  step(h_s, wrenches, t_s) {
    if (h_s !== this.h_s) {
      setSoftness(this.mujoco, this.settings, h_s, this.model);
      this.option.timestep = this.h_s = h_s;
    }
    this.put(wrenches, t_s, this.data);
    this.mujoco.mj_step(this.model, this.data);
    this.seen = false;
  }

  /** Applied forces and motors, which MuJoCo holds over a step. */
  put(wrenches, t_s, data) {
    const applied = wrenches.length > 0 ? this.array("xfrc_applied", data) : null;
    wrenches.forEach(({ force_N, torque_N_m }, i) => applied.set([...force_N, ...torque_N_m], 6 * this.ids[i]));
    if (!this.scene.jointForces.some(({ kind }) => kind === "joint-torque")) return;
    const efforts = this.array("qfrc_applied", data);
    efforts.fill(0);
    motorEfforts(this.scene, t_s, t_s + 0.5 * this.h_s).forEach((effort, j) => {
      const count = RATES[this.scene.joints[j].kind];
      if (this.jointIds[j] >= 0) for (let k = 0; k < count; ++k) efforts[this.jointAt[j].v + k] += effort[k];
    });
  }

  motion(i) {
    if (!this.moves(i)) return motionAtStart(this.scene, i);
    if (this.placing[i] >= 0) return this.placedMotion(i);
    const body = this.scene.bodies[i],
      { q, v } = this.at[i],
      qpos = this.array("qpos"),
      qvel = this.array("qvel");
    if (!rotates(body))
      return {
        p_WB: plus(body.position_m, three(qpos, q)),
        q_WB: body.orientation_wxyz,
        v_WB: three(qvel, v),
        w_WB_B: [0, 0, 0],
      };
    return {
      p_WB: three(qpos, q),
      q_WB: [qpos[q + 3], ...three(qpos, q + 4)],
      v_WB: three(qvel, v),
      w_WB_B: three(qvel, v + 3),
    };
  }
  setMotion(i, m) {
    const body = this.scene.bodies[i],
      { q, v } = this.at[i],
      turns = rotates(body);
    this.array("qpos").set(turns ? [...m.p_WB, ...m.q_WB] : minus(m.p_WB, body.position_m), q);
    this.array("qvel").set(turns ? [...m.v_WB, ...m.w_WB_B] : m.v_WB, v);
  }

  // After mj_step all of the data but the state is that of the step's beginning. What samples need is computed in other
  // data, so that observing a run does not change it.
  view() {
    const { mujoco, model, data } = this;
    this.other ??= new mujoco.MjData(model);
    if (this.seen) return this.other;
    this.other.time = data.time;
    for (const name of ["qpos", "qvel", "qacc_warmstart", "xfrc_applied", "qfrc_applied"]) this.other[name].set(data[name]);
    mujoco.mj_kinematics(model, this.other);
    mujoco.mj_comPos(model, this.other);
    mujoco.mj_comVel(model, this.other);
    this.seen = true;
    return this.other;
  }
  placedMotion(i) {
    const other = this.view(),
      id = this.ids[i],
      q_WB = Array.from(other.xquat.subarray(4 * id, 4 * id + 4));
    this.mujoco.mj_objectVelocity(this.model, other, this.mujoco.mjtObj.mjOBJ_XBODY.value, id, this.buffer, 0);
    const velocity = this.buffer.GetView();
    return { p_WB: three(other.xpos, 3 * id), q_WB, v_WB: three(velocity, 3), w_WB_B: toBody(q_WB, three(velocity)) };
  }

  // A held body has no joints: at its release the model is compiled again, and the state of all others is kept.
  release(i) {
    const motions = this.scene.bodies.map((_, k) => (this.floats(k) ? this.motion(k) : null));
    const joints = this.scene.joints.map((_, j) => this.joint(j));
    const t_s = this.data.time,
      lengths = this.scene.ropes.length > 0 ? Array.from(this.model.tendon_length0) : null;
    this.drop();
    motions[i] = motionAtStart(this.scene, i);
    this.held[i] = false;
    this.build();
    this.data.time = t_s;
    motions.forEach((motion, k) => motion && this.setMotion(k, motion));
    joints.forEach((state, j) => state && this.jointIds[j] >= 0 && this.setJoint(j, state));
    setConstraints(this.mujoco, this.scene, this.model, this.data);
    if (lengths) this.model.tendon_length0.set(lengths);
    if (this.h_s > 0) {
      setSoftness(this.mujoco, this.settings, this.h_s, this.model);
      this.option.timestep = this.h_s;
    }
  }

  /** use(contact, its number, the body of geom1, the body of geom2) of each contact that the last detection found. */
  eachContact(use) {
    if (this.data.ncon === 0) return;
    const contacts = this.data.contact;
    for (let c = 0; c < contacts.size(); ++c) {
      const contact = contacts.get(c),
        geom = contact.geom;
      use(contact, c, this.owners[geom[0]], this.owners[geom[1]]);
      contact.delete();
    }
    contacts.delete();
  }

  touches() {
    const all = [];
    this.eachContact((contact, c, first, second) => {
      if (contact.efc_address < 0) return;
      this.mujoco.mj_contactForce(this.model, this.data, c, this.buffer);
      const force = Array.from(this.buffer.GetView());
      if (!(force[0] > 0)) return;
      const frame = contact.frame,
        toB = first < second ? 1 : -1,
        friction = plus(scaled(force[1], three(frame, 3)), scaled(force[2], three(frame, 6)));
      all.push({
        ...pointOf(contact, first, second),
        impulse_n_N_s: force[0] * this.h_s,
        impulse_t_N_s: scaled(toB * this.h_s, friction),
        torque_N_m: [0, 1, 2].map((k) => force[3] * frame[k] + force[4] * frame[3 + k] + force[5] * frame[6 + k]),
        second,
      });
    });
    return all;
  }

  // ---- joints -------------------------------------------------------------------------------------------------------
  joint(j) {
    if (this.jointIds[j] < 0) return null;
    const { kind } = this.scene.joints[j],
      { q, v } = this.jointAt[j];
    return {
      q: Array.from(this.array("qpos").subarray(q, q + COORDINATES[kind])),
      u: Array.from(this.array("qvel").subarray(v, v + RATES[kind])),
    };
  }
  setJoint(j, { q, u }) {
    this.array("qpos").set(q, this.jointAt[j].q);
    this.array("qvel").set(u, this.jointAt[j].v);
  }
  forces() {
    const other = this.view();
    this.mujoco.mj_forward(this.model, other);
    this.mujoco.mj_rnePostConstraint(this.model, other);
    return other;
  }

  // m a = f + gravity + reactions; mj_objectAcceleration is a - gravity, of the centre of mass.
  reactions(t_s, wrenches) {
    const { mujoco, scene } = this,
      of = (motions, i) => (i < 0 ? motionAtStart(scene, -1) : motions[i]);
    this.put(wrenches, t_s, this.view());
    const other = this.forces(),
      motions = scene.bodies.map((_, i) => this.motion(i));
    const outer = scene.bodies.map((_, i) => ({
      force_N: wrenches[i]?.force_N ?? [0, 0, 0],
      torque_N_m: wrenches[i]?.torque_N_m ?? [0, 0, 0],
    }));
    const add = (i, at, force, torque = [0, 0, 0]) => {
      if (i < 0) return;
      outer[i].force_N = plus(outer[i].force_N, force);
      outer[i].torque_N_m = plus(outer[i].torque_N_m, plus(torque, cross(minus(at, motions[i].p_WB), force)));
    };
    const closing = scene.joints.map((joint, j) => {
      if (!joint.closes_loop) return { force_N: [0, 0, 0], torque_N_m: [0, 0, 0] };
      const child = motions[joint.child],
        at = plus(child.p_WB, toWorld(child.q_WB, joint.anchors_body_m[1]));
      const on = closingReaction(mujoco, scene, j, of(motions, joint.parent), child, other);
      add(joint.child, at, on.force_N, on.torque_N_m);
      add(joint.parent, at, scaled(-1, on.force_N), scaled(-1, on.torque_N_m));
      return on;
    });
    this.addContacts(other, add);
    this.addRopes(other, motions, add);
    const missing = scene.bodies.map((body, i) => {
      mujoco.mj_objectAcceleration(this.model, other, mujoco.mjtObj.mjOBJ_BODY.value, this.ids[i], this.buffer, 0);
      const acceleration = Array.from(this.buffer.GetView()),
        { q_WB, w_WB_B: w } = motions[i],
        inertia = body.inertia_kg_m2;
      const rate = plus(times(inertia, toBody(q_WB, three(acceleration))), cross(w, times(inertia, w)));
      return {
        force_N: minus(scaled(body.mass_kg, three(acceleration, 3)), outer[i].force_N),
        torque_N_m: minus(toWorld(q_WB, rate), outer[i].torque_N_m),
      };
    });
    return subtreeReactions(scene, motions, missing, closing);
  }
  addContacts(other, add) {
    const mine = this.data;
    this.data = other;
    const touches = this.touches();
    this.data = mine;
    for (const { body_a, body_b, x_m, normal, impulse_n_N_s, impulse_t_N_s, torque_N_m, second } of touches) {
      const force = scaled(1 / this.h_s, plus(scaled(impulse_n_N_s, normal), impulse_t_N_s)),
        sign = second === body_b ? 1 : -1;
      add(body_b, x_m, force, scaled(sign, torque_N_m));
      add(body_a, x_m, scaled(-1, force), scaled(-sign, torque_N_m));
    }
  }
  addRopes(other, motions, add) {
    this.scene.ropes.forEach((rope, r) => {
      const ends = rope.bodies.map((i, k) => plus(motions[i].p_WB, toWorld(motions[i].q_WB, rope.points_body_m[k])));
      const over = rope.over_m.map((pulley) => pulley.axle_m),
        next = [over[0] ?? ends[1], over.at(-1) ?? ends[0]];
      const tension = tensionOf(this.mujoco, this.scene, r, other);
      rope.bodies.forEach((i, k) => {
        const along = minus(next[k], ends[k]);
        add(i, ends[k], scaled(tension / Math.hypot(...along), along));
      });
    });
  }
  ropes() {
    const other = this.forces();
    return this.scene.ropes.map((rope, r) => ({
      tension_N: tensionOf(this.mujoco, this.scene, r, other),
      pulley_angle_rad: rope.over_m.map((pulley) => pulley.angle_rad ?? 0),
    }));
  }
  broken() {
    const slack = this.scene.ropes.length > 0 ? this.ropes().findIndex(({ tension_N }) => tension_N < 0) : -1;
    return slack < 0 ? "" : `the rope \`${this.scene.ropes[slack].name}\` would be slack`;
  }

  /** MuJoCo's warnings: buffers too small for all contacts are the ones that change a motion in silence. */
  complaints() {
    const kinds = Object.keys(this.mujoco.mjtWarning).filter((name) => name.startsWith("mjWARN")),
      found = [];
    const list = this.data.warning; // the data's own: it is not to be deleted
    kinds.forEach((name, k) => {
      const each = list.get(this.mujoco.mjtWarning[name].value ?? k);
      if (each?.number > 0) found.push(`${name} ${each.number} times`);
      each?.delete();
    });
    return found.length > 0 ? `MuJoCo warned: ${found.join(", ")}` : "";
  }

  drop() {
    this.other?.delete();
    this.other = undefined;
    this.seen = false;
    this.option.delete();
    this.data.delete();
    this.model.delete();
  }
  free() {
    this.drop();
    this.buffer.delete();
  }
}

/** Where bodies at rest overlap, or nearly (node/contacts.mjs). */
export function overlaps(mujoco, scene, settings) {
  const world = new MujocoWorld(mujoco, scene, settings),
    all = [];
  try {
    mujoco.mj_fwdPosition(world.model, world.data);
    world.eachContact((contact, _, first, second) => all.push(pointOf(contact, first, second)));
    return all;
  } finally {
    world.free();
  }
}
