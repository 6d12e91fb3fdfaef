// Poses at any time. Between frames positions run along a cubic through the neighbouring frames, or straight where the
// motion has impacts, and attitudes turn at a constant rate (on SO(3)). Runs other than the first are the first plus their
// stored differences, `magnified` times.
import { Page, Run, floats, list, octets, words } from './data';
import { Quat, Vec, add, length, mix, rotation, scale, slerp, times } from './vectors';

interface Track { p: Float64Array[]; q: Float64Array[] | null; q0: Quat }
interface Difference { p: Float64Array[] | null; r: Float64Array[] | null }
export interface Curves { position?: Float32Array; attitude?: Float32Array; position_bar?: Float32Array; attitude_bar?: Float32Array; energy?: Float32Array }
export interface Cloud { count: number; all: number; every: number; frames: number; place: (Float32Array | null)[]; fields: (Uint8Array | null)[] }
export interface Pose { p: Vec; q: Quat }

export class Motion {
  readonly t: Float64Array;
  readonly curves: Curves[];
  readonly clouds: (Cloud | null)[];
  magnified = 1;
  private tracks: Track[][];
  private differences: Difference[][];
  private slot: number[];  // of a body among those that move; -1: at rest
  private straight: boolean;
  private first: number;   // frames of the first run

  constructor(readonly page: Page, bytes: Uint8Array) {
    const { moving, runs, ranges } = page.motion;
    this.t = Float64Array.from(page.kept, (k) => page.t_end * k / page.samples);
    this.first = runs[0].frames;
    this.straight = runs.some((run) => run.events.length > 0 || run.contacts);
    this.slot = page.scene.bodies.map((_, i) => moving.indexOf(i));
    this.tracks = runs.map((run) => run.poses.map(({ p, q }) => {
      const count = run.frames - (run.differences_to ?? 0), turns = typeof q[0] !== 'number';
      return { p: p.map((one) => list(bytes, one, count)), q: turns ? q.map((one) => list(bytes, one as [number, number, number], count, 32768)) : null, q0: (turns ? [1, 0, 0, 0] : q) as Quat };
    }));
    this.differences = runs.map((run) => (run.differences ?? []).map((one) => ({
      p: one.p?.map((l) => list(bytes, l, run.differences_to!, 32768)) ?? null, r: one.r?.map((l) => list(bytes, l, run.differences_to!, 32768)) ?? null })));
    this.curves = runs.map((run) => Object.fromEntries((['position', 'attitude', 'position_bar', 'attitude_bar', 'energy'] as const)
      .filter((key) => run[key]).map((key) => [key, floats(bytes, run[key]!)])));
    this.clouds = runs.map((run) => this.cloud(run, bytes, ranges));
  }

  private cloud(run: Run, bytes: Uint8Array, ranges: [number, number][]): Cloud | null {
    const cloud = run.particles;
    if (!cloud) return null;
    const all = cloud.count * cloud.frames;
    const place = cloud.place.map((at, axis) => at < 0 ? null
      : Float32Array.from(words(bytes, at, all), (word) => ranges[axis][0] + (ranges[axis][1] - ranges[axis][0]) * word / 65535));
    return { ...cloud, place, fields: cloud.fields.map((at) => at < 0 ? null : octets(bytes, at, all)) };
  }

  get runs(): Run[] { return this.page.motion.runs; }
  get frames(): number { return this.t.length; }
  get end(): number { return this.t[Math.max(...this.runs.map((run) => run.frames)) - 1]; }
  moves(body: number): boolean { return this.slot[body] >= 0; }

  // The frame that begins the interval of t, and how far t is in it.
  at(t: number): [number, number] {
    let low = 0, high = this.t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.t[middle] <= t) low = middle; else high = middle;
    }
    const span = this.t[low + 1] - this.t[low];
    return [low, span > 0 ? Math.min(Math.max((t - this.t[low]) / span, 0), 1) : 0];
  }
  // Whether the run still goes on at t.
  reaches(run: number, t: number): boolean { return this.runs[run].frames > 0 && t <= this.t[this.runs[run].frames - 1] * (1 + 1e-12); }

  // Beyond a run's end: its last pose.
  pose(run: number, body: number, t: number): Pose {
    const slot = this.slot[body], still = this.page.scene.bodies[body];
    if (slot < 0) return { p: still.p, q: still.q };
    const end = this.runs[run].frames - 1;
    let [frame, share] = this.at(Math.min(t, this.t[end]));
    if (frame >= end) [frame, share] = [Math.max(0, end - 1), end > 0 ? 1 : 0];
    const shared = this.runs[run].differences_to ?? 0;
    if (run === 0 || frame >= shared) return this.track(this.tracks[run][slot], frame - shared, share, this.runs[run].frames - shared);
    const base = this.track(this.tracks[0][slot], frame, share, this.first);
    const next = Math.min(frame + 1, shared - 1), { p, r } = this.differences[run][slot], k = this.magnified;
    const of = (lists: Float64Array[]): Vec => mix([lists[0][frame], lists[1][frame], lists[2][frame]], [lists[0][next], lists[1][next], lists[2][next]], share);
    let angle: Vec = [0, 0, 0];
    if (r) {
      angle = scale(of(r), k);
      const size = length(angle);
      if (k > 1 && size > Math.PI) angle = scale(angle, Math.PI / size);  // more than half a turn says nothing
    }
    return { p: p ? add(base.p, scale(of(p), k)) : base.p, q: r ? times(base.q, rotation(angle)) : base.q };
  }

  private track(track: Track, frame: number, share: number, count: number): Pose {
    const a = Math.min(Math.max(frame, 0), count - 1), b = Math.min(a + 1, count - 1);
    const p = track.p.map((x) => {
      if (this.straight || b === a) return x[a] + (x[b] - x[a]) * share;
      // Catmull and Rom's cubic, one-sided at the ends.
      const before = a > 0 ? x[a - 1] : 2 * x[a] - x[b], after = b < count - 1 ? x[b + 1] : 2 * x[b] - x[a];
      const m = (x[b] - before) / 2, n = (after - x[a]) / 2, s = share, u = 1 - s;
      return x[a] * (1 + 2 * s) * u * u + m * s * u * u + x[b] * s * s * (3 - 2 * s) - n * s * s * u;
    }) as Vec;
    const q = track.q;
    return { p, q: q ? slerp([q[0][a], q[1][a], q[2][a], q[3][a]], [q[0][b], q[1][b], q[2][b], q[3][b]], share) : track.q0 };
  }

  // The largest distance of a run from the first, over the bodies and frames that both have.
  largestDifference(run: number): number {
    let most = 0;
    for (const { p } of this.differences[run] ?? []) if (p) for (let f = 0; f < p[0].length; f += 1) most = Math.max(most, Math.hypot(p[0][f], p[1][f], p[2][f]));
    return most;
  }
  largestTurn(run: number): number {
    let most = 0;
    for (const { r } of this.differences[run] ?? []) if (r) for (let f = 0; f < r[0].length; f += 1) most = Math.max(most, Math.hypot(r[0][f], r[1][f], r[2][f]));
    return most;
  }
}
