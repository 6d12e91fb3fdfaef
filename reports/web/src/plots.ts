// The plots of one scenario and one metric, their shared legend, and the orders that the rows hold.
import { Chart } from './chart';
import { ChartSpec, Curve, Point } from './drawing';
import { Loose, Report, Run, engineOf, family, figure, noOrder, real } from './data';
import { h, labelledSelect, option, section } from './dom';
import { Cell, RowIndex, richest } from './rows';
import { ladderPlots, openingMethods } from './ladder_plots';
import { sceneMetric } from './scene_metric';
import { moreOfScene, sceneHead } from './scenes';
import { folds, ofScene, put } from './state';
import { Look, look, swatch } from './style';
import { isSweep } from './sweep';

const seriesKinds = ['position', 'velocity', 'attitude', 'body-rate'] as const;
const seriesUnits: Record<string, string> = { position: 'm', velocity: 'm/s', attitude: 'rad', 'body-rate': 'rad/s' };

// Between the methods that a link names: their ids may hold commas.
const between = '\n';

// Sweeps of poses have no steps to plot against.
export function plottable(index: RowIndex): string[] { return index.names('scenario').filter((id) => !isSweep(index, id)); }

export class Plots {
  readonly element: HTMLElement;
  private readonly charts = { step: new Chart('plot-step'), time: new Chart('plot-cpu'), evaluations: new Chart('plot-evaluations'), error: new Chart('plot-error'), energy: new Chart('plot-energy') };
  private readonly hidden = new Set<string>();
  private readonly looks = new Map<string, Look>();
  private readonly legend = h('div', { class: 'legend', role: 'group', 'aria-label': 'Methods shown' });
  private readonly about = h('p', { class: 'about' });
  private readonly orders = h('div', { class: 'orders' });
  private readonly absent = h('p', { class: 'soft' });
  private readonly scenario; private readonly metric; private readonly body; private readonly steps;
  private methods: string[] = [];
  private whole = false;   // all methods have a chip, or only those drawn
  private plot = '';       // the one plot that is shown; '': the first with curves; 'all'
  private readonly tabs = h('div', { class: 'tabs', role: 'group', 'aria-label': 'Plots' });
  readonly extra = h('div', { class: 'of-scene' });  // what else there is about the scene
  readonly head = h('div', { class: 'scene-head' });

  constructor(private readonly report: Report, private readonly index: RowIndex) {
    this.scenario = labelledSelect('scenario', 'plot-scenario', () => this.leave());
    this.metric = labelledSelect('metric', 'plot-metric', (metric) => { this.choose(); this.draw(); put({ metric, zoom: null, shown: null }); this.showHead(); });
    this.body = labelledSelect('body', 'plot-body', (body) => { this.draw(); put({ body, zoom: null }); });
    this.steps = labelledSelect('steps of the curves over time', 'plot-steps', (steps) => { this.draw(); put({ steps, zoom: null }); });
    const known = new Map(report.scenarios.map((s) => [s.id, s.title]));
    const ids = plottable(index);
    const first = richest(index, ids);
    this.scenario.select.append(...ids.map((id) => option(id, known.get(id) ? `${id} \u2014 ${known.get(id)}` : id, id === first)));
    const step = (by: number) => () => {
      const { select } = this.scenario;
      select.selectedIndex = (select.selectedIndex + by + select.options.length) % select.options.length;
      this.leave();
    };
    const quick = (name: string, keep: (method: string) => boolean) => h('button', { type: 'button', onclick: () => {
      this.methods.forEach((m) => (keep(m) ? this.hidden.delete(m) : this.hidden.add(m)));
      this.whole = true;
      this.afterChoice();
    } }, name);
    const few = h('button', { type: 'button', onclick: () => { this.choose(); this.draw(); put({ shown: null }); } }, 'chosen');
    for (const chart of Object.values(this.charts)) chart.fileName = () => `${this.scenario.select.value} ${this.metric.select.value} ${chart.current().spec.id}`;
    for (const [name, chart] of Object.entries(this.charts)) chart.zoomed = (ranges) => put({ zoom: ranges ? [name, ...ranges.map((v) => v.toPrecision(7))].join(',') : null });
    this.element = section('plots', 'Scene by scene',
      h('div', { class: 'bar choice' }, this.scenario.box,
        h('span', { class: 'pair' }, h('button', { type: 'button', 'aria-label': 'Previous scenario', onclick: step(-1) }, '\u2039'),
          h('button', { type: 'button', 'aria-label': 'Next scenario', onclick: step(1) }, '\u203a'))),
      this.about, h('div', { class: 'scene-twin' }, this.head, h('div', { class: 'work' },
        h('div', { class: 'bar' }, this.metric.box, this.body.box, this.steps.box), this.tabs,
        h('div', { class: 'grid' }, this.charts.step.element, this.charts.time.element, this.charts.evaluations.element, this.charts.error.element, this.charts.energy.element),
        h('div', { class: 'legend-row' }, h('span', { class: 'pair' }, few, quick('all', () => true), quick('none', () => false),
          quick('ours', (m) => engineOf(m) === 'atwood'), quick('others', (m) => engineOf(m) !== 'atwood')), this.legend),
        h('p', { class: 'hint' }, 'Drag to zoom, double-click to reset; hover or use the arrow keys to read a point. Click a method to hide it, double-click to show only it. Adaptive methods (:tol, one point per tolerance) have no constant step and appear only in the plots of work.'))),
      this.absent, this.orders, this.extra);
    if (ids.length) this.showScenario();
  }

