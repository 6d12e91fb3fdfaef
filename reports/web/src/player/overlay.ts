// Lines and words over the solids: trails, joints, ropes, springs, arrows, axes, the scale bar. In front of everything, so
// that none of it is hidden inside a body.
import { Camera } from './camera';
import { Event, Force, Joint } from './data';
import { Motion } from './motion';
import { Ink } from './svg_ink';
import { Shown, switchOf } from './switches';
import { Quat, Vec, add, cross, dot, length, scale, sub, turn, unit } from './vectors';

export interface Frame { camera: Camera; motion: Motion; t: number; visible: boolean[]; shown: Shown; size: number; hold: number; colour: (run: number) => string; ink: string; soft: string; panel: string; force: string }

const kTrailPoints = 60_000;

export function metres(x: number): string {
  const units: [number, string][] = [[1e9, 'e9 m'], [1e3, 'km'], [1, 'm'], [1e-2, 'cm'], [1e-3, 'mm'], [1e-6, '\u00b5m'], [1e-9, 'nm']];
  if (x >= 1e7 || x < 1e-10) return `${x.toExponential(0).replace('+', '')} m`;
  const [size, name] = units.find(([least]) => x >= least * 0.9999 && least < 1e9) ?? units[6];
  return `${Number((x / size).toPrecision(3))} ${name}`;
}

export class Overlay {
  readonly canvas = document.createElement('canvas');
  private ink: Ink = this.canvas.getContext('2d')!;
  private ratio = 1;
  private trails: Vec[][][] = [];  // run, body, point
  private trailOf = NaN;           // the magnification that they were made for
  private stride = 1;
  private largest = { force: 0, impulse: 0, thrust: 0 };

  constructor(private motion: Motion) {
    for (const run of motion.runs) {
      for (const contact of run.contacts ?? []) this.largest.force = Math.max(this.largest.force, Math.abs(contact[7]));
      for (const event of run.events) this.largest.impulse = Math.max(this.largest.impulse, Math.hypot(event[10], event[11]));
    }
    for (const force of motion.page.scene.forces) this.largest.thrust = Math.max(this.largest.thrust, force.size ?? 0, force.force ? length(force.force) : 0);
  }

