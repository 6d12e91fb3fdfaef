// The scene on the screen: solids, lines over them, the camera and how it follows the pointer.
import { h } from '../dom';
import { isDark, look, token } from '../style';
import { Camera, kMostPitch } from './camera';
import { Motion } from './motion';
import { Frame, Overlay } from './overlay';
import { meshOf } from './shapes';
import { CanvasSolids } from './solid_canvas';
import { Colours, Floor, Picture, Place, Points, Solids, Thing } from './solids';
import { SvgInk } from './svg_ink';
import { WebglSolids } from './solid_webgl';
import { Shown } from './switches';
import { Vec, add, cross, dot, length, scale, sub, unit } from './vectors';

const kDot = 4.5;  // the least radius of a body on the screen [px]
const kKeyTurn = 15, kKeyMove = 30, kKeyZoom = 0.15;  // of one key press: a drag of so many pixels, a zoom by e^x

export class Stage {
  readonly element: HTMLElement;
  readonly camera = new Camera();
  readonly things: Thing[] = [];
  readonly solids: Solids;
  private overlay: Overlay;
  private planes: { normal: Vec; offset: number }[] = [];
  private follow = -1;
  private followed: Vec | null = null;
  private last: { solids: Picture; lines: Frame } | null = null;  // what the screen shows
  size = 1;  // of the scene [m]
  changed: () => void = () => {};

  constructor(private motion: Motion, private visible: boolean[], readonly shown: Shown, forceCanvas: boolean) {
    const { bodies } = motion.page.scene, many = bodies.length * motion.runs.length > 150;
    for (const body of bodies) if (body.shape.kind === 'plane') this.planes.push(body.shape);
    motion.runs.forEach((_, run) => bodies.forEach((body, i) => {
      const still = !motion.moves(i);
      if (still && run > 0) return;  // the same in all runs
      const mesh = meshOf(body.shape, many);
      if (mesh && mesh.points.length) this.things.push({ mesh, key: JSON.stringify(body.shape), run, body: i, fixed: still });
    }));
    this.overlay = new Overlay(motion);
    const webgl = !forceCanvas && document.createElement('canvas').getContext('webgl2');
    this.solids = webgl ? new WebglSolids(this.things, Math.max(1, this.planes.length)) : new CanvasSolids(this.things);
    this.element = h('div', { class: 'stage', tabindex: 0, role: 'application', 'aria-label': 'The scene: drag to turn, shift and drag to move, wheel to zoom. Keys: Shift and arrows turn, W A S D move, plus and minus zoom, F fits, left and right step the time', 'data-kind': this.solids.kind }, this.solids.canvas, this.overlay.canvas);
    this.orient();
    this.listen();
  }

