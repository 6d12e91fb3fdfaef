// One scene inside one engine: the loop with which all adapters run it, once observed and not timed, or timed alone.
//
// A world is an object with
//   step(h_s, wrenches, t_s)  one step from t_s on; `wrenches` (one a body; empty: none) act during it
//   motion(i)             {p_WB, q_WB, v_WB, w_WB_B} of body i, widened without loss
//   release(i)            a held body begins to move with the velocity of the scene
//   touches()             contact points with an impulse in the last step, a < b, found at its start:
//                         {body_a, body_b, x_m, normal (from a to b), gap_m, impulse_n_N_s, impulse_t_N_s (on b)};
//                         null: the engine does not tell those of that step
//   free()                gives its memory back
// and, where the engine has them,
//   joint(j)              a joint's own {q, u}; nothing: they follow from the motions of its bodies
//   ownJointForces        kinds of joint forces that are not a part of the wrenches
//   reactions(t_s, wrenches)  {force_N, torque_N_m} of each joint (joints.mjs) at the present state
//   ropes()               [{tension_N, pulley_angle_rad}]
//   broken()              why the motion is no longer that of the scene; empty: it is. Asked at samples
//   complaints()          what the engine has to say at the end of a run; empty: nothing
import { beyondExplicitDampers, explicitDampers } from "./explicit_dampers.mjs";
import { appliedWrenches, namesOfForces } from "./forces.mjs";
import { damperPower, followJoints, jointEfforts, jointRows, jointWrenches, namesOfJointForces, startOfJoints } from "./joints.mjs";
import { cross, dot, length, minus, plus, scaled, toWorld } from "./rotation.mjs";
import { shapesMatter } from "./scene.mjs";

const startOf = (body) => ({
  p_WB: body.position_m,
  q_WB: body.orientation_wxyz,
  v_WB: body.velocity_m_per_s,
  w_WB_B: body.angular_velocity_body_rad_per_s,
});

/** A world with the scene's time, releases and applied forces; a step of the plan is `substeps` of the engine's. */
class Stepper {
  constructor(scene, plan, substeps, world) {
    Object.assign(this, { scene, plan, substeps, world, h_s: plan.t_end_s / plan.steps / substeps });
    this.held = scene.bodies.flatMap((body, i) => (!body.fixed && body.release_s > 0 ? [i] : []));
    this.jointForcesHere = scene.jointForces.length > 0 && !world.ownJointForces;
    this.forced = scene.forces.length > 0 || this.jointForcesHere;
    this.joints = startOfJoints(scene);
    // The most that dampers of joints had given up to some step: 0, as dampers only take energy, unless they are explicit and
    // the steps too long for them.
    this.damperWork_J = this.givenByDampers_J = 0;
    this.follows = this.jointForcesHere;
  }
  motion(i) {
    const body = this.scene.bodies[i];
    return body.fixed || this.held.includes(i) ? startOf(body) : this.world.motion(i);
  }
  motions() {
    return this.scene.bodies.map((_, i) => this.motion(i));
  }
  wrenches(t_s) {
    if (!this.forced) return [];
    const motions = this.motions(),
      switch_s = t_s + 0.5 * this.h_s;
    const wrenches = appliedWrenches(this.scene, t_s, switch_s, motions);
    if (this.jointForcesHere) jointWrenches(this.scene, t_s, switch_s, this.joints, motions, wrenches);
    return wrenches;
  }
  /** Step n of the plan; before() and after(t_s) run around each of the engine's. */
  step(n, before, after) {
    const frames = this.plan.frame_ends_s;
    const begin_s = frames ? frameTime(this.plan, n) : 0;
    if (frames) this.h_s = (frameTime(this.plan, n + 1) - begin_s) / this.substeps;
    for (let k = 0; k < this.substeps; ++k) {
      const t_s = frames ? begin_s + this.h_s * k : this.h_s * (n * this.substeps + k);
      this.held = this.held.filter((i) => {
        const due = this.scene.bodies[i].release_s <= t_s + 0.5 * this.h_s;
        if (due) this.world.release(i);
        return !due;
      });
      before?.();
      const wrenches = this.wrenches(t_s),
        earlier = this.jointForcesHere ? this.joints.map(({ u }) => u) : null;
      this.world.step(this.h_s, wrenches, t_s);
      if (this.follows)
        followJoints(
          this.scene,
          this.joints,
          (i) => this.motion(i),
          (j) => this.world.joint?.(j),
        );
      if (earlier) this.damperWork_J += this.h_s * damperPower(this.scene, earlier, this.joints);
      this.givenByDampers_J = Math.max(this.givenByDampers_J, this.damperWork_J);
      after?.(t_s);
    }
  }
}

