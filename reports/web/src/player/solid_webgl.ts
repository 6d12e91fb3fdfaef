// Solids by three.js. Places are taken relative to the camera's target and in units of its distance before they become
// floats, so that an orbit of 1e11 m and an error of 1e-9 m are drawn alike.
import { BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, DynamicDrawUsage, Fog, HemisphereLight, InstancedMesh, LineBasicMaterial, LineSegments, Mesh as Drawn, MeshLambertMaterial, PCFSoftShadowMap, PerspectiveCamera, Points, PointsMaterial, Scene, WebGLRenderer, Material, Object3D } from 'three';
import { kField } from './camera';
import { Colours, Floor, Picture, Solids, Thing, kFloorCells, particleAt, particleColour } from './solids';
import { Mesh } from './shapes';
import { Vec, cross, sub } from './vectors';

function geometryOf(mesh: Mesh): BufferGeometry {
  const geometry = new BufferGeometry();
  const corners = mesh.round ? mesh.points : mesh.faces.flatMap((face) => face.map((i) => mesh.points[i]));
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(corners.flat()), 3));
  const shade = mesh.round && mesh.shade ? mesh.shade : corners.map(() => 1);
  geometry.setAttribute('color', new BufferAttribute(new Float32Array(shade.flatMap((s) => [s, s, s])), 3));
  if (mesh.round) geometry.setIndex(mesh.faces.flat());
  geometry.computeVertexNormals();
  return geometry;
}

function edgesOf(mesh: Mesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(mesh.edges.flatMap(([a, b]) => [...mesh.points[a], ...mesh.points[b]])), 3));
  return geometry;
}

function lattice(): BufferGeometry {
  const n = kFloorCells, lines: number[] = [];
  // In short pieces: not every rasteriser clips a long line that passes the camera.
  for (let i = -n; i <= n; i += 1) for (let j = -n; j < n; j += 1) lines.push(i, j, 0, i, j + 1, 0, j, i, 0, j + 1, i, 0);
  return new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(lines), 3));
}
function sheet(): BufferGeometry {
  const n = kFloorCells;
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array([-n, -n, 0, n, -n, 0, n, n, 0, -n, n, 0]), 3)).setIndex([0, 1, 2, 0, 2, 3]);
  geometry.computeVertexNormals();
  return geometry;
}

interface Group { things: number[]; mesh: InstancedMesh; run: number; fixed: boolean }
interface Edged { thing: number; lines: LineSegments }
interface Ground { sheet: Drawn; lines: LineSegments }

export class WebglSolids implements Solids {
  readonly kind = 'webgl';
  readonly canvas: HTMLCanvasElement;
  private renderer: WebGLRenderer;
  private scene = new Scene();
  private eye = new PerspectiveCamera(kField * 180 / Math.PI, 1, 0.02, 60);
  private sun = new DirectionalLight('#ffffff', 2.1);
  private sky = new HemisphereLight('#ffffff', '#8a8f98', 1.5);
  private haze = new Fog('#ffffff', 1.5, 6);
  private groups: Group[] = [];
  private edged: Edged[] = [];
  private grounds: Ground[] = [];
  private points: { drawn: Points; count: number; place: BufferAttribute; at: Float32Array; colour: BufferAttribute; tint: Uint8Array } | null = null;