  select(scenario: string): boolean {  // whether it has plots
    if (![...this.scenario.select.options].some((o) => o.value === scenario)) return false;
    this.scenario.select.value = scenario;
    this.leave();
    return true;
  }
  private leave(): void {
    this.showScenario();
    put({ ...Object.fromEntries(ofScene.map((key) => [key, null])), scene: this.scenario.select.value, fold: folds() });
  }
  // What a link says; anything else stays as the scene opens.
  apply(state: URLSearchParams): void {
    const set = (select: HTMLSelectElement, value: string | null) => { if (value !== null && [...select.options].some((o) => o.value === value)) select.value = value; };
    const scene = state.get('scene');
    if (scene !== null) set(this.scenario.select, scene);
    this.plot = state.get('plot') ?? '';
    for (const chart of Object.values(this.charts)) chart.setZoom(null);
    this.metric.select.value = '';
    this.showScenario();
    set(this.metric.select, state.get('metric'));
    set(this.body.select, state.get('body'));
    set(this.steps.select, state.get('steps'));
    this.choose();
    this.showHead();
    const shown = state.get('shown')?.split(between).filter((name) => this.methods.includes(name));
    if (state.has('shown')) {
      this.whole = true;
      this.methods.forEach((m) => (shown!.includes(m) ? this.hidden.delete(m) : this.hidden.add(m)));
    }
    const [name, ...ranges] = state.get('zoom')?.split(',') ?? [];
    if (name in this.charts) this.charts[name as keyof typeof this.charts].setZoom(ranges.map(Number));
    this.fillLegend();
    this.draw();
  }
  private afterChoice(): void {
    this.fillLegend();
    this.draw();
    put({ shown: this.methods.filter((m) => !this.hidden.has(m)).join(between) || '-' });
  }
  // The chosen few of this scene and metric.
  private choose(): void {
    const id = this.scenario.select.value;
    const list = openingMethods(this.index, id, this.metric.select.value);
    this.methods.forEach((m) => (list.includes(m) ? this.hidden.delete(m) : this.hidden.add(m)));
    this.whole = false;
    // A family of tolerances has one colour and marker; those of the chosen ones differ most.
    this.looks.clear();
    [...list, ...this.methods.filter((m) => !list.includes(m))].forEach((name, i) => this.looks.set(name, look(i)));
    this.fillLegend();
  }
  restyle(): void { this.fillLegend(); this.showHead(); Object.values(this.charts).forEach((chart) => chart.restyle()); }

