// Solids where WebGL is missing: triangles projected to a canvas, the farthest first.
import { Picture, Solids, Thing, kFloorCells, particleAt, particleColour } from './solids';
import { Ink } from './svg_ink';
import { Vec, add, cross, dot, scale, sub, turn, unit } from './vectors';

interface Patch { depth: number; draw: () => void }

function parts(colour: string): Vec {
  const n = parseInt(colour.slice(1), 16);
  return [n >> 16 & 255, n >> 8 & 255, n & 255];
}

export class CanvasSolids implements Solids {
  readonly kind = 'canvas';
  readonly canvas = document.createElement('canvas');
  private ratio = 1;

  constructor(private things: Thing[], private ink: Ink = null!) { this.ink ??= this.canvas.getContext('2d')!; }

  resize(width: number, height: number, ratio: number): void {
    this.ratio = ratio;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  draw(picture: Picture): void {
    const { camera } = picture, project = camera.projection(), patches: Patch[] = [];
    this.ink.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.ink.clearRect(0, 0, camera.width, camera.height);
    for (const floor of picture.floors) if (!floor.hidden) this.floor(picture, floor, project);
    this.things.forEach((thing, i) => this.thing(thing, i, picture, project, patches));
    this.particles(picture, project, patches);
    patches.sort((a, b) => b.depth - a.depth);
    for (const patch of patches) patch.draw();
  }

  private path(points: Vec[], close: boolean): void {
    this.ink.beginPath();
    points.forEach(([x, y], i) => i ? this.ink.lineTo(x, y) : this.ink.moveTo(x, y));
    if (close) this.ink.closePath();
  }

  private floor({ colours, camera }: Picture, floor: Picture['floors'][0], project: (p: Vec) => Vec): void {
    const n = Math.min(kFloorCells, 8), at = (i: number, j: number) => project(add(floor.origin, add(scale(floor.along, i * floor.cell), scale(floor.across, j * floor.cell))));
    const near = camera.distance * 0.02;
    const corners = [at(-n, -n), at(n, -n), at(n, n), at(-n, n)];
    if (!floor.ghost && corners.every((c) => c[2] > near)) {
      this.path(corners, true);
      this.ink.fillStyle = colours.floor;
      this.ink.fill();
    }
    this.ink.strokeStyle = colours.line;
    this.ink.lineWidth = 1;
    for (let i = -n; i <= n; i += 1) for (const line of [[at(i, -n), at(i, n)], [at(-n, i), at(n, i)]]) if (line.every((c) => c[2] > near)) {
      this.path(line, false);
      this.ink.stroke();
    }
  }

  private thing({ mesh, run, fixed }: Thing, i: number, { places, colours, camera }: Picture, project: (p: Vec) => Vec, patches: Patch[]): void {
    const { p, q, size } = places[i];
    if (!(size > 0)) return;
    const world = mesh.points.map((x) => add(p, turn(q, scale(x, size)))), seen = world.map(project);
    if (seen.some((x) => x[2] < camera.distance * 0.02)) return;
    const base = parts(run > 0 ? colours.run(run) : fixed ? colours.fixed : colours.solid), [right, up, back] = camera.axes();
    const light = unit(add(add(scale(up, 1.1), scale(back, 0.8)), scale(right, -0.6)));
    for (const face of mesh.faces) {
      const [a, b, c] = face.map((k) => seen[k]);
      if ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) >= 0 && mesh.faces.length > 12) continue;  // seen from behind
      const normal = unit(cross(sub(world[face[1]], world[face[0]]), sub(world[face[2]], world[face[0]])));
      const shade = (0.55 + 0.45 * Math.abs(dot(normal, light))) * (mesh.shade ? mesh.shade[face[0]] : 1);
      const fill = `rgba(${base.map((x) => Math.round(x * shade)).join(',')},${run > 0 ? 0.45 : 1})`;
      patches.push({ depth: (a[2] + b[2] + c[2]) / 3, draw: () => {
        this.path([a, b, c], true);
        this.ink.fillStyle = fill;
        this.ink.fill();
        if (run > 0) return;
        this.ink.strokeStyle = fill;  // closes the seams between triangles
        this.ink.lineWidth = 0.7;
        this.ink.stroke();
      } });
    }
    const middle = project(p)[2], nearest = seen.reduce((least, x) => Math.min(least, x[2]), Infinity);
    if (mesh.edges.length) patches.push({ depth: run > 0 ? nearest : (middle + nearest) / 2, draw: () => {
      this.ink.strokeStyle = run > 0 ? colours.run(run) : colours.ink;
      this.ink.globalAlpha = run > 0 ? 0.9 : 0.35;
      this.ink.lineWidth = 1;
      for (const [from, to] of mesh.edges) { this.path([seen[from], seen[to]], false); this.ink.stroke(); }
      this.ink.globalAlpha = 1;
    } });
  }

  private particles({ points, side, camera }: Picture, project: (p: Vec) => Vec, patches: Patch[]): void {
    if (!points) return;
    for (let i = 0; i < points.cloud.count; i += 1) {
      const [x, y, depth] = project(particleAt(points, i)), wide = Math.max(1.5, side * camera.pixels * camera.distance / depth);
      if (depth < camera.distance * 0.02) continue;
      const fill = `rgb(${particleColour(points, i).join(',')})`;
      patches.push({ depth, draw: () => { this.ink.fillStyle = fill; this.ink.fillRect(x - wide / 2, y - wide / 2, wide, wide); } });
    }
  }
}
