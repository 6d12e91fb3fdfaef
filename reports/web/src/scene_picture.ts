// A scene drawn from the motion of its truth: shapes at one instant and the trail, as SVG in the colours of the page.
import { Loose, real } from './data';
import { svg } from './dom';

export type Vector = [number, number, number];
export interface DrawnShape { kind: string; r?: Loose; h?: Loose; half?: Loose[]; points?: Loose[]; boxes?: { half: Loose[]; p: Loose[]; q: Loose[] }[]; normal?: Loose[]; offset?: Loose }
export interface DrawnScene {
  id: string; t_end: Loose; times: Loose[];
  scene: {
    bodies: { name: string; fixed: boolean; p: Loose[]; q: Loose[]; shape: DrawnShape }[];
    joints: { a: number; b: number; pa: Loose[]; pb: Loose[] }[];
    ropes: { a: number; b: number; pa: Loose[]; pb: Loose[]; over: { axle: Loose[] }[] }[];
    forces: { kind: string; a: number; b?: number; pa: Loose[]; pb?: Loose[] }[];
  };
  poses: ({ p: Loose[]; q: Loose[] } | null)[];
  methods?: DrawnMethod[];
}
// A method beside the truth: for each body the errors of its position [m] and of its attitude (a rotation vector [rad]).
export interface DrawnMethod { id: string; steps: number; bodies: { p: Loose[]; r: Loose[] }[] }
interface Pose { p: Vector; q: number[] }
type Flat = [number, number];

const vector = (list: Loose[] | undefined, at = 0): Vector => [real(list?.[at]), real(list?.[at + 1]), real(list?.[at + 2])];
function turned(q: number[], v: Vector): Vector {  // q v q^-1
  const [w, x, y, z] = q;
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
}
const sum = (a: Vector, b: Vector): Vector => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const placed = (pose: Pose, v: Vector) => sum(pose.p, turned(pose.q, v));

// Points whose convex hull is the shape, in the body's axes. A sphere is drawn as a circle instead.
function corners(shape: DrawnShape): Vector[][] {
  const box = (half: Vector, p: Vector = [0, 0, 0], q = [1, 0, 0, 0]) => [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => sum(p, turned(q, [x * half[0], y * half[1], z * half[2]])))));
  switch (shape.kind) {
    case 'box': return [box(vector(shape.half))];
    case 'compound': return shape.boxes!.map((part) => box(vector(part.half), vector(part.p), part.q.map(real)));
    case 'mesh': return [Array.from({ length: shape.points!.length / 3 }, (_, i) => vector(shape.points, 3 * i))];
    case 'cylinder': case 'capsule': {
      const r = real(shape.r), height = real(shape.h), rings = shape.kind === 'cylinder' ? [[r, height]] : [[r, height], [0.7 * r, height + 0.7 * r], [0, height + r]];
      return [rings.flatMap(([radius, z]) => Array.from({ length: 20 }, (_, i) => i * Math.PI / 10).flatMap((a): Vector[] => [[radius * Math.cos(a), radius * Math.sin(a), z], [radius * Math.cos(a), radius * Math.sin(a), -z]]))];
    }
    default: return [];
  }
}
function hull(points: Flat[]): Flat[] {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list: Flat[]) => list.reduce<Flat[]>((kept, p) => {
    while (kept.length > 1 && (kept[kept.length - 1][0] - kept[kept.length - 2][0]) * (p[1] - kept[kept.length - 2][1]) - (kept[kept.length - 1][1] - kept[kept.length - 2][1]) * (p[0] - kept[kept.length - 2][0]) <= 0) kept.pop();
    return [...kept, p];
  }, []).slice(0, -1);
  return [...half(sorted), ...half(sorted.reverse())];
}
const edges = [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]];  // of a box

function poseAt(drawn: DrawnScene, body: number, t: number): Pose {
  const start = drawn.scene.bodies[body], path = drawn.poses[body];
  if (!path) return { p: vector(start.p), q: start.q.map(real) };
  const times = drawn.times.map(real);
  let k = times.findIndex((time) => time >= t);
  k = k < 0 ? times.length - 1 : k;
  const before = Math.max(0, k - 1), part = k > before ? Math.min(1, Math.max(0, (t - times[before]) / (times[k] - times[before]))) : 0;
  const mix = (list: Loose[], width: number, i: number, sign: number) => real(list[before * width + i]) * (1 - part) + sign * real(list[k * width + i]) * part;
  const dot = [0, 1, 2, 3].reduce((d, i) => d + real(path.q[before * 4 + i]) * real(path.q[k * 4 + i]), 0);
  const q = [0, 1, 2, 3].map((i) => mix(path.q, 4, i, dot < 0 ? -1 : 1)), size = Math.hypot(...q) || 1;
  return { p: [0, 1, 2].map((i) => mix(path.p, 3, i, 1)) as Vector, q: q.map((x) => x / size) };
}

