// What both ways of drawing are given: things with a mesh, where they are now, planes, particles.
import { Camera } from './camera';
import { Cloud } from './motion';
import { Mesh } from './shapes';
import { Quat, Vec } from './vectors';

export interface Thing { mesh: Mesh; key: string; run: number; body: number; fixed: boolean }  // equal keys: equal meshes
export interface Place { p: Vec; q: Quat; size: number }                 // size: of the mesh; 0: not drawn
export interface Floor { origin: Vec; along: Vec; across: Vec; normal: Vec; cell: number; ghost: boolean; hidden: boolean }  // ghost: its grid alone
export interface Points { cloud: Cloud; frame: number; share: number; field: number; periods: Vec }
export interface Colours { panel: string; ink: string; line: string; solid: string; fixed: string; floor: string; dark: boolean; run: (run: number) => string }
export interface Picture { camera: Camera; places: Place[]; floors: Floor[]; points: Points | null; side: number; colours: Colours }

export interface Solids {
  readonly kind: 'webgl' | 'canvas';
  readonly canvas: HTMLCanvasElement;
  resize(width: number, height: number, ratio: number): void;
  draw(picture: Picture): void;
}

export const kFloorCells = 24;  // on each side of the middle

// Cividis (Nunez, Anderton, Renslow 2018): brightness rises evenly, the same to colour-blind readers and in grey.
const palette: Vec[] = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]];
export function fieldColour(share: number): Vec {
  const at = Math.min(Math.max(share, 0), 1) * (palette.length - 1), i = Math.min(Math.floor(at), palette.length - 2);
  return palette[i].map((low, k) => Math.round(low + (at - i) * (palette[i + 1][k] - low))) as Vec;
}

// Place of a particle between two stored frames; one that crosses the border of the period stays at the nearer frame.
export function particleAt({ cloud, frame, share, periods }: Points, i: number): Vec {
  const from = i * cloud.frames + frame, to = frame + 1 < cloud.frames ? from + 1 : from;
  return cloud.place.map((list, axis) => {
    if (!list) return 0;
    const a = list[from], b = list[to];
    return periods[axis] > 0 && Math.abs(b - a) > periods[axis] / 2 ? (share < 0.5 ? a : b) : a + (b - a) * share;
  }) as Vec;
}
export function particleColour({ cloud, frame, field }: Points, i: number): Vec {
  const list = cloud.fields[field];
  return fieldColour(list ? list[i * cloud.frames + frame] / 255 : 0.5);
}