  private showScenario(): void {
    const id = this.scenario.select.value;
    const rows = this.index.of(id);
    const metrics = this.index.names('metric', rows).filter((name) => !/^(order|growth|size|status$|condition$|step-time|rate-evaluations$)/.test(name));
    const rank = (name: string) => (name.startsWith('error-') ? 0 : /error/.test(name) ? 1 : 2);
    metrics.sort((a, b) => rank(a) - rank(b));
    const preferred = sceneMetric(this.report, this.index, id);
    this.metric.select.replaceChildren(...metrics.map((name) => option(name, name, name === preferred)));
    const bodies = this.index.names('body', rows).filter(Boolean);
    this.body.select.replaceChildren(option('', bodies.length ? 'whole run (largest)' : 'whole run'), ...bodies.map((name) => option(name, name)));
    this.body.box.hidden = bodies.length < 2;
    const runs = this.runs(id);
    const counts = new Map<number, number>();
    runs.forEach((run) => counts.set(run.n, (counts.get(run.n) ?? 0) + 1));
    const sorted = [...counts.keys()].sort((a, b) => a - b);
    // Of the step counts that most methods share, the middle one.
    const most = Math.max(...counts.values());
    const shared = sorted.filter((n) => counts.get(n) === most);
    const common = shared[Math.floor(shared.length / 2)];
    this.steps.select.replaceChildren(...sorted.map((n) => option(String(n), `${n} (${counts.get(n)} methods)`, n === common)));
    this.steps.box.hidden = sorted.length < 2;
    this.methods = [...new Set(this.index.names('method', rows).map(family))];
    const scenario = this.report.scenarios.find((s) => s.id === id);
    this.about.replaceChildren(...(scenario ? [h('b', {}, scenario.title), ` ${scenario.claim} `, h('span', { class: 'soft' }, `Truth: ${scenario.truth}. t_end ${figure(real(scenario.t_end_s))} s, ${scenario.samples} samples. Source: ${scenario.source}`)] : []));
    this.choose();
    this.draw();
    this.showHead();
    this.extra.replaceChildren(...moreOfScene(this.report, this.index, id).filter((part) => part) as Node[]);
  }
  // The outlines of the methods have the colours of the curves.
  private showHead(): void {
    const head = sceneHead(this.report, this.index, this.scenario.select.value, (methods) => this.colours(methods));
    this.head.replaceChildren(...head.filter((part) => part) as Node[]);
  }
  // Those of the plot, where no two of them are the same.
  private colours(methods: string[]): string[] {
    const used = new Set<string>();
    return methods.map((method) => {
      const all = [this.looks.get(family(method)) ?? look(0), ...Array.from({ length: 8 }, (_, i) => look(i))].map((one) => one.colour());
      const colour = all.find((one) => !used.has(one)) ?? all[0];
      used.add(colour);
      return colour;
    });
  }

  private runs(scenario: string): Run[] { return this.report.series.runs.filter((run) => this.report.strings[run.s] === scenario); }

  private fillLegend(): void {
    this.legend.replaceChildren(...this.methods.filter((name) => this.whole || !this.hidden.has(name)).map((name) => {
      const button = h('button', { type: 'button', 'aria-pressed': String(!this.hidden.has(name)), 'data-method': name }, swatch(this.looks.get(name)!) as unknown as Node, name);
      button.addEventListener('click', () => this.toggle(name, button));
      button.addEventListener('dblclick', () => this.alone(name));
      button.addEventListener('mouseenter', () => this.light(name));
      button.addEventListener('mouseleave', () => this.light(null));
      return button;
    }));
  }
  private toggle(name: string, button: HTMLElement): void {
    if (this.hidden.has(name)) this.hidden.delete(name);
    else this.hidden.add(name);
    button.setAttribute('aria-pressed', String(!this.hidden.has(name)));
    this.draw();
    put({ shown: this.methods.filter((m) => !this.hidden.has(m)).join(between) || '-' });
  }
  private alone(name: string): void {
    this.methods.forEach((other) => this.hidden.add(other));
    this.hidden.delete(name);
    for (const button of this.legend.querySelectorAll<HTMLElement>('button')) button.setAttribute('aria-pressed', String(button.dataset.method === name));
    this.draw();
    put({ shown: name });
  }
  private light(name: string | null): void { Object.values(this.charts).forEach((chart) => chart.highlight(name)); }

  // ---- the data of each plot --------------------------------------------------------------------------------------
  private draw(): void {
    const id = this.scenario.select.value, metric = this.metric.select.value;
    if (!metric) return;
    const specs = ladderPlots(this.index, id, metric, this.body.select.value, this.looks);
    this.charts.step.show(specs.step, this.hidden);
    this.charts.time.show(specs.time, this.hidden);
    this.charts.evaluations.show(specs.evaluations, this.hidden);
    const kind = seriesKinds.find((name) => metric.includes(name)) ?? 'position';
    const steps = Number(this.steps.select.value);
    this.charts.error.show(this.overTime('error', `Error over time: ${kind}${steps ? `, ${steps} steps` : ''}`, `|${kind} error| [${seriesUnits[kind]}]`, kind, steps), this.hidden);
    this.charts.energy.show(this.overTime('energy', `Energy over time${steps ? `, ${steps} steps` : ''}`, '|E \u2212 E\u2080| / E scale', 'energy', steps), this.hidden);
    this.showOrders(id);
    // Plots without data are named in a line instead of being drawn empty.
    const charts = Object.values(this.charts);
    this.showTabs();
    const empty = charts.filter((chart) => chart.isEmpty());
    this.absent.hidden = !empty.length;
    this.absent.textContent = `Not drawn: ${empty.map((chart) => chart.title()).join('; ')}.`;
  }