function reach(shape: DrawnShape): number { return shape.kind === 'sphere' ? real(shape.r) : Math.max(0, ...corners(shape).flat().map((c) => Math.hypot(...c))); }

// The trail: of the centre, or of the end of a body that turns in place.
function trail(drawn: DrawnScene, body: number): Vector[] {
  const path = drawn.poses[body];
  if (!path) return [];
  const centres = Array.from({ length: path.p.length / 3 }, (_, k) => vector(path.p, 3 * k));
  const far = Math.max(...centres.map((c) => Math.hypot(c[0] - centres[0][0], c[1] - centres[0][1], c[2] - centres[0][2])));
  const shape = drawn.scene.bodies[body].shape, size = reach(shape) || (far === 0 ? 1 : 0);  // of a point that turns, its first axis
  if (far > 0.5 * size || !size) return centres;
  const tip = corners(shape).flat().reduce<Vector>((best, c) => (Math.hypot(...c) > Math.hypot(...best) ? c : best), [size, 0, 0]);
  return centres.map((p, k) => placed({ p, q: [0, 1, 2, 3].map((i) => real(path.q[4 * k + i])) }, tip));
}

// The camera looks along the direction in which the scene is thinnest where it is flat, else from above the corner.
function camera(points: Vector[]): (v: Vector) => Flat {
  const spans = [0, 1, 2].map((i) => { const list = points.map((p) => p[i]); return Math.max(...list) - Math.min(...list); });
  const most = Math.max(...spans) || 1;
  const [azimuth, height] = spans[2] < 0.02 * most ? [0, 1.1] : spans[1] < 0.02 * most ? [0.12, 0.1] : spans[0] < 0.02 * most ? [1.45, 0.1] : [0.6, 0.32];
  const [ca, sa, ch, sh] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(height), Math.sin(height)];
  return ([x, y, z]) => [x * ca + y * sa, -(z * ch + (-x * sa + y * ca) * sh)];
}

// A body that is small beside its path and turns is drawn from its own centre.
export function fromCentre(drawn: DrawnScene): DrawnScene {
  const moving = drawn.poses.flatMap((path, i) => (path ? [i] : []));
  const path = moving.length === 1 ? drawn.poses[moving[0]]! : null;
  if (!path || drawn.scene.joints.length || drawn.scene.ropes.length || drawn.scene.bodies.length > 1) return drawn;
  const turns = path.q.some((value, i) => real(value) !== real(path.q[i % 4]));
  const far = Math.max(...path.p.map((value, i) => Math.abs(real(value) - real(path.p[i % 3]))));
  if (!turns || reach(drawn.scene.bodies[moving[0]].shape) * 10 > far) return drawn;
  return { ...drawn, poses: drawn.poses.map((one) => one && { q: one.q, p: one.p.map((_, i) => one.p[i % 3]) }) };
}

// The motion of a method, with its errors `k` times as large.
export function magnified(drawn: DrawnScene, method: DrawnMethod, k: number): DrawnScene {
  const poses = drawn.poses.map((path, i) => {
    const error = method.bodies[i], start = drawn.scene.bodies[i];
    if (!error || !(path || [...error.p, ...error.r].some((x) => real(x) !== 0))) return path;
    const p: Loose[] = [], q: Loose[] = [];
    for (let s = 0; s < error.p.length / 3; s += 1) {
      const base = path ? [0, 1, 2, 3].map((j) => real(path.q[4 * s + j])) : start.q.map(real), turn = vector(error.r, 3 * s).map((a) => a * k) as Vector;
      const angle = Math.hypot(...turn), share = angle > 0 ? Math.sin(angle / 2) / angle : 0.5, w = Math.cos(angle / 2);
      const [x, y, z] = turn.map((a) => a * share), [a, b, c, d] = base;
      q.push(w * a - x * b - y * c - z * d, w * b + x * a + y * d - z * c, w * c + y * a + z * b - x * d, w * d + z * a + x * c - y * b);
      for (let j = 0; j < 3; j += 1) p.push(real(path ? path.p[3 * s + j] : start.p[j]) + k * real(error.p[3 * s + j]));
    }
    return { p, q };
  });
  return { ...drawn, poses };
}

