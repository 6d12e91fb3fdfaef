// The playback page: the clock, the controls, the list of runs, and what of them the address keeps.
import { h, labelledSelect, option } from '../dom';
import { download, fileName } from '../save';
import { isDark, look, token } from '../style';
import { View, readAddress, written } from './address';
import { about, checkBox, choose, speeds, tick } from './controls';
import { Curve, number } from './curves';
import { readPage } from './data';
import { Motion } from './motion';
import { metres } from './overlay';
import { fieldColour } from './solids';
import { Stage } from './stage';
import { Shown, kSwitches, shownAtFirst, switchesOf } from './switches';

class Player {
  private t = 0;
  private playing = false;
  private speed: number;
  private loop = true;
  private waits = false;
  private waitedFor = -1;  // the release that the clock waits for, or passed last
  private last = 0;
  private dirty = true;
  private field = 0;
  private cloudRun: number;
  private readonly visible: boolean[];
  private readonly boxes = new Map<string, HTMLInputElement>();     // check boxes, by name
  private readonly selects = new Map<string, HTMLSelectElement>();  // by the name in the address
  private readonly first: string;                                   // speed, as the select has it
  private readonly canvas: boolean;
  private readonly shown: Shown;
  private readonly stage: Stage;
  private readonly curves: Curve[] = [];
  private readonly releases: number[];
  private readonly parts: Record<'play' | 'slider' | 'clock' | 'frame' | 'letGo' | 'note', HTMLElement>;
  private readonly values: HTMLElement[] = [];
  private magnify!: HTMLSelectElement;