/** Members of a sample for joints and ropes, t_s after the start. */
function jointMembers(stepper, t_s) {
  const { scene, world, joints } = stepper,
    members = {},
    switch_s = t_s + 0.5 * stepper.h_s;
  if (joints.length > 0) {
    members.joints = jointRows(scene, joints, world.reactions?.(t_s, stepper.wrenches(t_s)));
    const efforts = jointEfforts(scene, t_s, switch_s, joints).map((each, j) => each.slice(0, joints[j].u.length));
    if (efforts.flat().some((x) => x !== 0)) members.joint_applied = efforts;
  }
  if (scene.ropes.length > 0 && world.ropes)
    members.ropes = world.ropes().map((rope) => [rope.tension_N, ...rope.pulley_angle_rad]);
  return members;
}

/** Frame k ends at frame_ends_s[k] and is taken in steps / frames equal parts. */
function frameTime({ frame_ends_s, steps }, n) {
  const parts = steps / frame_ends_s.length,
    frame = Math.floor(n / parts),
    k = n - frame * parts;
  const begin_s = frame === 0 ? 0 : frame_ends_s[frame - 1];
  return k === 0 ? begin_s : begin_s + ((frame_ends_s[frame] - begin_s) * k) / parts;
}

function longestStep(plan) {
  if (!plan.frame_ends_s) return plan.t_end_s / plan.steps;
  const parts = plan.steps / plan.frame_ends_s.length;
  return plan.frame_ends_s.reduce((most, end, k, ends) => Math.max(most, (end - (k > 0 ? ends[k - 1] : 0)) / parts), 0);
}

const isFinite13 = (m) => [...m.p_WB, ...m.q_WB, ...m.v_WB, ...m.w_WB_B].every(Number.isFinite);

function notFinite(stepper, steps) {
  const bad = stepper.scene.bodies.findIndex((_, i) => !isFinite13(stepper.motion(i)));
  return bad < 0 ? "" : `the state of \`${stepper.scene.bodies[bad].name}\` is not finite after ${steps} steps`;
}

/** The velocity of body b against body a at a contact point. */
function relativeVelocity(touch, a, b) {
  const velocity = (m) => plus(m.v_WB, cross(toWorld(m.q_WB, m.w_WB_B), minus(touch.x_m, m.p_WB)));
  return minus(velocity(b), velocity(a));
}

/**
 * Rows of contacts of a sample: forces are the last step's mean; the gap goes on with the velocity that it ended with.
 * Undefined: not told.
 */
function contactRows(stepper) {
  return stepper.world.touches()?.map((touch) => {
    const u = relativeVelocity(touch, stepper.motion(touch.body_a), stepper.motion(touch.body_b));
    return [
      touch.body_a,
      touch.body_b,
      ...touch.x_m,
      ...touch.normal,
      touch.gap_m + stepper.h_s * dot(u, touch.normal),
      touch.impulse_n_N_s / stepper.h_s,
      ...scaled(1 / stepper.h_s, touch.impulse_t_N_s),
    ];
  });
}

/**
 * Impacts: a pair with an impulse in this step and none in the step before. After a step whose contacts are not told, a pair
 * that lasts cannot be known from a new one: then no impact of the run is told.
 */
class ImpactLog {
  last = new Set();
  events = [];
  told = true;
  before(stepper) {
    if (this.told) this.motions = stepper.motions();
  }
  after(t_s, stepper) {
    if (!this.told) return;
    const touches = stepper.world.touches(),
      met = new Map();
    if (touches === null) {
      this.told = false;
      this.events = [];
      return;
    }
    for (const touch of touches) {
      if (!(touch.impulse_n_N_s > 0)) continue;
      const key = `${touch.body_a} ${touch.body_b}`,
        pair = met.get(key) ?? { touch, n: 0, t: 0 };
      if (touch.impulse_n_N_s > pair.touch.impulse_n_N_s) pair.touch = touch;
      pair.n += touch.impulse_n_N_s;
      pair.t += length(touch.impulse_t_N_s);
      met.set(key, pair);
    }
    for (const [key, { touch, n, t }] of met) {
      if (this.last.has(key)) continue;
      const { body_a, body_b, x_m, normal } = touch;
      this.events.push({
        kind: "impact",
        t_s,
        body_a,
        body_b,
        x_m,
        normal,
        impulse_n_N_s: n,
        impulse_t_N_s: t,
        vn_before_m_per_s: dot(relativeVelocity(touch, this.motions[body_a], this.motions[body_b]), normal),
        vn_after_m_per_s: dot(relativeVelocity(touch, stepper.motion(body_a), stepper.motion(body_b)), normal),
      });
    }
    this.last = new Set(met.keys());
  }
}

