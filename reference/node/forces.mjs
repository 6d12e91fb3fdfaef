// The forces of a scene other than uniform gravity, as one force at each centre of mass and one torque about it: for
// engines that lack them. They are evaluated once a step, at its start, from the engine's own state.
import { cross, dot, isZero, length, minus, plus, scaled, toWorld } from "./rotation.mjs";
import { rotates } from "./scene.mjs";

const within = (on_s, t_s) => !on_s || on_s.length === 0 || on_s.some(([from, to]) => from <= t_s && t_s < to);

class Sum {
  constructor(scene, t_s, switch_s, motions) {
    Object.assign(this, { bodies: scene.bodies, t_s, switch_s, motions });
    this.wrenches = scene.bodies.map(() => ({ force_N: [0, 0, 0], torque_N_m: [0, 0, 0] }));
  }
  push(i, force_N) {
    this.wrenches[i].force_N = plus(this.wrenches[i].force_N, force_N);
  }
  twist(i, torque_N_m) {
    this.wrenches[i].torque_N_m = plus(this.wrenches[i].torque_N_m, torque_N_m);
  }
  /** A force at a point fixed in the body also has a moment, except on a point mass. */
  pushAt(i, point_B, force_N) {
    this.push(i, force_N);
    if (rotates(this.bodies[i])) this.twist(i, cross(toWorld(this.motions[i].q_WB, point_B), force_N));
  }
  pairs(indices, along) {
    indices.forEach((a, k) =>
      indices.slice(k + 1).forEach((b) => {
        const pull = along(a, b, minus(this.motions[b].p_WB, this.motions[a].p_WB));
        this.push(a, pull);
        this.push(b, scaled(-1, pull));
      }),
    );
  }
}

function drag(f, i, sum) {
  const { q_WB, v_WB, w_WB_B } = sum.motions[i],
    u = minus(v_WB, f.wind_m_per_s);
  const strength =
    f.model === "quadratic" ? 0.5 * f.density_kg_per_m3 * f.drag_coefficient * f.area_m2 * length(u) : f.coefficient_kg_per_s;
  sum.push(i, scaled(-strength, u));
  if (f.angular_coefficient_N_m_s) sum.twist(i, toWorld(q_WB, scaled(-f.angular_coefficient_N_m_s, w_WB_B)));
}

/** Along the line for a rest length, isotropic (F = -k d) without; where the ends coincide the dashpot acts on all of u. */
function spring(f, [a, b], sum) {
  const points = [f.points_body_m?.[0] ?? [0, 0, 0], f.points_body_m?.[1] ?? [0, 0, 0]];
  const end = (i, point) => {
    const { p_WB, q_WB, v_WB, w_WB_B } = sum.motions[i];
    return { x: plus(p_WB, toWorld(q_WB, point)), v: plus(v_WB, toWorld(q_WB, cross(w_WB_B, point))) };
  };
  const one = end(a, points[0]),
    other = b === undefined ? { x: f.anchor_m, v: [0, 0, 0] } : end(b, points[1]);
  const d = minus(one.x, other.x),
    u = minus(one.v, other.v),
    l = length(d),
    damping = f.damping_N_s_per_m ?? 0;
  const along = l > 0 ? f.stiffness_N_per_m * (l - (f.rest_length_m ?? 0)) + (damping * dot(u, d)) / l : 0;
  const force_N = l > 0 ? scaled(-along / l, d) : scaled(-damping, u);
  sum.pushAt(a, points[0], force_N);
  if (b !== undefined) sum.pushAt(b, points[1], scaled(-1, force_N));
}