// The largest power of ten by which errors can be drawn inside the picture: a quarter of the motion's size, or a radian.
export function fittingMagnification(drawn: DrawnScene, methods: DrawnMethod[]): number {
  const size = Math.max(...[0, 1, 2].map((axis) => {
    const places = drawn.poses.flatMap((path, i) => (path ? path.p.filter((_, j) => j % 3 === axis).map(real) : [real(drawn.scene.bodies[i].p[axis])]));
    return Math.max(...places) - Math.min(...places);
  }), 2 * Math.max(...drawn.scene.bodies.map((body) => (body.shape.kind === 'plane' ? 0 : reach(body.shape)))));
  const most = (part: 'p' | 'r') => Math.max(0, ...methods.flatMap((m) => m.bodies.flatMap((body) => body[part].map((x) => Math.abs(real(x))).filter(Number.isFinite))));
  const room = Math.min(most('p') > 0 ? (0.25 * size) / most('p') : Infinity, most('r') > 0 ? 1 / most('r') : Infinity);
  return Number.isFinite(room) && room > 1 ? 10 ** Math.floor(Math.log10(room)) : 1;
}

export interface Ghost { drawn: DrawnScene; colour: string }
export interface Picture { element: SVGElement; show: (t: number) => void; beside: (ghosts: Ghost[]) => void }

