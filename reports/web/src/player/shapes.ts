// Shapes as triangles and edges in the body's axes, for both ways of drawing. `shade`, one a corner, darkens parts of round
// shapes, so that their turning is seen.
import { Shape } from './data';
import { Vec, add, cross, sub, turn, unit, dot, length } from './vectors';

export interface Mesh { points: Vec[]; faces: [number, number, number][]; edges: [number, number][]; shade: number[] | null; radius: number; round: boolean }

function finished(points: Vec[], faces: [number, number, number][], edges: [number, number][], shade: number[] | null = null, round = false): Mesh {
  let radius = 0;
  for (const point of points) radius = Math.max(radius, length(point));
  return { points, faces, edges, shade, radius, round };
}

function box(half: Vec): Mesh {
  const points: Vec[] = [];
  for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) points.push([x * half[0], y * half[1], z * half[2]]);
  const quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
  const faces = quads.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]] as [number, number, number][]);
  const edges: [number, number][] = [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]];
  return finished(points, faces, edges);
}

// A surface of revolution about z from points (radius, z), downwards.
function turned(profile: [number, number][], sides: number, rims: number[]): Mesh {
  const points: Vec[] = [], faces: [number, number, number][] = [], edges: [number, number][] = [], shade: number[] = [];
  for (const [r, z] of profile) for (let i = 0; i < sides; i += 1) {
    const angle = 2 * Math.PI * i / sides;
    points.push([r * Math.cos(angle), r * Math.sin(angle), z]);
    shade.push((Math.floor(4 * i / sides) + (z > 0 ? 0 : 1)) % 2 ? 0.72 : 1);
  }
  for (let k = 0; k + 1 < profile.length; k += 1) for (let i = 0; i < sides; i += 1) {
    const a = k * sides + i, b = k * sides + (i + 1) % sides;
    if (profile[k][0] > 0) faces.push([a, a + sides, b]);
    if (profile[k + 1][0] > 0) faces.push([b, a + sides, b + sides]);
  }
  for (const k of rims) for (let i = 0; i < sides; i += 1) edges.push([k * sides + i, k * sides + (i + 1) % sides]);
  return finished(points, faces, edges, shade, true);
}

function sphere(r: number, sides: number): Mesh {
  const rings = Math.max(6, sides / 2), profile: [number, number][] = [];
  for (let k = 0; k <= rings; k += 1) profile.push([k === 0 || k === rings ? 0 : r * Math.sin(Math.PI * k / rings), r * Math.cos(Math.PI * k / rings)]);
  return turned(profile, sides, []);
}

function capsule(r: number, h: number): Mesh {
  const profile: [number, number][] = [];
  for (let k = 0; k <= 8; k += 1) profile.push([k === 0 ? 0 : r * Math.sin(Math.PI * k / 16), h + r * Math.cos(Math.PI * k / 16)]);
  for (let k = 8; k <= 16; k += 1) profile.push([k === 16 ? 0 : r * Math.sin(Math.PI * k / 16), -h + r * Math.cos(Math.PI * k / 16)]);
  return turned(profile, 24, [8, 9]);
}

// Caps and side do not share corners, so that the rim stays sharp.
function cylinder(r: number, h: number): Mesh {
  const mesh = turned([[0, h], [r, h], [r, h], [r, -h], [r, -h], [0, -h]], 32, [2, 3]);
  mesh.faces = mesh.faces.filter(([a, b, c]) => {
    const [p, q, s] = [mesh.points[a], mesh.points[b], mesh.points[c]];
    return length(cross(sub(q, p), sub(s, p))) > 0;
  });
  return mesh;
}

function faceted(raw: number[], corners: number[]): Mesh {
  const points: Vec[] = [], faces: [number, number, number][] = [];
  for (let i = 0; i + 2 < raw.length; i += 3) points.push([raw[i], raw[i + 1], raw[i + 2]]);
  for (let i = 0; i + 2 < corners.length; i += 3) faces.push([corners[i], corners[i + 1], corners[i + 2]]);
  const normals = faces.map(([a, b, c]) => unit(cross(sub(points[b], points[a]), sub(points[c], points[a]))));
  const sides = new Map<string, number[]>();
  faces.forEach((face, f) => face.forEach((a, i) => {
    const b = face[(i + 1) % 3], key = a < b ? `${a} ${b}` : `${b} ${a}`;
    sides.set(key, [...(sides.get(key) ?? []), f]);
  }));
  const edges: [number, number][] = [];
  for (const [key, both] of sides) if (both.length !== 2 || dot(normals[both[0]], normals[both[1]]) < 0.99) edges.push(key.split(' ').map(Number) as [number, number]);
  return finished(points, faces, edges);
}

// null: a plane, which is drawn as a floor. `many`: fewer sides, as there are many bodies.
export function meshOf(shape: Shape, many: boolean): Mesh | null {
  switch (shape.kind) {
    case 'plane': return null;
    case 'point': return { ...sphere(1, 16), shade: null, radius: 0 };
    case 'sphere': return sphere(shape.r, many ? 16 : 32);
    case 'box': return box(shape.half);
    case 'capsule': return capsule(shape.r, shape.h);
    case 'cylinder': return cylinder(shape.r, shape.h);
    case 'mesh': return faceted(shape.points, shape.faces);
    case 'compound': {
      const points: Vec[] = [], faces: [number, number, number][] = [], edges: [number, number][] = [];
      for (const part of shape.boxes) {
        const one = box(part.half), from = points.length;
        points.push(...one.points.map((p) => add(part.p, turn(part.q, p))));
        faces.push(...one.faces.map((f) => f.map((i) => i + from) as [number, number, number]));
        edges.push(...one.edges.map((e) => e.map((i) => i + from) as [number, number]));
      }
      return finished(points, faces, edges);
    }
  }
}