  // Looks along the direction in which nothing moves, where there is one; up is against gravity.
  private orient(): void {
    const { camera, motion } = this, { gravity, dimensions } = motion.page.scene;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { p, r } of this.balls()) p.forEach((x, i) => { low[i] = Math.min(low[i], x - 0 * r); high[i] = Math.max(high[i], x + 0 * r); });
    const wide = low.map((x, i) => Math.max(0, high[i] - x)), most = Math.max(...wide), flat = wide.map((x) => !(x > 1e-6 * most));
    const solid = this.things.some((thing) => thing.mesh.radius > 0.02 * most && !(thing.mesh.round && thing.mesh.edges.length === 0));
    if (length(gravity) > 0) camera.up = unit(scale(gravity, -1));
    else if (dimensions === 2 || (flat[2] && !flat[0] && !flat[1])) camera.up = [0, 1, 0];
    const across = ([[0, -1, 0], [0, 0, 1], [1, 0, 0]] as Vec[]).filter((axis) => Math.abs(dot(axis, camera.up)) < 0.9);
    const thin = across.find((axis) => flat[axis.findIndex((x) => x !== 0)]);
    const front = dimensions === 2 ? [0, 0, 1] as Vec : thin ?? across[0];
    camera.front = unit(sub(front, scale(camera.up, dot(front, camera.up))));
    const planar = dimensions === 2 || (Boolean(thin) && !solid);
    camera.yaw = planar ? 0 : thin ? 0.35 : 0.6;
    camera.pitch = planar && !this.planes.length ? 0 : planar ? 0.08 : 0.3;
  }

  // Balls around the bodies at some of the frames of the first run, and around its particles.
  private balls(): { p: Vec; r: number }[] {
    const { motion } = this, found: { p: Vec; r: number }[] = [], { bodies } = motion.page.scene;
    const every = Math.max(1, Math.floor(motion.runs[0].frames * bodies.length / 3000));
    const moving = this.things.filter((thing) => thing.run === 0 && !thing.fixed);
    const seen = moving.length ? moving : this.things.filter((thing) => thing.run === 0);
    for (const { body, mesh } of seen) for (let f = 0; f < motion.runs[0].frames; f += every) found.push({ p: motion.pose(0, body, motion.t[f]).p, r: mesh.radius });
    // What rests is part of the picture where it is not much larger than what moves.
    const reach = found.reduce((most, { p, r }) => Math.max(most, length(sub(p, found[0].p)) + r), 0);
    for (const thing of this.things) if (thing.run === 0 && thing.fixed && thing.mesh.radius < 1.5 * reach) found.push({ p: motion.page.scene.bodies[thing.body].p, r: thing.mesh.radius });
    for (const force of motion.page.scene.forces) if (force.kind === 'attractor' || (force.kind === 'spring' && force.b < 0)) found.push({ p: force.kind === 'attractor' ? force.pa : force.pb, r: 0 });
    for (const rope of motion.page.scene.ropes) for (const { axle, r } of rope.over) found.push({ p: axle, r });
    for (const joint of motion.page.scene.joints) if (joint.a < 0) found.push({ p: joint.pa, r: 0 });
    if (motion.clouds.some((cloud) => cloud)) {
      const { ranges } = motion.page.motion;
      for (const x of ranges[0]) for (const y of ranges[1]) for (const z of ranges[2]) found.push({ p: [x, y, z], r: 0 });
    }
    return found.filter(({ p }) => p.every(Number.isFinite));
  }

  // The body to follow at first: the only one that moves, where it is too small to be seen beside its path.
  lone(): number {
    const moving = this.things.filter((thing) => thing.run === 0 && !thing.fixed), [only] = moving;
    return moving.length === 1 && only.mesh.radius > 0 && only.mesh.radius < 0.015 * this.size && !this.planes.length ? only.body : -1;
  }
  closeTo(body: number, t: number): void {
    const thing = this.things.find((one) => one.run === 0 && one.body === body)!;
    this.camera.fit([{ p: this.motion.pose(0, body, t).p, r: 2 * thing.mesh.radius }]);
    this.followBody(body);
  }
  // The view as it stands, with lines of text below it.
  picture(lines: string[]): HTMLCanvasElement {
    const { width, height } = this.solids.canvas, size = Math.round(width / 70) + 6, foot = lines.length * size * 1.5 + size;
    const canvas = h('canvas', { width, height: Math.round(height + foot) }), ink = canvas.getContext('2d')!;
    ink.fillStyle = token('--panel');
    ink.fillRect(0, 0, canvas.width, canvas.height);
    for (const layer of [this.solids.canvas, this.overlay.canvas]) ink.drawImage(layer, 0, 0, width, height);
    ink.fillStyle = token('--ink');
    ink.font = `${size}px system-ui, sans-serif`;
    lines.forEach((line, i) => ink.fillText(line, size, height + (i + 1) * size * 1.5, width - 2 * size));
    return canvas;
  }
  // The same as SVG, the solids projected as triangles, the farthest first.
  svg(lines: string[]): string {
    const { width, height } = this.camera, size = Math.round(width / 70) + 6, foot = lines.length * size * 1.5 + size, ink = new SvgInk();
    ink.fillStyle = token('--panel');
    ink.fillRect(0, 0, width, height + foot);
    if (this.last) {
      new CanvasSolids(this.things, ink).draw(this.last.solids);
      this.overlay.drawOn(ink, this.last.lines);
    }
    ink.fillStyle = token('--ink');
    ink.font = `${size}px system-ui, sans-serif`;
    ink.textAlign = 'left';
    ink.textBaseline = 'alphabetic';
    lines.forEach((line, i) => ink.fillText(line, size, height + (i + 1) * size * 1.5));
    return ink.svg(width, height + foot);
  }
  fit(): void {
    const balls = this.balls();
    this.size = balls.reduce((most, { p, r }) => Math.max(most, length(sub(p, balls[0].p)) + r), 0) || 1;
    this.camera.fit(balls);
    this.followed = null;
    this.changed();
  }
  followBody(body: number): void {
    this.follow = body;
    this.followed = null;
    this.changed();
  }

  // Yaw, pitch and distance of the camera, and its target: of a camera that follows a body, from that body.
  view(): number[] {
    const { yaw, pitch, distance, target } = this.camera;
    return [yaw, pitch, distance, ...(this.follow < 0 ? target : this.followed ? sub(target, this.followed) : [0, 0, 0])];
  }
  // Takes what `view` gave, at time t; false, and nothing is done, where it is out of all proportion to the scene.
  look([yaw, pitch, distance, ...from]: number[], t: number): boolean {
    const { camera } = this, reach = 1e9 * (this.size + length(camera.target));
    if (distance < 1e-9 * this.size || distance > reach || from.some((x) => Math.abs(x) > reach)) return false;
    this.followed = this.follow < 0 ? null : this.motion.pose(0, this.follow, t).p;
    Object.assign(camera, { yaw, distance, pitch: Math.min(Math.max(pitch, -kMostPitch), kMostPitch), target: this.followed ? add(this.followed, from as Vec) : from as Vec });
    return true;
  }

  // Of the camera alone; others, and the arrows without Shift, are the page's.
  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { camera } = this, turns: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const moves: Record<string, [number, number]> = { w: [0, 1], a: [1, 0], s: [0, -1], d: [-1, 0] }, zooms: Record<string, number> = { '+': -1, '=': -1, '-': 1, _: 1 };
    const key = event.key.toLowerCase(), turned = event.shiftKey && turns[event.key], moved = moves[key], zoomed = zooms[key];
    if (turned) camera.orbit(turned[0] * kKeyTurn, turned[1] * kKeyTurn);
    else if (moved) camera.pan(moved[0] * kKeyMove, moved[1] * kKeyMove);
    else if (zoomed) camera.zoom(Math.exp(zoomed * kKeyZoom));
    else if (key === 'f') this.fit();
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.changed();
  }

  private listen(): void {
    const pointers = new Map<number, [number, number]>();
    const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
    this.element.addEventListener('pointerdown', (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      this.element.setPointerCapture(event.pointerId);
    });
    this.element.addEventListener('pointermove', (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const before = pointers.size === 2 ? spread() : 0;
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      const dx = event.clientX - last[0], dy = event.clientY - last[1];
      if (pointers.size === 2) {
        this.camera.zoom(before / Math.max(spread(), 1));
        this.camera.pan(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons & 6) this.camera.pan(dx, dy);
      else this.camera.orbit(dx, dy);
      this.changed();
    });
    for (const name of ['pointerup', 'pointercancel'] as const) this.element.addEventListener(name, (event) => pointers.delete(event.pointerId));
    this.element.addEventListener('contextmenu', (event) => event.preventDefault());
    this.element.addEventListener('wheel', (event) => {
      event.preventDefault();
      const box = this.element.getBoundingClientRect();
      this.camera.zoom(Math.exp(Math.max(-0.3, Math.min(0.3, event.deltaY * 0.0015))), event.clientX - box.left, event.clientY - box.top);
      this.changed();
    }, { passive: false });
    this.element.addEventListener('dblclick', () => this.fit());
    this.element.addEventListener('keydown', (event) => this.key(event));
  }

  resize(): void {
    const { clientWidth, clientHeight } = this.element, ratio = Math.min(devicePixelRatio || 1, 2);
    this.camera.width = Math.max(clientWidth, 10);
    this.camera.height = Math.max(clientHeight, 10);
    this.solids.resize(this.camera.width, this.camera.height, ratio);
    this.overlay.resize(this.camera.width, this.camera.height, ratio);
  }

  private floors(): Floor[] {
    const { camera } = this, ghost = this.planes.length === 0;
    if (ghost && !this.shown.grid) return [];
    const planes = ghost ? [{ normal: camera.up, offset: this.lowest() }] : this.planes;
    const rough = Math.max(camera.distance * 0.09, this.size * 0.04), power = 10 ** Math.floor(Math.log10(rough)), cell = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= rough)!;
    const [, , back] = camera.axes(), eye = add(camera.target, scale(back, camera.distance));
    return planes.map(({ normal, offset }) => {
      const one: Vec = Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
      const along = unit(sub(one, scale(normal, dot(one, normal)))), across = cross(normal, along), snap = (x: number) => Math.round(x / cell) * cell;
      const origin = add(scale(normal, offset), add(scale(along, snap(dot(camera.target, along))), scale(across, snap(dot(camera.target, across)))));
      // A wall is a grid, so that it hides nothing; a plane seen from behind is not drawn.
      return { origin, along, across, normal, cell, ghost: ghost || dot(normal, camera.up) < 0.5, hidden: !ghost && dot(normal, eye) < offset };
    });
  }
  private lowest(): number { return this.balls().reduce((least, { p, r }) => Math.min(least, dot(p, this.camera.up) - r), Infinity); }

  draw(t: number, hold: number, field: number, cloudRun: number): void {
    const { camera, motion } = this;
    if (this.follow >= 0) {
      const { p } = motion.pose(0, this.follow, t);
      if (this.followed) camera.target = add(camera.target, sub(p, this.followed));
      else camera.target = p;
      this.followed = p;
    }
    const dark = isDark(), first = motion.page.truth ? 1 : 0;
    const runColour = (run: number) => run < first ? token('--soft') : look(run - first).colour();
    const colours: Colours = { panel: token('--panel'), ink: token('--ink'), line: dark ? '#4a525c' : '#aab2bb', solid: first ? (dark ? '#aeb8c4' : '#8c98a6') : look(0).colour(), fixed: dark ? '#59616b' : '#c9ced4', floor: dark ? '#3a424b' : '#e6e9ed', dark, run: runColour };
    const project = camera.projection(), f = camera.pixels * camera.distance;
    const places: Place[] = this.things.map(({ run, body, mesh }) => {
      const { p, q } = motion.pose(run, body, t), depth = project(p)[2];
      if (!this.visible[run] && !(run === 0 && !motion.moves(body))) return { p, q, size: 0 };
      const radius = mesh.radius || 1, pixels = f / Math.max(depth, 1e-300) * radius;
      // Points, and bodies that would be less than a dot, are drawn as dots.
      if (mesh.radius === 0 || pixels < kDot) return { p, q, size: depth > 0 ? kDot * depth / f / radius : 0 };
      return { p, q, size: 1 };
    });
    this.last = { solids: { camera, places, floors: this.floors(), points: this.points(t, field, cloudRun), side: this.particleSide(cloudRun), colours }, lines: { camera, motion, t, visible: this.visible, shown: this.shown, size: this.size, hold, colour: runColour, ink: colours.ink, soft: token('--soft'), panel: colours.panel, force: token('--fail') } };
    this.solids.draw(this.last.solids);
    this.overlay.draw(this.last.lines);
    this.element.dataset.camera = [camera.yaw, camera.pitch, camera.distance, ...camera.target].map((x) => x.toPrecision(6)).join(' ');
  }

  private points(t: number, field: number, run: number): Points | null {
    const cloud = run >= 0 ? this.motion.clouds[run] : null;
    if (!cloud || !this.visible[run]) return null;
    const [at, part] = this.motion.at(t), whole = at + part, frame = Math.min(Math.floor(whole / cloud.every), cloud.frames - 1);
    const share = frame + 1 < cloud.frames ? Math.min((whole - frame * cloud.every) / cloud.every, 1) : 0;
    const periods = this.motion.page.motion.ranges.map(([low, high]) => high - low) as Vec;
    return { cloud, frame, share, field, periods };
  }
  // Of the area or the volume that a particle stands for.
  private particleSide(run: number): number {
    const cloud = run >= 0 ? this.motion.clouds[run] : null;
    if (!cloud) return 0;
    const spans = this.motion.page.motion.ranges.map(([low, high]) => high - low).filter((x) => x > 0);
    return 0.95 * (spans.reduce((a, b) => a * b, 1) / cloud.count) ** (1 / Math.max(spans.length, 1));
  }
}