  constructor(private things: Thing[], floors: number) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.canvas = this.renderer.domElement;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFSoftShadowMap;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    Object.assign(this.sun.shadow.camera, { left: -1.2, right: 1.2, top: 1.2, bottom: -1.2, near: 0.1, far: 8 });
    this.sun.shadow.normalBias = 0.01;
    this.scene.add(this.sun, this.sun.target, this.sky);
    this.scene.fog = this.haze;  // of the floor alone, so that it has no edge
    for (let i = 0; i < floors; i += 1) this.addGround();
    this.addThings();
  }

  private place<T extends Object3D>(object: T): T {
    object.matrixAutoUpdate = false;
    object.frustumCulled = false;
    this.scene.add(object);
    return object;
  }

  private addGround(): void {
    const ground = { sheet: this.place(new Drawn(sheet(), new MeshLambertMaterial({ side: DoubleSide, fog: true }))),
                     lines: this.place(new LineSegments(lattice(), new LineBasicMaterial({ transparent: true, fog: true }))) };
    ground.sheet.receiveShadow = true;
    this.grounds.push(ground);
  }

  private addThings(): void {
    const keys = new Map<string, number[]>();
    this.things.forEach((thing, i) => { const key = `${thing.run} ${thing.fixed} ${thing.key}`; keys.set(key, [...(keys.get(key) ?? []), i]); });
    const edges = this.things.length <= 150;
    for (const things of keys.values()) {
      const { mesh, run, fixed } = this.things[things[0]], ghost = run > 0;
      const material: Material = new MeshLambertMaterial({ vertexColors: true, fog: false, side: DoubleSide, transparent: ghost, opacity: ghost ? 0.42 : 1, depthWrite: !ghost, polygonOffset: ghost, polygonOffsetFactor: -run, polygonOffsetUnits: -4 * run });
      const drawn = this.place(new InstancedMesh(geometryOf(mesh), material, things.length));
      drawn.instanceMatrix.setUsage(DynamicDrawUsage);
      drawn.castShadow = !ghost;
      drawn.receiveShadow = !ghost;
      drawn.renderOrder = ghost ? 2 + run : 1;
      this.groups.push({ things, mesh: drawn, run, fixed });
      if (!edges || !mesh.edges.length) continue;
      const geometry = edgesOf(mesh);
      for (const thing of things) {
        const lines = this.place(new LineSegments(geometry, new LineBasicMaterial({ fog: false, transparent: true, opacity: ghost ? 0.95 : 0.55 })));
        lines.renderOrder = ghost ? 2 + run : 1;
        this.edged.push({ thing, lines });
      }
    }
  }

  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.eye.aspect = width / Math.max(height, 1);
    this.eye.updateProjectionMatrix();
  }

  draw(picture: Picture): void {
    const { camera, places, colours } = picture;
    const [, up, back] = camera.axes(), inverse = 1 / camera.distance;
    const relative = (p: Vec): Vec => sub(p, camera.target).map((x) => x * inverse) as Vec;
    this.eye.position.set(back[0], back[1], back[2]);
    this.eye.up.set(up[0], up[1], up[2]);
    this.eye.lookAt(0, 0, 0);
    const side = cross(camera.up, camera.front), light = camera.up.map((x, i) => 2.6 * x + 0.7 * camera.front[i] - 0.8 * side[i]) as Vec;
    this.sun.position.set(light[0], light[1], light[2]);
    this.haze.color.set(colours.panel);
    this.sky.intensity = colours.dark ? 1.25 : 1.6;
    this.sky.position.set(camera.up[0], camera.up[1], camera.up[2]);
    this.drawGroups(picture, relative, inverse);
    for (const { thing, lines } of this.edged) {
      const { p, q, size } = places[thing];
      lines.visible = size > 0;
      if (!lines.visible) continue;
      const m = matrixOf(relative(p), q, size * inverse);
      lines.matrix.set(m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14], 0, 0, 0, 1);
      lines.material.color.set(this.things[thing].run > 0 ? colours.run(this.things[thing].run) : colours.ink);
    }
    this.grounds.forEach((ground, i) => this.drawGround(ground, picture.floors[i], relative, inverse, colours));
    this.drawPoints(picture, relative, inverse);
    this.renderer.render(this.scene, this.eye);
  }

  private drawGroups({ places, colours }: Picture, relative: (p: Vec) => Vec, inverse: number): void {
    for (const { things, mesh, run, fixed } of this.groups) {
      let shown = 0;
      for (const thing of things) {
        const { p, q, size } = places[thing];
        if (!(size > 0)) continue;
        mesh.instanceMatrix.array.set(matrixOf(relative(p), q, size * inverse), 16 * shown);
        shown += 1;
      }
      mesh.visible = shown > 0;
      mesh.count = shown;
      mesh.instanceMatrix.needsUpdate = true;
      mesh.material.color.set(run > 0 ? colours.run(run) : fixed ? colours.fixed : colours.solid);
    }
  }

  private drawGround({ sheet: plate, lines }: Ground, floor: Floor | undefined, relative: (p: Vec) => Vec, inverse: number, colours: Colours): void {
    lines.visible = floor !== undefined && !floor.hidden;
    plate.visible = lines.visible && !floor!.ghost;
    if (!floor) return;
    const o = relative(floor.origin), s = floor.cell * inverse, a = floor.along, b = floor.across, n = floor.normal, below = -0.0008;
    plate.matrix.set(a[0] * s, b[0] * s, n[0] * s, o[0] + n[0] * below, a[1] * s, b[1] * s, n[1] * s, o[1] + n[1] * below, a[2] * s, b[2] * s, n[2] * s, o[2] + n[2] * below, 0, 0, 0, 1);
    lines.matrix.set(a[0] * s, b[0] * s, n[0] * s, o[0], a[1] * s, b[1] * s, n[1] * s, o[1], a[2] * s, b[2] * s, n[2] * s, o[2], 0, 0, 0, 1);
    plate.material.color.set(colours.floor);
    lines.material.color.set(colours.line);
    lines.material.opacity = floor.ghost ? 0.5 : 0.9;
  }

  private drawPoints({ points, side }: Picture, relative: (p: Vec) => Vec, inverse: number): void {
    if (this.points) this.points.drawn.visible = false;
    if (!points) return;
    const count = points.cloud.count;
    if (this.points?.count !== count) {
      if (this.points) {
        this.points.drawn.removeFromParent();
        this.points.drawn.geometry.dispose();
        this.points.drawn.material.dispose();
      }
      const at = new Float32Array(3 * count), tint = new Uint8Array(3 * count);
      const place = new BufferAttribute(at, 3), colour = new BufferAttribute(tint, 3, true);
      const geometry = new BufferGeometry().setAttribute('position', place).setAttribute('color', colour);
      this.points = { drawn: this.place(new Points(geometry, new PointsMaterial({ vertexColors: true, fog: false, sizeAttenuation: true }))), count, place, at, colour, tint };
    }
    const { drawn, place, at, colour, tint } = this.points;
    for (let i = 0; i < count; i += 1) {
      at.set(relative(particleAt(points, i)), 3 * i);
      tint.set(particleColour(points, i).map((x) => 255 * linear(x / 255)), 3 * i);
    }
    place.needsUpdate = true;
    colour.needsUpdate = true;
    drawn.material.size = side * inverse / Math.tan(kField / 2);  // three.js leaves the field of view out
    drawn.visible = true;
  }
}

function linear(s: number): number { return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4; }

// Column by column.
function matrixOf(p: Vec, [w, x, y, z]: [number, number, number, number], s: number): number[] {
  return [s * (1 - 2 * (y * y + z * z)), s * 2 * (x * y + w * z), s * 2 * (x * z - w * y), 0, s * 2 * (x * y - w * z), s * (1 - 2 * (x * x + z * z)), s * 2 * (y * z + w * x), 0,
    s * 2 * (x * z + w * y), s * 2 * (y * z - w * x), s * (1 - 2 * (x * x + y * y)), 0, p[0], p[1], p[2], 1];
}