  resize(width: number, height: number, ratio: number): void {
    this.ratio = ratio;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  // Once on `ink` instead of the screen.
  drawOn(ink: Ink, frame: Frame): void {
    const screen = this.ink;
    this.ink = ink;
    this.draw(frame);
    this.ink = screen;
  }
  draw(frame: Frame): void {
    const { camera, shown } = frame, ink = this.ink;
    ink.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    ink.clearRect(0, 0, camera.width, camera.height);
    ink.lineJoin = 'round';
    ink.lineCap = 'round';
    const project = camera.projection(), near = camera.distance * 0.02;
    const line = (points: Vec[], colour: string, width: number, dash: number[] = [], opacity = 1) => {
      const seen = points.map(project);
      ink.strokeStyle = colour;
      ink.lineWidth = width;
      ink.setLineDash(dash);
      ink.globalAlpha = opacity;
      ink.beginPath();
      let pen = false;
      for (const [x, y, depth] of seen) {
        if (depth < near) { pen = false; continue; }
        if (pen) ink.lineTo(x, y); else ink.moveTo(x, y);
        pen = true;
      }
      ink.stroke();
      ink.setLineDash([]);
      ink.globalAlpha = 1;
    };
    if (shown.trails) this.drawTrails(frame, line);
    this.drawLinks(frame, line, project);
    this.drawContacts(frame, project);
    this.drawForces(frame, project);
    if (shown.names) this.drawNames(frame, project);
    if (shown.axes) this.drawAxes(frame);
    this.drawScale(frame);
  }

  private drawTrails({ motion, t, visible, colour, ink }: Frame, line: (p: Vec[], colour: string, width: number, dash?: number[], opacity?: number) => void): void {
    if (this.trailOf !== motion.magnified) this.makeTrails();
    const [at] = motion.at(t);
    motion.runs.forEach((run, r) => {
      if (!visible[r]) return;
      const end = Math.min(at, run.frames - 1);
      for (const [slot, points] of this.trails[r].entries()) {
        const kept = points.slice(0, Math.floor(end / this.stride) + 1);
        if (motion.reaches(r, t)) kept.push(motion.pose(r, motion.page.motion.moving[slot], t).p);
        if (kept.length > 1) line(kept, r ? colour(r) : ink, r ? 1.6 : 1.4, [], r ? 0.85 : 0.5);
      }
    });
  }
  private makeTrails(): void {
    const { motion } = this, bodies = motion.page.motion.moving;
    this.trailOf = motion.magnified;
    this.stride = Math.max(1, Math.ceil(motion.runs.length * bodies.length * motion.frames / kTrailPoints));
    this.trails = motion.runs.map((run, r) => bodies.map((body) => {
      const points: Vec[] = [];
      for (let f = 0; f < run.frames; f += this.stride) points.push(motion.pose(r, body, motion.t[f]).p);
      return points;
    }));
  }

  private anchor(frame: Frame, run: number, body: number, point: Vec): { p: Vec; q: Quat } {
    if (body < 0) return { p: point, q: [1, 0, 0, 0] };
    const { p, q } = frame.motion.pose(run, body, frame.t);
    return { p: add(p, turn(q, point)), q };
  }

  private drawLinks(frame: Frame, line: (p: Vec[], colour: string, width: number, dash?: number[], opacity?: number) => void, project: (p: Vec) => Vec): void {
    const { scene } = frame.motion.page;
    frame.motion.runs.forEach((_, r) => {
      if (!frame.visible[r]) return;
      const tint = r ? frame.colour(r) : frame.ink;
      for (const rope of scene.ropes) {
        const from = this.anchor(frame, r, rope.a, rope.pa).p, to = this.anchor(frame, r, rope.b, rope.pb).p;
        line(ropePath(from, to, rope.over), tint, 1.6, [], 0.9);
        for (const { r: radius, axle, axis } of rope.over) if (radius > 0) line(circle(axle, axis, radius), frame.soft, 1.5);
      }
      if (frame.shown['other-forces']) for (const force of scene.forces) {
        if (force.kind !== 'spring') continue;
        line(zigzag(this.anchor(frame, r, force.a, force.pa).p, this.anchor(frame, r, force.b, force.pb).p, frame.size * 0.018, frame.camera), tint, 1.3, [], 0.85);
      }
      if (!frame.shown.joints) return;
      for (const joint of scene.joints) this.drawJoint(frame, r, joint, tint, line, project);
    });
    if (frame.shown['other-forces']) for (const force of scene.forces) if (force.kind === 'attractor') this.disc(project(force.pa), 5, frame.soft);
  }

  private drawJoint(frame: Frame, r: number, joint: Joint, tint: string, line: (p: Vec[], colour: string, width: number, dash?: number[], opacity?: number) => void, project: (p: Vec) => Vec): void {
    const child = this.anchor(frame, r, joint.b, joint.pb), parent = this.anchor(frame, r, joint.a, joint.pa), reach = frame.size * 0.06;
    const along = (q: Quat, axis: Vec, middle: Vec) => line([add(middle, scale(turn(q, axis), -reach)), add(middle, scale(turn(q, axis), reach))], r ? tint : frame.force, 1.5, [5, 3]);
    if (joint.axis_b) along(child.q, joint.axis_b, child.p);
    if (joint.axis_a) along(parent.q, joint.axis_a, parent.p);
    if (length(sub(child.p, parent.p)) > 1e-4 * frame.size) line([parent.p, child.p], tint, 1, [2, 3], 0.8);
    // A thin line from the child's centre to its joint: of point masses and rods nothing else is seen.
    line([child.p, frame.motion.pose(r, joint.b, frame.t).p], tint, 1.2, [], 0.5);
    this.disc(project(child.p), joint.kind === 'ball' ? 4.5 : 3.5, r ? tint : frame.force);
  }

  private disc([x, y, depth]: Vec, radius: number, colour: string): void {
    if (depth <= 0) return;
    this.ink.fillStyle = colour;
    this.ink.beginPath();
    this.ink.arc(x, y, radius, 0, 2 * Math.PI);
    this.ink.fill();
  }

  // An arrow from a place along a direction, `size` pixels long where it is seen from the side.
  private arrow(project: (p: Vec) => Vec, camera: Camera, from: Vec, direction: Vec, size: number, colour: string, opacity = 1): void {
    const metre = size / camera.pixels, a = project(from), b = project(add(from, scale(unit(direction), metre)));
    if (a[2] <= 0 || b[2] <= 0) return;
    const dx = b[0] - a[0], dy = b[1] - a[1], n = Math.hypot(dx, dy);
    this.ink.globalAlpha = opacity;
    if (n < 3) this.disc(a, 2.5, colour);
    else {
      const x = dx / n, y = dy / n, head = Math.min(8, 0.5 * n);
      this.ink.strokeStyle = this.ink.fillStyle = colour;
      this.ink.lineWidth = 2.2;
      this.ink.beginPath();
      this.ink.moveTo(a[0], a[1]);
      this.ink.lineTo(b[0] - x * head, b[1] - y * head);
      this.ink.stroke();
      this.ink.beginPath();
      this.ink.moveTo(b[0], b[1]);
      this.ink.lineTo(b[0] - x * head - y * head * 0.5, b[1] - y * head + x * head * 0.5);
      this.ink.lineTo(b[0] - x * head + y * head * 0.5, b[1] - y * head - x * head * 0.5);
      this.ink.fill();
    }
    this.ink.globalAlpha = 1;
  }

  private drawContacts(frame: Frame, project: (p: Vec) => Vec): void {
    const { motion, t, hold, camera, shown } = frame;
    motion.runs.forEach((run, r) => {
      if (!frame.visible[r]) return;
      const tint = r ? frame.colour(r) : frame.force, every = run.contacts_every ?? 1;
      const now = Math.floor(Math.min(motion.at(t)[0] + (motion.at(t)[1] >= 1 ? 1 : 0), run.frames - 1) / every) * every;
      if (motion.reaches(r, t)) for (const c of run.contacts ?? []) {
        if (c[0] !== now) continue;
        const at: Vec = [c[1], c[2], c[3]];
        if (shown.contacts) this.disc(project(at), 2.5, tint);
        if (shown.normals) this.arrow(project, camera, at, [c[4], c[5], c[6]], 14 + 46 * Math.sqrt(Math.abs(c[7]) / (this.largest.force || 1)), tint, 0.9);
        const friction: Vec = [c[8], c[9], c[10]], size = length(friction);
        if (shown.friction && size > 1e-3 * this.largest.force) this.arrow(project, camera, at, friction, 10 + 46 * Math.sqrt(size / (this.largest.force || 1)), tint, 0.55);
      }
      for (const event of run.events) {
        const age = t - event[0];
        if (age < 0 || age > hold || !(event[1] === 'impact' ? shown.impulses : shown.contacts)) continue;
        this.drawImpulse(frame, project, event, tint, 1 - 0.8 * age / hold);
      }
    });
  }
  private drawImpulse(frame: Frame, project: (p: Vec) => Vec, event: Event, tint: string, opacity: number): void {
    const at: Vec = [event[4], event[5], event[6]], seen = project(at);
    if (seen[2] <= 0) return;
    this.ink.globalAlpha = opacity;
    this.ink.strokeStyle = tint;
    this.ink.lineWidth = 1.5;
    this.ink.beginPath();
    this.ink.arc(seen[0], seen[1], 6 + 10 * (1 - opacity), 0, 2 * Math.PI);
    this.ink.stroke();
    this.ink.globalAlpha = 1;
    const share = Math.sqrt(Math.hypot(event[10], event[11]) / (this.largest.impulse || 1));
    if (event[1] === 'impact') this.arrow(project, frame.camera, at, [event[7], event[8], event[9]], 16 + 50 * share, tint, opacity);
    else this.label(event[1], seen[0] + 10, seen[1] - 8, frame.ink, frame.panel);  // the ring has the run's colour
  }

  private drawForces(frame: Frame, project: (p: Vec) => Vec): void {
    const { motion, t, camera } = frame;
    motion.runs.forEach((_, r) => {
      if (!frame.visible[r] || !motion.reaches(r, t)) return;
      for (const force of motion.page.scene.forces) {
        if (force.kind === 'spring' || force.kind === 'attractor' || !frame.shown[switchOf(force)]) continue;
        if (force.on?.length && !force.on.some(([from, to]) => t >= from && t < to)) continue;
        const { p, q } = motion.pose(r, force.a, t), vector = forceNow(force, q, t), size = length(vector);
        if (!(size > 0)) continue;
        const at = force.pa ? add(p, turn(q, force.pa)) : p;
        this.arrow(project, camera, at, vector, 16 + 50 * Math.sqrt(size / (this.largest.thrust || 1)), r ? frame.colour(r) : frame.force, 0.9);
      }
    });
  }

  private drawNames(frame: Frame, project: (p: Vec) => Vec): void {
    const run = Math.max(0, frame.visible.indexOf(true));
    for (const [i, body] of frame.motion.page.scene.bodies.entries()) {
      if (body.shape.kind === 'plane' || i > 200) continue;
      const [x, y, depth] = project(frame.motion.pose(run, i, frame.t).p);
      if (depth > 0) this.label(body.name, x + 9, y - 9, frame.ink, frame.panel);
    }
  }

  private label(text: string, x: number, y: number, colour: string, halo?: string): void {
    this.ink.font = '12px system-ui, "DejaVu Sans", sans-serif';
    this.ink.textBaseline = 'middle';
    if (halo) {
      this.ink.lineWidth = 3;
      this.ink.strokeStyle = halo;
      this.ink.strokeText(text, x, y);
    }
    this.ink.fillStyle = colour;
    this.ink.fillText(text, x, y);
  }

  private drawAxes({ camera, ink, force, motion, panel }: Frame): void {
    const axes = camera.axes(), x0 = 46, y0 = camera.height - 74, gravity = motion.page.scene.gravity;
    const draw = (direction: Vec, name: string, colour: string, reach: number) => {
      const [dx, dy] = [axes[0], axes[1]].map((axis) => axis[0] * direction[0] + axis[1] * direction[1] + axis[2] * direction[2]);
      this.ink.strokeStyle = colour;
      this.ink.lineWidth = 2;
      this.ink.beginPath();
      this.ink.moveTo(x0, y0);
      this.ink.lineTo(x0 + dx * reach, y0 - dy * reach);
      this.ink.stroke();
      this.label(name, x0 + dx * (reach + 10) - 4, y0 - dy * (reach + 10), colour, panel);
    };
    draw([1, 0, 0], 'x', ink, 26);
    draw([0, 1, 0], 'y', ink, 26);
    draw([0, 0, 1], 'z', ink, 26);
    if (length(gravity) > 0) draw(unit(gravity), 'g', force, 20);
  }

  private drawScale({ camera, ink, panel }: Frame): void {
    const wanted = 110 / camera.pixels, power = 10 ** Math.floor(Math.log10(wanted)), size = [5, 2, 1].map((n) => n * power).find((n) => n <= wanted) ?? power;
    const wide = size * camera.pixels, x = 20, y = camera.height - 20;
    for (const [colour, width] of [[panel, 5], [ink, 2]] as [string, number][]) {
      this.ink.strokeStyle = colour;
      this.ink.lineWidth = width;
      this.ink.beginPath();
      this.ink.moveTo(x, y - 5);
      this.ink.lineTo(x, y);
      this.ink.lineTo(x + wide, y);
      this.ink.lineTo(x + wide, y - 5);
      this.ink.stroke();
    }
    this.label(metres(size), x + wide + 8, y - 3, ink, panel);
    this.canvas.dataset.scale = `${size}`;
  }
}

function forceNow(force: Force, q: Quat, t: number): Vec {
  if (force.kind === 'thruster') return scale(turn(q, force.direction), force.size);
  return force.kind === 'drive' ? scale(force.force, Math.cos(force.w * t + force.phase)) : force.force;
}

function zigzag(a: Vec, b: Vec, width: number, camera: Camera): Vec[] {
  const along = sub(b, a), [, , back] = camera.axes();
  const side = unit([along[1] * back[2] - along[2] * back[1], along[2] * back[0] - along[0] * back[2], along[0] * back[1] - along[1] * back[0]]);
  const points: Vec[] = [a], turns = 12;
  for (let i = 0; i <= turns; i += 1) points.push(add(add(a, scale(along, 0.12 + 0.76 * i / turns)), scale(side, i % 2 ? width : -width)));
  return [...points, b];
}

function circle(middle: Vec, axis: Vec, radius: number): Vec[] {
  const one: Vec = Math.abs(axis[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
  const a = unit([axis[1] * one[2] - axis[2] * one[1], axis[2] * one[0] - axis[0] * one[2], axis[0] * one[1] - axis[1] * one[0]]);
  const b: Vec = [axis[1] * a[2] - axis[2] * a[1], axis[2] * a[0] - axis[0] * a[2], axis[0] * a[1] - axis[1] * a[0]];
  return Array.from({ length: 41 }, (_, i) => add(middle, add(scale(a, radius * Math.cos(i * Math.PI / 20)), scale(b, radius * Math.sin(i * Math.PI / 20)))));
}

// Round each pulley on the rope's side of it, towards the middles of its neighbours: a drawing, not the path that sets the length.
function ropePath(from: Vec, to: Vec, over: { r: number; axle: Vec; axis: Vec }[]): Vec[] {
  const nodes = [from, ...over.map((pulley) => pulley.axle), to], points: Vec[] = [from];
  over.forEach(({ r, axle, axis }, i) => {
    if (!(r > 0)) { points.push(axle); return; }
    // axis x (point - axle) points along the rope, so point - axle = r (along x axis).
    const side = (v: Vec) => scale(unit([v[1] * axis[2] - v[2] * axis[1], v[2] * axis[0] - v[0] * axis[2], v[0] * axis[1] - v[1] * axis[0]]), r);
    const into = side(sub(axle, nodes[i])), out = side(sub(nodes[i + 2], axle)), ahead = cross(axis, into);
    // The rope moves on by positive angles about the axis.
    const angle = (Math.atan2(dot(out, ahead), dot(out, into)) + 2 * Math.PI) % (2 * Math.PI);
    for (let k = 0; k <= 24; k += 1) points.push(add(axle, add(scale(into, Math.cos(angle * k / 24)), scale(ahead, Math.sin(angle * k / 24)))));
  });
  return [...points, to];
}