  private openPlot(): string {
    const names = Object.keys(this.charts) as (keyof typeof this.charts)[];
    if (this.plot === 'all' || names.some((name) => name === this.plot && !this.charts[name].isEmpty())) return this.plot;
    return ['time', 'step', ...names].find((name) => !this.charts[name as keyof typeof this.charts].isEmpty()) ?? 'all';
  }
  private showTabs(): void {
    const open = this.openPlot();
    const words: Record<string, string> = { step: 'error against step', time: 'against CPU time', evaluations: 'against evaluations', error: 'over time', energy: 'energy over time', all: 'all plots' };
    const names = Object.entries(this.charts).filter(([, chart]) => !chart.isEmpty()).map(([name]) => name);
    this.tabs.replaceChildren(...(names.length > 1 ? [...names, 'all'] : []).map((name) => h('button', { type: 'button', 'data-plot': name, 'aria-pressed': String(name === open), onclick: () => {
      this.plot = name;
      this.showTabs();
      put({ plot: name });
    } }, words[name])));
    for (const [name, chart] of Object.entries(this.charts)) chart.element.hidden = chart.isEmpty() || (open !== 'all' && name !== open);
    this.element.dataset.plot = open;
  }

  private overTime(id: string, title: string, yLabel: string, kind: keyof Run, steps: number): ChartSpec {
    const curves: Curve[] = [];
    for (const run of this.runs(this.scenario.select.value)) {
      const values = run[kind] as Loose[] | undefined;
      if (run.n !== steps || !values) continue;
      const method = this.report.strings[run.m];
      const instants = this.report.series.instants[run.t];
      const points: Point[] = [];
      values.forEach((value, i) => {
        const x = real(instants[i]), y = Math.abs(real(value));
        if (i > 0 && Number.isFinite(y)) points.push({ x, y, note: [method, `t = ${figure(x, 4)} s`, `${figure(real(value), 3)} ${seriesUnits[kind] ?? ''}`] });
      });
      if (points.length) curves.push({ name: family(method), look: this.looks.get(family(method)) ?? look(0), points });
    }
    return { id, title, xLabel: 't [s]', yLabel, xLog: false, curves, floor: null, guides: [], empty: 'No such curve was stored for this scenario.' };
  }

  private showOrders(id: string): void {
    const rows = this.index.of(id);
    const metrics = this.index.names('metric', rows).filter((name) => /^(order|growth)/.test(name))
      .sort((a, b) => Number(a.startsWith('growth')) - Number(b.startsWith('growth')));
    const lines = this.index.names('method', rows).map((method) => {
      const cells = metrics.map((metric) => this.index.ladders(id, metric, '').get(method)?.[0]);
      return cells.some(Boolean) ? h('tr', {}, h('th', { scope: 'row' }, method), ...cells.map((cell, k) => h('td', { class: 'number', title: cell ? fitTitle(cell, this.index.text(this.index.rows.reason[cell.row])) : '' },
        cell ? noOrder(metrics[k], cell.value, cell.bar) || `${cell.value.toFixed(2)}${cell.bar ? ` \u00b1 ${cell.bar.toFixed(2)}` : ''}` : '\u2013'))) : null;
    });
    this.orders.replaceChildren(h('h3', {}, 'Observed orders and growth, fitted over the asymptotic window'),
      lines.some(Boolean) ? h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Observed orders' }, h('table', {}, h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'method'), ...metrics.map((m) => h('th', { scope: 'col', class: 'number' }, m)))), h('tbody', {}, ...lines)))
        : h('p', { class: 'nothing' }, 'No order was fitted on this scenario.'));
  }
}

function fitTitle(cell: Cell, reason: string): string { return Number.isNaN(cell.value) ? reason : `${figure(cell.value, 4)}: ${reason}`; }