function accuracyPass(make, scene, plan, substeps, put) {
  const world = make(true),
    stepper = new Stepper(scene, plan, substeps, world),
    stride = plan.steps / plan.samples;
  const log = shapesMatter(scene) ? new ImpactLog() : null;
  stepper.follows = scene.joints.length > 0; // their angles are unwrapped
  const sample = (k) => {
    const line = {
      t_s: (plan.t_end_s * k) / plan.samples,
      bodies: stepper.motions().map((m) => [...m.p_WB, ...m.q_WB, ...m.v_WB, ...m.w_WB_B]),
      events: [], // told at the end: until then a step may show that none are
    };
    Object.assign(line, jointMembers(stepper, line.t_s));
    if (k > 0 && log) line.contacts = contactRows(stepper);
    put(line);
  };
  const ended = (outcome) => ({ ...outcome, events: log?.events ?? [], impactsTold: log?.told ?? true });
  try {
    sample(0);
    for (let n = 1; n <= plan.steps; ++n) {
      stepper.step(n - 1, log && (() => log.before(stepper)), log && ((t_s) => log.after(t_s, stepper)));
      if (n % stride !== 0) continue;
      const reason = notFinite(stepper, n);
      if (reason) return ended({ status: "not finite", reason, steps_taken: n });
      const broken = world.broken?.();
      if (broken)
        return ended({
          status: "diverged",
          reason: `${broken} at t = ${(plan.t_end_s * n) / plan.steps} s`,
          steps_taken: n,
        });
      sample(n / stride);
    }
    const { givenByDampers_J } = stepper;
    return ended({ status: "ok", reason: "", steps_taken: plan.steps, complaints: world.complaints?.(), givenByDampers_J });
  } finally {
    world.free();
  }
}

/** Steps of one run, with the nanoseconds of all of them, or of each. */
function timedRun(make, scene, plan, substeps, each) {
  const world = make(false),
    stepper = new Stepper(scene, plan, substeps, world),
    ends = [];
  try {
    const start = process.hrtime.bigint();
    for (let n = 0; n < plan.steps; ++n) {
      stepper.step(n);
      if (each) ends.push(process.hrtime.bigint());
    }
    const stop = process.hrtime.bigint(),
      reason = notFinite(stepper, plan.steps);
    return {
      busy_ns: Number(stop - start),
      step_ns: ends.map((t, k) => Number(t - (k === 0 ? start : ends[k - 1]))),
      reason,
    };
  } finally {
    world.free();
  }
}

/**
 * The outcome of a run request (`done` of the protocol). `make(observe)` builds a world; `put` takes each sample. The
 * first of the timed runs is not counted: it warms caches and the compiler of JavaScript.
 */
export function runWorld(makeWorld, scene, request, substeps, put) {
  let ownJointForces = [];
  const make = (observe) => {
    const world = makeWorld(observe);
    ownJointForces = world.ownJointForces ?? [];
    return world;
  };
  const plan = request,
    count = request.pass === "timing" ? request.repeats + 1 : 1;
  const withDampers = (outcome, givenByDampers_J = 0) => {
    const dampers = explicitDampers(scene, !ownJointForces.includes("joint-spring"));
    const beyond = beyondExplicitDampers(dampers, longestStep(plan) / substeps);
    if (beyond && givenByDampers_J > 0 && outcome.status === "ok") {
      const gave = `the dampers of joints gave ${Number(givenByDampers_J.toPrecision(3))} J, and can only take energy`;
      return { ...outcome, status: "diverged", reason: `${gave}; ${beyond}` };
    }
    return { ...outcome, reason: [outcome.reason, beyond].filter(Boolean).join("; ") };
  };
  let done = { status: "ok", reason: "", steps_taken: plan.steps, busy_ns: [] };
  if (request.pass === "accuracy") {
    done = { busy_ns: [], ...accuracyPass(make, scene, plan, substeps, put) };
  } else {
    for (let k = 0; k < count; ++k) {
      const run = timedRun(make, scene, plan, substeps, request.pass === "profile");
      if (run.reason) return withDampers({ ...done, status: "not finite", reason: run.reason, busy_ns: [] });
      if (request.pass === "profile") done.step_ns = run.step_ns;
      else if (k > 0) done.busy_ns.push(run.busy_ns);
    }
  }
  const { complaints, impactsTold = true, givenByDampers_J, ...rest } = done;
  done = rest;
  const names = [namesOfForces(scene), namesOfJointForces(scene, ownJointForces)].filter(Boolean).join(", ");
  if (names) {
    done.rate_evaluations = done.steps_taken * substeps;
    if (done.status === "ok") done.reason = `forces evaluated by the adapter once a step: ${names}`;
  }
  const untold = impactsTold ? "" : "impacts are not told, as the engine does not tell the impulses of every step's contacts";
  if (done.status === "ok") done.reason = [done.reason, complaints, untold].filter(Boolean).join("; ");
  return withDampers(done, givenByDampers_J);
}