const kinds = {
  gravity(f, indices, sum) {
    const m = (i) => sum.bodies[i].mass_kg;
    sum.pairs(indices, (a, b, r) => {
      const r2 = dot(r, r) + f.softening_m ** 2;
      return scaled((f.constant_m3_per_kg_s2 * m(a) * m(b)) / (r2 * Math.sqrt(r2)), r);
    });
  },
  attractor(f, indices, sum) {
    for (const i of indices) {
      const r = minus(sum.motions[i].p_WB, f.center_m),
        r2 = dot(r, r);
      sum.push(i, scaled((-sum.bodies[i].mass_kg * f.mu_m3_per_s2) / (r2 * Math.sqrt(r2)), r));
    }
  },
  drag(f, indices, sum) {
    for (const i of indices) drag(f, i, sum);
  },
  spring,
  drive(f, indices, sum) {
    const phase = f.angular_frequency_rad_per_s * sum.t_s + f.phase_rad;
    for (const i of indices) sum.push(i, scaled(Math.cos(phase), f.force_N));
  },
  lorentz(f, indices, sum) {
    for (const i of indices)
      sum.push(i, scaled(sum.bodies[i].charge_C, plus(f.electric_V_per_m, cross(sum.motions[i].v_WB, f.magnetic_T))));
  },
  coulomb(f, indices, sum) {
    const c = (i) => sum.bodies[i].charge_C;
    sum.pairs(indices, (a, b, r) => {
      const r2 = dot(r, r);
      return scaled((-f.constant_N_m2_per_C2 * c(a) * c(b)) / (r2 * Math.sqrt(r2)), r);
    });
  },
  thruster(f, [i], sum) {
    if (within(f.on_s, sum.switch_s))
      sum.pushAt(i, f.point_body_m, scaled(f.thrust_N, toWorld(sum.motions[i].q_WB, f.direction_body)));
  },
  "point-force"(f, [i], sum) {
    if (within(f.on_s, sum.switch_s)) sum.pushAt(i, f.point_body_m, f.force_N);
  },
  "rotating-frame"(f, _, sum) {
    const w = f.angular_velocity_rad_per_s;
    sum.bodies.forEach((body, i) => {
      const { p_WB, v_WB } = sum.motions[i];
      sum.push(i, scaled(-body.mass_kg, plus(scaled(2, cross(w, v_WB)), cross(w, cross(w, p_WB)))));
    });
  },
  /** Henon and Heiles 1964: V = 1/2 (x^2 + y^2) + lambda (x^2 y - y^3 / 3), lambda = 1 unless given. */
  potential(f, indices, sum) {
    const lambda = f.parameters?.lambda ?? 1;
    for (const i of indices) {
      const [x, y] = sum.motions[i].p_WB;
      sum.push(i, [-x - 2 * lambda * x * y, -y - lambda * (x * x - y * y), 0]);
    }
  },
};

/**
 * One wrench a body: {force_N, torque_N_m about the centre of mass}, world axes. Thrusters and point forces are on or off
 * as they are at `switch_s`, the middle of the step.
 */
export function appliedWrenches(scene, t_s, switch_s, motions) {
  const sum = new Sum(scene, t_s, switch_s, motions);
  for (const { force, indices } of scene.forcesByIndex) kinds[force.kind](force, indices, sum);
  return sum.wrenches;
}

/** Which force of the scene is not covered, in words; empty: all are. */
export function uncoveredForce(scene) {
  for (const force of scene.forces) {
    if (!kinds[force.kind]) return `no force of the kind \`${force.kind}\``;
    if (force.kind === "drag" && !["linear", "quadratic"].includes(force.model)) return `no drag \`${force.model}\``;
    if (force.kind === "potential") {
      if (force.name !== "henon-heiles") return `no force of a potential \`${force.name}\``;
      for (const key of Object.keys(force.parameters ?? {}))
        if (key !== "lambda") return `no parameter \`${key}\` of the potential henon-heiles`;
    }
    const turning = scene.bodies.find((body) => !body.fixed && rotates(body));
    if (force.kind === "rotating-frame" && turning)
      return `rotating frames for point masses only, and \`${turning.name}\` rotates`;
  }
  return "";
}

/** "drag, spring": the kinds of force that the adapter evaluates in this scene; empty: none. */
export const namesOfForces = (scene) => [...new Set(scene.forces.map((force) => force.kind))].sort().join(", ");

/** Whether a wrench is nothing at all, so that an engine need not be told. */
export const isNothing = (wrench) => isZero(wrench.force_N) && isZero(wrench.torque_N_m);
