// The steps that Jolt and Rapier take of a free body, written anew, in double and rounded to float after each operation:
// whether an attitude that does not converge is the integrator's or float's doing (docs/jolt.md, docs/rapier.md).
//
//   ./atwood describe free-box-complex --json | node validation/tests/under_node/free_body_steps.mjs [STEPS ...]
//
// prints as CSV the error of the attitude [rad] at the end and the relative drift of the rotational energy, beside RK4 with
// 400 000 steps. The body has its principal axes along those of the scene, and no torque. Steps are the engine's inner ones:
// Rapier takes `solver_iterations` of them in a step.
import { readFileSync } from "node:fs";

/** Arithmetic in which `round` follows each operation: of numbers, three-vectors and quaternions w, x, y, z. */
function arithmetic(round) {
  const r = round,
    scaled = (s, a) => a.map((x) => r(s * x)),
    plus = (a, b) => a.map((x, k) => r(x + b[k])),
    each = (a, b, f) => a.map((x, k) => r(f(x, b[k])));
  const sum = (terms) => terms.reduce((total, x) => r(total + x));
  const dot = (a, b) => sum(a.map((x, k) => r(x * b[k])));
  const less = (a, b, c, d) => r(r(a * b) - r(c * d));
  const cross = (a, b) => [less(a[1], b[2], a[2], b[1]), less(a[2], b[0], a[0], b[2]), less(a[0], b[1], a[1], b[0])];
  const product = ([w, ...u], [s, ...v]) => [
    r(r(w * s) - dot(u, v)),
    ...plus(plus(scaled(w, v), scaled(s, u)), cross(u, v)),
  ];
  const normalised = (q) => scaled(r(1 / r(Math.sqrt(dot(q, q)))), q);
  const conjugate = ([w, x, y, z]) => [w, -x, -y, -z];
  const turned = (q, v) => product(product(q, [0, ...v]), conjugate(q)).slice(1);
  return { r, scaled, plus, each, dot, cross, product, normalised, conjugate, turned };
}

/** L' = -w x L by Euler's step in body axes, L then scaled to its length; w in world axes before and after. */
function gyroscopic({ r, scaled, plus, each, dot, cross, conjugate, turned }, moments, q, w, h) {
  const rate = turned(conjugate(q), w),
    momentum = each(moments, rate, (i, x) => i * x);
  const next = plus(momentum, scaled(-h, cross(rate, momentum)));
  const kept = scaled(r(Math.sqrt(r(dot(momentum, momentum) / dot(next, next)))), next);
  return turned(q, each(kept, moments, (l, i) => l / i));
}

/** Jolt turns by the angle |w| h about w, Rapier by the linear part of it; both in world axes. */
const turns = {
  jolt({ r, scaled, dot, product, normalised }, q, w, h) {
    const rate = r(Math.sqrt(dot(w, w))),
      half = r(r(rate * h) / 2);
    return normalised(product([r(Math.cos(half)), ...scaled(r(r(Math.sin(half)) / rate), w)], q));
  },
  rapier({ r, scaled, plus, product, normalised }, q, w, h) {
    return normalised(plus(q, scaled(r(h / 2), product([0, ...w], q))));
  },
};

/** {q, w} after t_s, by `steps` of `engine`; w in world axes. */
function stepped(engine, round, { moments, q, w_B }, t_s, steps) {
  const numbers = arithmetic(round),
    narrow = (values) => values.map(round),
    h = round(t_s / steps),
    inertia = narrow(moments);
  let at = narrow(q),
    w = numbers.turned(at, narrow(w_B));
  for (let n = 0; n < steps; ++n) {
    w = gyroscopic(numbers, inertia, at, w, h);
    at = turns[engine](numbers, at, w, h);
  }
  return { q: at, w };
}

const exact = arithmetic((x) => x);

/** The attitude after t_s by the Runge-Kutta method of order 4. */
function attitude({ moments, q, w_B }, t_s, steps = 400000) {
  const { plus, scaled, cross, product, each, normalised } = exact,
    h = t_s / steps;
  const rates = (y) => {
    const w = y.slice(4),
      torque = cross(each(moments, w, (i, x) => i * x), w);
    return [...scaled(0.5, product(y.slice(0, 4), [0, ...w])), ...each(torque, moments, (t, i) => t / i)];
  };
  let y = [...q, ...w_B];
  for (let n = 0; n < steps; ++n) {
    const a = rates(y),
      b = rates(plus(y, scaled(h / 2, a))),
      c = rates(plus(y, scaled(h / 2, b))),
      d = rates(plus(y, scaled(h, c)));
    y = y.map((x, k) => x + (h / 6) * (a[k] + 2 * b[k] + 2 * c[k] + d[k]));
  }
  return normalised(y.slice(0, 4));
}

function angleBetween(a, b) {
  const [w, ...v] = exact.product(exact.conjugate(exact.normalised(a)), b);
  return 2 * Math.atan2(Math.sqrt(exact.dot(v, v)), Math.abs(w));
}

function energy({ moments }, { q, w }) {
  const rate = exact.turned(exact.conjugate(q), w);
  return exact.dot(rate, exact.each(moments, rate, (i, x) => i * x)) / 2;
}

const { scene, run } = JSON.parse(readFileSync(0, "utf8")),
  [only, ...others] = scene.bodies;
const [a, xy, xz, yx, b, yz, zx, zy, c] = only.inertia_kg_m2;
if (others.length > 0 || [xy, xz, yx, yz, zx, zy].some((x) => x !== 0) || scene.forces.length > 0)
  throw new Error("expected a scene of one body with its principal axes along its own, and no forces");
const body = { moments: [a, b, c], q: only.orientation_wxyz, w_B: only.angular_velocity_body_rad_per_s };
const wanted = process.argv.slice(2).map(Number),
  ladder = wanted.length > 0 ? wanted : [480, 960, 1920, 3840, 7680, 15360];
if (!ladder.every((steps) => Number.isInteger(steps) && steps > 0)) throw new Error("STEPS: expected whole numbers above 0");
const truth = attitude(body, run.t_end_s),
  start = energy(body, { q: body.q, w: exact.turned(body.q, body.w_B) });
console.log("engine,arithmetic,steps,attitude_error_rad,energy_drift");
for (const engine of Object.keys(turns))
  for (const [name, round] of [["double", (x) => x], ["float", Math.fround]])
    for (const steps of ladder) {
      const end = stepped(engine, round, body, run.t_end_s, steps);
      console.log([engine, name, steps, angleBetween(end.q, truth), energy(body, end) / start - 1].join(","));
    }
