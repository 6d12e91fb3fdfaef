// What the page carries (reports/render/playback_scene.cpp, playback_motion.cpp): a scene as JSON, its motion as bytes.
import { Quat, Vec } from './vectors';

export type Triple = [number, number, number];
export type Shape =
  { kind: 'point' } | { kind: 'sphere'; r: number } | { kind: 'plane'; normal: Vec; offset: number } | { kind: 'box'; half: Vec } |
  { kind: 'capsule' | 'cylinder'; r: number; h: number } | { kind: 'mesh'; points: number[]; faces: number[] } |
  { kind: 'compound'; boxes: { half: Vec; p: Vec; q: Quat }[] };
export interface Body { name: string; fixed: boolean; release?: number; p: Vec; q: Quat; shape: Shape }
export interface Joint { name: string; kind: string; a: number; b: number; pa: Vec; pb: Vec; axis_a?: Vec; axis_b?: Vec }
export interface Rope { name: string; a: number; b: number; pa: Vec; pb: Vec; over: { r: number; axle: Vec; axis: Vec }[] }
export interface Force {
  kind: 'thruster' | 'point-force' | 'drive' | 'spring' | 'attractor'; a: number; b: number; pa: Vec; pb: Vec; direction: Vec; force: Vec;
  size: number; w: number; phase: number; rest: number; on?: [number, number][];
}
export interface Scene { gravity: Vec; dimensions: number; bodies: Body[]; joints: Joint[]; ropes: Rope[]; forces: Force[] }
// [t, kind, a, b, x, y, z, nx, ny, nz, normal impulse, tangential impulse]
export type Event = [number, string, number, number, number, number, number, number, number, number, number, number];
type List = [number, number, number];  // low, step, offset
export interface Run {
  name: string; source: string; steps: number; status: string; reason: string; frames: number; left?: boolean;
  poses: { p: [List, List, List]; q: (number | List)[] }[];
  differences_to?: number; differences?: { p?: [List, List, List]; r?: [List, List, List] }[];
  events: Event[]; events_left_out?: number; contacts?: number[][]; contacts_every?: number;
  position?: [number, number]; attitude?: [number, number]; position_bar?: [number, number]; attitude_bar?: [number, number]; energy?: [number, number];
  particles?: { count: number; all: number; every: number; frames: number; place: Triple; fields: number[] };
}
export interface Page {
  id: string; title: string; claim: string; source: string; command: string; t_end: number; samples: number; truth: boolean; energy_title: string; energy_unit: string;
  kept: number[]; scene: Scene;
  motion: { moving: number[]; ranges: [number, number][]; fields: [string, string, number?, number?][]; runs: Run[] };
}

async function inflated(id: string): Promise<ArrayBuffer> {
  const text = document.getElementById(id)!.textContent!.trim();
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw'))).arrayBuffer();
}

export async function readPage(): Promise<{ page: Page; bytes: Uint8Array }> {
  const page = JSON.parse(new TextDecoder().decode(await inflated('data'))) as Page;
  return { page, bytes: new Uint8Array(await inflated('motion')) };
}

// Words stored as second differences modulo 2^16, low bytes first, then high bytes.
export function words(bytes: Uint8Array, at: number, count: number): Uint16Array {
  const values = new Uint16Array(count);
  let value = 0, difference = 0;
  for (let i = 0; i < count; i += 1) {
    difference = (difference + bytes[at + i] + (bytes[at + count + i] << 8)) & 0xffff;
    value = (value + difference) & 0xffff;
    values[i] = value;
  }
  return values;
}
export function octets(bytes: Uint8Array, at: number, count: number): Uint8Array {
  const values = new Uint8Array(count);
  let value = 0;
  for (let i = 0; i < count; i += 1) {
    value = (value + bytes[at + i]) & 0xff;
    values[i] = value;
  }
  return values;
}
export function floats(bytes: Uint8Array, [at, count]: [number, number]): Float32Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset + at, 4 * count), values = new Float32Array(count);
  for (let i = 0; i < count; i += 1) values[i] = view.getFloat32(4 * i, true);
  return values;
}

// `about`: the word that stands for 0 of a list around 0.
export function list(bytes: Uint8Array, [low, step, at]: List, count: number, about = 0): Float64Array {
  const raw = words(bytes, at, count), values = new Float64Array(count);
  for (let i = 0; i < count; i += 1) values[i] = low + step * (raw[i] - about);
  return values;
}