  constructor(private motion: Motion) {
    const { page } = motion, view = readAddress(location.hash);
    this.visible = motion.runs.map((run) => run.frames > 1);
    this.shown = shownAtFirst(motion);
    // In real time where that takes from two seconds to a minute; else the whole in ten seconds.
    this.speed = motion.end >= 2 && motion.end <= 60 ? 1 : motion.end / 10;
    this.first = this.speed === 1 ? '1' : 'whole';
    this.canvas = view.canvas === true;
    const released = page.scene.bodies.map((body) => body.release ?? 0).filter((t) => t > 0);
    this.releases = [...new Set(released)].sort((a, b) => a - b);
    if (!this.releases.length) this.releases.push(0);
    this.cloudRun = motion.clouds.findIndex((cloud) => cloud);
    this.stage = new Stage(motion, this.visible, this.shown, view.canvas === true);
    this.stage.changed = () => this.redraw(true);
    this.parts = {
      play: h('button', { type: 'button', id: 'play', class: 'primary', onclick: () => this.toggle() }, 'play'),
      slider: h('input', { type: 'range', id: 'time', min: 0, max: 1000, step: 'any', value: 0, 'aria-label': 'time' }),
      clock: h('output', { id: 'clock' }), frame: h('output', { id: 'frame', class: 'soft' }),
      letGo: h('button', { type: 'button', id: 'let-go', class: 'primary', hidden: true, onclick: () => this.letGo() }, 'let go'),
      note: h('p', { id: 'note', class: 'note', role: 'status' }),
    };
    if (view.theme) document.documentElement.dataset.theme = view.theme;
    this.build();
    new ResizeObserver(() => this.resize()).observe(this.stage.element);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.restyle());
    // Another link into the open page; what the page itself writes there is no such event.
    addEventListener('hashchange', () => location.reload());
    this.resize();
    this.restore(view);
    if (!matchMedia('(prefers-reduced-motion: reduce)').matches && view.t === undefined) this.toggle();
    requestAnimationFrame((now) => this.tick(now));
  }

  // ---- time ------------------------------------------------------------------------------------------------------------
  private tick(now: number): void {
    const seconds = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    if (this.playing) this.advance(seconds * this.speed);
    if (this.dirty) this.draw();
    requestAnimationFrame((next) => this.tick(next));
  }
  private advance(step: number): void {
    let next = this.t + step;
    if (this.waits) {
      const release = this.releases.find((t) => t > this.waitedFor && t >= this.t && t < next);
      if (release !== undefined) {
        next = release;
        this.hold(release);
      }
    }
    if (next > this.motion.end) {
      next = this.loop ? 0 : this.motion.end;
      this.waitedFor = -1;
      if (!this.loop) { this.playing = false; this.name(); this.keep(); }
    }
    this.set(next, false);
  }
  private hold(release: number): void {
    this.waitedFor = release;
    this.playing = false;
    this.parts.letGo.hidden = false;
    this.parts.note.textContent = 'Held until you let go.';
    this.name();
    this.keep();
  }
  private letGo(): void {
    this.parts.letGo.hidden = true;
    this.waitedFor = this.waitedFor < 0 ? this.releases[0] : this.waitedFor;
    this.playing = true;
    this.name();
    this.say();
    this.keep();
  }
  private toggle(): void {
    if (!this.playing && this.t >= this.motion.end) { this.t = 0; this.waitedFor = -1; }
    this.playing = !this.playing;
    this.last = performance.now();
    this.parts.letGo.hidden = true;
    this.name();
    this.say();
    this.keep();
  }
  private name(): void {
    this.parts.play.textContent = this.playing ? 'pause' : 'play';
    this.parts.play.setAttribute('aria-pressed', String(this.playing));
  }
  // `asked`: by the reader, not by the clock.
  private set(t: number, asked = true): void {
    this.t = Math.min(Math.max(t, 0), this.motion.end);
    if (asked) {
      this.waitedFor = this.releases.filter((release) => release < this.t).pop() ?? -1;
      if (!this.parts.letGo.hidden) this.say();
      this.parts.letGo.hidden = true;
      this.keep();
    }
    this.redraw();
  }
  private step(frames: number): void {
    this.playing = false;
    this.name();
    const [at, share] = this.motion.at(this.t), frame = Math.round((at + share) * 1e6) / 1e6;
    const next = frames > 0 ? Math.floor(frame) + frames : Math.ceil(frame) + frames;
    this.set(this.motion.t[Math.min(Math.max(next, 0), this.motion.frames - 1)]);
  }

  // ---- drawing ---------------------------------------------------------------------------------------------------------
  private redraw(keep = false): void {
    this.dirty = true;
    if (keep) this.keep();
  }
  private draw(): void {
    this.dirty = false;
    const { motion, t } = this, frameTime = motion.frames > 1 ? motion.end / (motion.frames - 1) : 0;
    this.stage.draw(t, Math.max(2 * frameTime, 0.3 * this.speed), this.field, this.cloudRun);
    for (const curve of this.curves) curve.draw(t);
    const [at, share] = motion.at(t), frame = Math.min(motion.frames - 1, Math.floor(at + share + 1e-9));
    (this.parts.slider as HTMLInputElement).value = String(1000 * t / (motion.end || 1));
    this.parts.slider.setAttribute('aria-valuetext', `${number(t)} s`);
    this.parts.clock.textContent = `t = ${t.toFixed(Math.min(9, Math.max(0, 4 - Math.ceil(Math.log10(motion.end || 1)))))} s`;
    const steps = motion.runs.find((run) => run.steps > 0)?.steps ?? 0;
    this.parts.frame.textContent = `frame ${frame} of ${motion.frames - 1}${steps ? `, step ${Math.round(steps * t / motion.page.t_end)} of ${steps}` : ''}`;
    this.values.forEach((cell, run) => { cell.textContent = this.words(run, at + (share >= 0.5 ? 1 : 0)); });
  }
  private words(run: number, frame: number): string {
    const { position, attitude, energy } = this.motion.curves[run], words: string[] = [];
    if (this.t > this.motion.t[Math.max(0, this.motion.runs[run].frames - 1)] * (1 + 1e-9)) return 'ended';
    if (run === 0 && this.motion.page.truth) return '';
    if (position && frame < position.length) words.push(metres0(position[frame]));
    if (attitude && frame < attitude.length && attitude.some((x) => x > 0)) words.push(`${number(attitude[frame])} rad`);
    if (!words.length && energy && frame < energy.length) words.push(`energy ${number(energy[frame])}${this.motion.page.energy_unit && ' J'}`);
    return words.join(', ');
  }
  private resize(): void {
    this.stage.resize();
    for (const curve of this.curves) curve.resize();
    this.redraw();
  }
  private restyle(): void {
    document.querySelectorAll<HTMLElement>('.swatch').forEach((box, run) => { box.style.background = this.colour(run); });
    this.redraw();
  }
  private colour(run: number): string {
    const first = this.motion.page.truth ? 1 : 0;
    return run < first ? token('--soft') : look(run - first).colour();
  }

  // ---- the address -------------------------------------------------------------------------------------------------------
  private keeping = 0;
  private keep(): void {
    clearTimeout(this.keeping);
    this.keeping = setTimeout(() => history.replaceState(null, '', written(this.view())), 200) as unknown as number;
  }
  private view(): View {
    const value = (name: string, first: string) => { const select = this.selects.get(name); return select && select.value !== first ? select.value : undefined; };
    const atFirst = shownAtFirst(this.motion), changed = kSwitches.filter((name) => this.shown[name] !== atFirst[name]);
    const asAtFirst = this.visible.every((on, run) => on === this.motion.runs[run].frames > 1);
    return {
      t: this.playing ? undefined : this.t,
      k: this.motion.magnified !== 1 ? this.motion.magnified : undefined,
      hidden: asAtFirst ? undefined : this.visible.flatMap((on, run) => on ? [] : [run]),
      camera: this.stage.view(),
      speed: value('speed', this.first), follow: value('follow', '-1'), field: value('field', this.selects.get('field')?.options[0]?.value ?? ''),
      particles: value('particles', this.selects.get('particles')?.options[0]?.value ?? ''),
      loop: this.loop ? undefined : false,
      wait: this.waits ? (this.parts.letGo.hidden ? 'wait' : 'held') : undefined,
      on: changed.filter((name) => this.shown[name]), off: changed.filter((name) => !this.shown[name]),
      theme: document.documentElement.dataset.theme as View['theme'], canvas: this.canvas,
    };
  }
  private restore(view: View): void {
    const { motion, stage } = this;
    this.t = Math.min(view.t ?? 0, motion.end);
    this.waitedFor = this.releases.filter((release) => release < this.t).pop() ?? -1;
    if (view.k !== undefined && motion.runs.length > 1) this.magnifyBy(view.k);
    if (view.hidden) motion.runs.forEach((_, run) => this.show(run, !view.hidden!.includes(run)));
    for (const [name, select] of this.selects) choose(select, view[name as 'speed' | 'follow' | 'field' | 'particles']);
    for (const name of kSwitches) if (view.on!.includes(name) || view.off!.includes(name)) tick(this.boxes.get(name), view.on!.includes(name));
    if (view.loop !== undefined) tick(this.boxes.get('loop'), view.loop);
    stage.fit();
    const lone = stage.lone();
    if (!(view.camera && stage.look(view.camera, this.t)) && lone >= 0 && view.follow === undefined) {
      stage.closeTo(lone, this.t);
      choose(this.selects.get('follow')!, String(lone));
    }
    if (!view.wait) return;
    this.waits = this.boxes.get('wait')!.checked = true;
    const release = this.releases.find((t) => Math.abs(t - this.t) <= 1e-6 * motion.end);
    if (view.wait !== 'held' || view.t === undefined || release === undefined) return;
    this.t = release;
    this.hold(release);
  }

  // ---- what the reader chooses ---------------------------------------------------------------------------------------------
  private show(run: number, on: boolean): void {
    this.visible[run] = on;
    (document.querySelectorAll('.run input')[run] as HTMLInputElement).checked = on;
    this.redraw(true);
  }
  private magnifyBy(k: number): void {
    this.motion.magnified = k;
    if (![...this.magnify.options].some((o) => Number(o.value) === k)) this.magnify.append(option(String(k), times(k)));
    this.magnify.value = String(k);
    this.say();
    this.redraw(true);
  }
  // A power of ten that makes the largest difference of the runs shown a sixth of the scene, or half a radian.
  private fitting(): number {
    let distance = 0, angle = 0;
    this.motion.runs.forEach((_, run) => {
      if (!this.visible[run] || run === 0) return;
      distance = Math.max(distance, this.motion.largestDifference(run));
      angle = Math.max(angle, this.motion.largestTurn(run));
    });
    const k = Math.min(distance > 0 ? this.stage.size / 6 / distance : Infinity, angle > 0 ? 0.5 / angle : Infinity);
    return Number.isFinite(k) ? 10 ** Math.max(0, Math.round(Math.log10(k))) : 1;
  }
  private say(): void {
    const { page, magnified } = this.motion, words: string[] = [];
    if (magnified !== 1) words.push(`Magnified: each method is drawn ${times(magnified)} times as far from ${page.truth ? 'the truth' : 'the first run'} as it is.`);
    if (!page.truth && this.motion.runs.length > 1) words.push('There is no truth here: differences are from the first run, and are no errors.');
    this.parts.note.textContent = words.join(' ');
    this.parts.note.classList.toggle('strong', magnified !== 1);
  }

  // ---- the page --------------------------------------------------------------------------------------------------------
  private build(): void {
    const app = document.getElementById('app')!;
    const slider = this.parts.slider as HTMLInputElement;
    slider.addEventListener('input', () => { this.playing = false; this.name(); this.set(this.motion.end * Number(slider.value) / 1000); });
    const bar = h('div', { class: 'transport' }, this.parts.play, this.parts.letGo,
      h('button', { type: 'button', id: 'back', 'aria-label': 'one frame back', onclick: () => this.step(-1) }, '\u2039'),
      h('button', { type: 'button', id: 'forward', 'aria-label': 'one frame forward', onclick: () => this.step(1) }, '\u203a'),
      slider, this.parts.clock, this.parts.frame);
    const scene = h('section', { class: 'scene', 'aria-label': 'Scene' }, this.stage.element, this.parts.note, bar, this.choices());
    if (this.stage.solids.kind === 'canvas') scene.append(h('p', { class: 'hint' }, 'Drawn without WebGL, which this browser does not offer: a simpler picture of the same motion.'));
    app.replaceChildren(scene, h('aside', { 'aria-label': 'Runs and errors' }, this.runs(), ...this.plots(), about(this.motion)));
    document.getElementById('tools')!.append(this.theme());
    document.addEventListener('keydown', (event) => this.key(event));
    this.say();
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;  // the browser's own
    if ((event.target as HTMLElement).matches('input, select, button, summary, a') && event.key !== 'Escape') return;
    const keys: Record<string, () => void> = { ' ': () => this.toggle(), ArrowLeft: () => this.step(event.shiftKey ? -10 : -1), ArrowRight: () => this.step(event.shiftKey ? 10 : 1), Home: () => this.set(0), End: () => this.set(this.motion.end), f: () => this.stage.fit() };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  }

  private choices(): HTMLElement {
    const { motion } = this, { scene } = motion.page;
    const speed = labelledSelect('speed', 'speed', (value) => { this.speed = value === 'whole' ? motion.end / 10 : Number(value); this.keep(); });
    speed.select.append(...speeds(this.speed));
    this.selects.set('speed', speed.select);
    const magnify = labelledSelect('magnify the error', 'magnify', (value) => this.magnifyBy(value === 'auto' ? this.fitting() : Number(value)));
    magnify.select.append(option('1', 'as it is'), option('auto', 'fitting'), ...Array.from({ length: 15 }, (_, i) => option(String(10 ** (i + 1)), times(10 ** (i + 1)))));
    this.magnify = magnify.select;
    const follow = labelledSelect('follow', 'follow', (value) => this.stage.followBody(Number(value)));
    follow.select.append(option('-1', 'nothing'), ...motion.page.motion.moving.slice(0, 300).map((body) => option(String(body), scene.bodies[body].name)));
    if (motion.page.motion.moving.length) this.selects.set('follow', follow.select);
    const box = (name: string, id: string, label: string, on: boolean, changed: (on: boolean) => void) => {
      const made = checkBox(id, label, on, (now) => { changed(now); this.redraw(true); });
      this.boxes.set(name, made.box);
      return made.label;
    };
    const toggles = switchesOf(motion).map(([name, label]) => box(name, `show-${name}`, label, this.shown[name], (on) => { this.shown[name] = on; }));
    const wait = box('wait', 'wait', scene.bodies.some((body) => body.release) ? 'wait at each release' : 'wait at the start', false, (on) => {
      this.waits = on;
      this.waitedFor = -1;
      if (on) { this.set(0); this.playing = true; this.last = performance.now(); this.name(); } else { this.parts.letGo.hidden = true; this.say(); }
    });
    const again = box('loop', 'loop', 'loop', true, (on) => { this.loop = on; });
    return h('div', { class: 'choices' }, h('div', { class: 'row' }, speed.box, motion.runs.length > 1 ? magnify.box : null, motion.page.motion.moving.length ? follow.box : null, ...this.fluid(),
      h('button', { type: 'button', id: 'fit', onclick: () => this.stage.fit() }, 'fit'),
      h('button', { type: 'button', id: 'save', title: 'Save the view as PNG', onclick: () => this.save('png') }, 'PNG'),
      h('button', { type: 'button', id: 'save-svg', title: 'Save the view as SVG', onclick: () => this.save('svg') }, 'SVG')), h('div', { class: 'row boxes' }, again, wait, ...toggles));
  }

  private save(kind: 'png' | 'svg'): void {
    const { page } = this.motion, text = (part: HTMLElement) => part.textContent!.trim();
    const drawn = this.motion.runs.map((run) => run.name).filter((_, i) => this.visible[i]).join(', ');
    const lines = [`${page.title || page.id}: ${drawn}`, [text(this.parts.clock), text(this.parts.note)].filter(Boolean).join('. ')], name = `${fileName(`${page.id} ${this.t.toPrecision(4)} s`)}.${kind}`;
    if (kind === 'svg') download(name, new Blob([this.stage.svg(lines)], { type: 'image/svg+xml' }));
    else this.stage.picture(lines).toBlob((blob) => { if (blob) download(name, blob); }, 'image/png');
  }

  private fluid(): HTMLElement[] {
    const { motion } = this, { fields } = motion.page.motion;
    if (this.cloudRun < 0) return [];
    const scaleBar = h('div', { class: 'scale' });
    const tell = () => {
      const [, unit, low, high] = fields[this.field];
      scaleBar.replaceChildren(h('span', {}, number(low!)), h('i', {}), h('span', {}, `${number(high!)} ${unit}`));
      scaleBar.querySelector('i')!.style.background = `linear-gradient(90deg, ${Array.from({ length: 10 }, (_, i) => `rgb(${fieldColour(i / 9).join(',')})`).join(', ')})`;
    };
    const field = labelledSelect('colour', 'field', (value) => { this.field = Number(value); tell(); this.redraw(true); });
    fields.forEach(([name, , low], i) => { if (low !== undefined) field.select.append(option(String(i), name)); });
    this.field = Number(field.select.value || 0);
    if (fields[this.field][2] !== undefined) tell();
    const which = labelledSelect('particles of', 'particles-of', (value) => { this.cloudRun = Number(value); this.redraw(true); });
    motion.clouds.forEach((cloud, run) => { if (cloud) which.select.append(option(String(run), `${motion.runs[run].name}${cloud.count < cloud.all ? `, ${cloud.count} of ${cloud.all}` : ''}`)); });
    this.selects.set('field', field.select).set('particles', which.select);
    return [field.box, which.box, scaleBar];
  }

  private runs(): HTMLElement {
    const { motion } = this;
    return h('section', { class: 'runs' }, h('h2', {}, 'Runs'), ...motion.runs.map((run, i) => {
      const box = h('input', { type: 'checkbox', id: `run-${i}`, checked: this.visible[i] });
      box.addEventListener('change', () => this.show(i, box.checked));
      const value = h('span', { class: 'value' });
      this.values.push(value);
      const swatch = h('i', { class: 'swatch' });
      swatch.style.background = this.colour(i);
      const trouble = run.status !== 'ok' ? `${run.status}: ${run.reason}` : run.left ? 'it left the scene' : '';
      return h('div', { class: 'run' }, h('label', { for: `run-${i}` }, box, swatch, h('span', { class: 'name' }, run.name)), value, trouble ? h('p', { class: 'trouble' }, trouble) : null);
    }), motion.page.truth && motion.runs.length > 1 ? h('p', { class: 'hint' }, 'Distance from the truth now: the largest of all bodies.') : null);
  }

  private plots(): HTMLElement[] {
    const { motion } = this, { page } = motion;
    const add = (key: 'position' | 'attitude' | 'energy', title: string, of: (run: number) => ArrayLike<number> | undefined, bar?: ArrayLike<number>) => {
      const lists = motion.runs.map((_, run) => of(run));
      if (!lists.some((list) => list && Array.prototype.some.call(list, (x: number) => x > 0))) return;
      this.curves.push(new Curve(motion, key, title, lists, bar, this.visible, (t) => { this.playing = false; this.name(); this.set(t); }));
    };
    if (page.truth) {
      add('position', 'error of position [m]', (run) => motion.curves[run].position, motion.curves[0].position_bar);
      add('attitude', 'error of attitude [rad]', (run) => motion.curves[run].attitude, motion.curves[0].attitude_bar);
    }
    add('energy', `${page.energy_title} ${page.energy_unit ? `[${page.energy_unit}]` : '(of the scene\u2019s scale)'}`, (run) => run === 0 && page.truth ? undefined : motion.curves[run].energy?.map(Math.abs));
    const why = page.truth ? '' : 'The scene has no truth: no error is plotted.';
    return [...this.curves.map((curve) => curve.element), ...(why ? [h('p', { class: 'hint' }, why)] : [])];
  }

  private theme(): HTMLElement {
    const button = h('button', { type: 'button', id: 'theme' }), name = () => { button.textContent = isDark() ? 'light' : 'dark'; button.setAttribute('aria-label', `Switch to ${button.textContent} colours`); };
    button.addEventListener('click', () => { document.documentElement.dataset.theme = isDark() ? 'light' : 'dark'; name(); this.restyle(); this.keep(); });
    name();
    return button;
  }
}

function times(k: number): string { return k >= 1e4 ? `1e${Math.round(Math.log10(k))}` : String(k); }
function metres0(x: number): string { return x > 0 ? metres(x) : '0 m'; }

async function start(): Promise<void> {
  const { page, bytes } = await readPage();
  const motion = new Motion(page, bytes);
  new Player(motion);
  // For programs that read the page: the pose that is drawn, and the times of the frames.
  Object.assign(globalThis, { atwood: { pose: (run: number, body: number, t: number) => motion.pose(run, body, t), times: [...motion.t] } });
  document.documentElement.dataset.ready = 'true';
}

start().catch((error: unknown) => {
  document.getElementById('app')!.append(h('p', { class: 'broken' }, `The motion cannot be shown: ${String(error)}. A browser from 2023 or later is needed (DecompressionStream).`));
  throw error;
});