export function picture(whole: DrawnScene, label: string, width = 320, height = 220): Picture {
  const drawn = fromCentre(whole);
  const { bodies } = drawn.scene;
  const trails = bodies.map((_, body) => trail(drawn, body));
  const starts = bodies.map((_, body) => poseAt(drawn, body, 0));
  // Points that turn in place show their axes.
  const spins = bodies.map((body, i) => body.shape.kind === 'point' && !!drawn.poses[i] && drawn.poses[i]!.p.every((x, k) => x === drawn.poses[i]!.p[k % 3]));
  const solid = bodies.map((body, i) => body.shape.kind !== 'plane' && (!!drawn.poses[i] || reach(body.shape) > 0));
  const paths = bodies.flatMap((_, i) => (drawn.poses[i] ? Array.from({ length: drawn.poses[i]!.p.length / 3 }, (_, k) => vector(drawn.poses[i]!.p, 3 * k)) : []));
  const room = bodies.flatMap((body, i) => (solid[i] ? corners(body.shape).flat().map((c) => placed(starts[i], c)) : []));
  const rounds = bodies.flatMap((body, i) => (body.shape.kind === 'sphere' && solid[i] ? [starts[i].p, ...trails[i]].flatMap((p) => [-1, 1].flatMap((s): Vector[] => [sum(p, [s * real(body.shape.r), 0, 0]), sum(p, [0, 0, s * real(body.shape.r)])])) : []));
  const places = [...paths, ...trails.flat(), ...room, ...rounds, ...starts.filter((_, i) => solid[i]).map((s) => s.p),
    ...starts.flatMap((pose, i) => (spins[i] ? [-1, 1].flatMap((e): Vector[] => [sum(pose.p, [e, 0, 0]), sum(pose.p, [0, e, 0]), sum(pose.p, [0, 0, e])]) : []))].filter((p) => p.every(Number.isFinite));
  if (!places.length) places.push([0, 0, 0]);
  const flat = camera(places);
  const seen = places.map(flat);
  const low = [0, 1].map((i) => Math.min(...seen.map((p) => p[i]))), high = [0, 1].map((i) => Math.max(...seen.map((p) => p[i])));
  const scale = Math.min((width - 28) / (high[0] - low[0] || 1e-300), (height - 28) / (high[1] - low[1] || 1e-300), 1e290);
  const at = (v: Vector): Flat => { const p = flat(v); return [0, 1].map((i) => [width, height][i] / 2 + (p[i] - (low[i] + high[i]) / 2) * scale) as Flat; };
  const words = (points: Flat[]) => points.map((p) => p.map((x) => x.toFixed(1)).join(',')).join(' ');

  const ground = svg('g', { class: 'ground' }), lines = svg('g', { class: 'trail' }), moving = svg('g', { class: 'bodies' });
  for (const [i, body] of bodies.entries()) {
    if (body.shape.kind !== 'plane') continue;
    // A line through the foot of the scene's middle, along both directions of the plane.
    const n = turned(starts[i].q, vector(body.shape.normal)), foot = sum(starts[i].p, n.map((x) => x * (real(body.shape.offset) || 0)) as Vector);
    const middle = [0, 1, 2].map((k) => places.reduce((s, p) => s + p[k], 0) / places.length) as Vector;
    const gap = n.reduce((s, x, k) => s + x * (middle[k] - foot[k]), 0);
    const on = sum(middle, n.map((x) => -x * gap) as Vector);
    const along: Vector = Math.abs(n[0]) < 0.9 ? [1 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2]] : [-n[0] * n[1], 1 - n[1] * n[1], -n[1] * n[2]];
    const cross: Vector = [n[1] * along[2] - n[2] * along[1], n[2] * along[0] - n[0] * along[2], n[0] * along[1] - n[1] * along[0]];
    const long = (2 * width) / scale, wide = 0.15 * long;
    ground.append(svg('polygon', { points: words([[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([a, b]) => at(sum(on, [0, 1, 2].map((k) => a * long * along[k] + b * wide * cross[k]) as Vector)))) }));
  }
  for (const points of trails) if (points.length > 1) lines.append(svg('polyline', { points: words(points.map(at)) }));
  const ghostTrails = svg('g', { class: 'ghosts' }), ghostBodies = svg('g', { class: 'ghosts' });
  let ghosts: Ghost[] = [], now = 0;
  const showGhosts = (t: number) => ghostBodies.replaceChildren(...ghosts.flatMap(({ drawn: ghost, colour }) => bodies.flatMap((body, i): SVGElement[] => {
    if (!solid[i] || !ghost.poses[i]) return [];
    const pose = poseAt(ghost, i, t), [cx, cy] = at(pose.p);
    if (body.shape.kind === 'sphere' || body.shape.kind === 'point') return [svg('circle', { stroke: colour, cx: cx.toFixed(1), cy: cy.toFixed(1), r: Math.max(3, (real(body.shape.r) || 0) * scale).toFixed(1) }),
      ...(spins[i] ? ([[1, 0, 0], [0, 1, 0], [0, 0, 1]] as Vector[]).map((axis) => svg('polyline', { stroke: colour, points: words([pose.p, placed(pose, axis)].map(at)) })) : [])];
    return corners(body.shape).map((cloud) => svg('polygon', { stroke: colour, points: words(hull(cloud.map((c) => at(placed(pose, c))))) }));
  })));
  const beside = (list: Ghost[]) => {
    ghosts = list;
    ghostTrails.replaceChildren(...ghosts.flatMap(({ drawn: ghost, colour }) => bodies.flatMap((_, i) => { const points = trail(ghost, i); return points.length > 1 ? [svg('polyline', { stroke: colour, points: words(points.map(at)) })] : []; })));
    showGhosts(now);
  };

  const show = (t: number) => {
    const poses = bodies.map((_, body) => poseAt(drawn, body, t));
    const world = (body: number, point: Loose[] | undefined): Vector => (body >= 0 && poses[body] ? placed(poses[body], vector(point)) : vector(point));
    const parts: SVGElement[] = [];
    const line = (points: Vector[], kind: string) => parts.push(svg('polyline', { class: kind, points: words(points.map(at)) }));
    for (const rope of drawn.scene.ropes) line([world(rope.a, rope.pa), ...rope.over.map((p) => vector(p.axle)), world(rope.b, rope.pb)], 'link');
    for (const f of drawn.scene.forces) if (f.kind === 'spring') line([world(f.a, f.pa), world(f.b ?? -1, f.pb)], 'link');
    for (const joint of drawn.scene.joints) { line([poses[joint.a]?.p ?? world(-1, joint.pa), world(joint.b, joint.pb), poses[joint.b]?.p ?? world(-1, joint.pb)], 'link'); }
    for (const [i, body] of bodies.entries()) {
      if (!solid[i]) continue;
      const [cx, cy] = at(poses[i].p), kind = drawn.poses[i] ? 'body' : 'body fixed';
      if (body.shape.kind === 'sphere' || body.shape.kind === 'point') {
        if (spins[i])
          for (const axis of [[1, 0, 0], [0, 1, 0], [0, 0, 1]] as Vector[]) line([poses[i].p, placed(poses[i], axis)], 'link');
        parts.push(svg('circle', { class: kind, cx: cx.toFixed(1), cy: cy.toFixed(1), r: Math.max(3, (real(body.shape.r) || 0) * scale).toFixed(1) }));
        continue;
      }
      for (const cloud of corners(body.shape)) {
        const points = cloud.map((c) => at(placed(poses[i], c)));
        parts.push(svg('polygon', { class: kind, points: words(hull(points)) }));
        if (body.shape.kind === 'box') for (const [a, b] of edges) parts.push(svg('polyline', { class: 'edge', points: words([points[a], points[b]]) }));
      }
    }
    moving.replaceChildren(...parts);
    now = t;
    showGhosts(t);
  };
  show(0);
  const element = svg('svg', { class: 'picture', viewBox: `0 0 ${width} ${height}`, ...(label ? { role: 'img', 'aria-label': label } : { 'aria-hidden': 'true' }) }, ground, lines, ghostTrails, moving, ghostBodies);
  return { element, show, beside };
}
