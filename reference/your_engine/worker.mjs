#!/usr/bin/env node
// A physics engine in JavaScript at Atwood's table: symplectic Euler, v += h a, then x += h v; rotations by Euler's equations
// and the exponential map. reference/node/ does the rest: protocol, settings, refusals, forces of the scene, the run.
import { fileURLToPath } from "node:url";
import { serve } from "../node/protocol.mjs";
import { substepsSetting } from "../node/rival.mjs";
import { cross, length, minus, normalised, plus, principalAxes, product, scaled, toBody, toWorld, turnAbout } from
  "../node/rotation.mjs";
import { rotates, shapesMatter } from "../node/scene.mjs";

class World {
  constructor(scene) {
    this.gravity = scene.gravity_m_per_s2;
    this.bodies = scene.bodies.map((body) => ({
      body, ...principalAxes(body.inertia_kg_m2), held: body.fixed || body.release_s > 0,
      x: body.position_m, q: body.orientation_wxyz, v: body.velocity_m_per_s, w: body.angular_velocity_body_rad_per_s,
    }));
  }

  step(h, wrenches) { // wrenches: force and torque about the centre of mass, world axes, one a body; empty: none
    this.bodies.forEach((b, i) => {
      if (b.held) return;
      const { force_N = [0, 0, 0], torque_N_m = [0, 0, 0] } = wrenches[i] ?? {};
      b.v = plus(b.v, scaled(h, plus(this.gravity, scaled(1 / b.body.mass_kg, force_N))));
      b.x = plus(b.x, scaled(h, b.v));
      if (!rotates(b.body)) return;
      const w = toBody(b.q_BP, b.w), L = w.map((rate, k) => rate * b.moments_kg_m2[k]); // principal axes
      const torque = minus(toBody(b.q_BP, toBody(b.q, torque_N_m)), cross(w, L));
      b.w = toWorld(b.q_BP, w.map((rate, k) => rate + (h * torque[k]) / b.moments_kg_m2[k]));
      const rate = length(b.w);
      if (rate > 0) b.q = normalised(product(b.q, turnAbout(scaled(1 / rate, b.w), h * rate)));
    });
  }
  motion = (i) => ({ p_WB: this.bodies[i].x, q_WB: this.bodies[i].q, v_WB: this.bodies[i].v, w_WB_B: this.bodies[i].w });
  release = (i) => (this.bodies[i].held = false);
  touches = () => []; // contact points of the last step (reference/node/run.mjs)
  free = () => {};
}

await serve({
  name: "javascript", version: process.version, scalar: "double", source: "", files: [],
  folder: fileURLToPath(new URL(".", import.meta.url)),
  settings: [substepsSetting],
  presets: [{ scheme: "symplectic-euler", doc: "Symplectic Euler of free bodies, in JavaScript." }],
  refusal: (scene) => (shapesMatter(scene) ? "javascript has no contacts" : ""),
  make: (scene) => new World(scene),
  emptyStep: (_, empty = new World({ bodies: [] })) => () => empty.step(0, []),
});
