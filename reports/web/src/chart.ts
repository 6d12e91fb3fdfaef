// One plot: uPlot gives axes, canvas, cursor and drag; curves, floor and slope guides are drawn here, because
// work-precision curves are parametric (their x is not sorted). Data are stored as log10, so that every zoom is linear.
import uPlot from 'uplot';
import { h } from './dom';
import { figure } from './data';
import { Look, markerPath, onPaper, token } from './style';

export interface Point { x: number; y: number; note: string[] }
export interface Curve { name: string; look: Look; points: Point[] }
export interface ChartSpec {
  id: string; title: string; xLabel: string; yLabel: string; xLog: boolean;
  curves: Curve[]; floor: number | null; guides: number[];  // slopes on the logs; floor: in units of y
  empty: string;                                            // the text shown where there is nothing to draw
}

interface Placed { curve: number; x: number; y: number; zero: boolean; point: Point }
type Range = [number, number];
const dpr = () => window.devicePixelRatio || 1;

function padded(min: number, max: number, part: number): Range {
  const pad = max > min ? (max - min) * part : 0.5;
  return [min - pad, max + pad];
}

export function decades(min: number, max: number, room: number): number[] {
  const span = max - min;
  if (span < 1.2) return [...Array(60)].flatMap((_, i) => [1, 2, 5].map((m) => Math.floor(min) + i + Math.log10(m)))
    .filter((v) => v >= min && v <= max);
  const step = Math.max(1, Math.ceil(span / Math.max(2, room)));
  const out: number[] = [];
  for (let v = Math.ceil(min / step) * step; v <= max; v += step) out.push(v);
  return out;
}
const superscripts = '\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079';
export function powerWord(log: number): string {
  const value = 10 ** log;
  if (Math.abs(log - Math.round(log)) > 1e-9) return figure(value, 2);
  if (log >= -2 && log <= 3) return String(Number(value.toPrecision(3)));
  const digits = String(Math.abs(Math.round(log))).split('').map((d) => superscripts[Number(d)]).join('');
  return `10${log < 0 ? '\u207b' : ''}${digits}`;
}

export class Chart {
  readonly element: HTMLElement;
  private plot: uPlot | null = null;
  private spec!: ChartSpec;
  private placed: Placed[] = [];
  private full: { x: Range; y: Range } = { x: [0, 1], y: [0, 1] };
  private zeroLine: number | null = null;
  private hidden = new Set<string>();
  private lit: string | null = null;
  private hovered = -1;
  private visible = false;
  private stale = true;
  private kept: { x: Range; y: Range } | null = null;  // the zoom of a link
  zoomed: (ranges: number[] | null) => void = () => {};
  private readonly place = h('div', { class: 'plot', tabindex: 0, role: 'img' });
  private readonly tip = h('div', { class: 'tip', hidden: true });
  private readonly ring = h('div', { class: 'ring', hidden: true });
  private readonly readout = h('p', { class: 'readout', 'aria-live': 'polite' });
  private readonly caption = h('span', {});
  private readonly reset = h('button', { type: 'button', class: 'reset', disabled: true, onclick: () => this.resetZoom() }, 'reset zoom');

  constructor(id: string) {
    this.element = h('figure', { class: 'chart', id }, h('figcaption', {}, this.caption, h('span', { class: 'pair' }, ...['SVG', 'PNG'].map((kind) => h('button', { type: 'button', class: 'save-plot', 'data-save': kind, 'aria-label': `Save this plot as ${kind}`, onclick: () => this.save(kind) }, kind)), this.reset)), this.place, this.readout);
    this.place.addEventListener('keydown', (event) => this.onKey(event));
    new IntersectionObserver((entries) => {
      this.visible = entries[entries.length - 1].isIntersecting;
      if (this.visible) this.drawIfStale();
    }, { rootMargin: '200px' }).observe(this.element);
    new ResizeObserver(() => {
      if (this.plot && !onPaper() && this.place.clientWidth > 0 && Math.abs(this.plot.width - this.place.clientWidth) > 1) {
        this.plot.setSize({ width: this.place.clientWidth, height: this.height() });
      }
    }).observe(this.place);
  }

  show(spec: ChartSpec, hidden: Set<string>): void {
    this.spec = spec;
    this.hidden = hidden;
    this.stale = true;
    this.caption.textContent = spec.title;
    this.place.setAttribute('aria-label', `${spec.title}: ${spec.yLabel} against ${spec.xLabel}; arrow keys read the points`);
    if (this.visible) this.drawIfStale();
  }
  save: (kind: string) => void = () => {};
  isEmpty(): boolean { return this.spec.curves.length === 0; }
  title(): string { return `${this.spec.title} (${this.spec.empty.replace(/\.$/, '').replace(/^./, (c) => c.toLowerCase())})`; }
  highlight(name: string | null): void { this.lit = name; this.plot?.redraw(false); }
  restyle(): void { this.stale = true; if (this.visible) this.drawIfStale(); }
  drawNow(): void { this.stale = true; this.drawIfStale(); }
  // On paper half of the width of A4 between its margins; on a screen the width of the column.
  private width(): number { return onPaper() ? 336 : this.place.clientWidth; }
  private height(): number { return onPaper() ? 250 : Math.round(Math.min(380, Math.max(270, this.place.clientWidth * 0.62))); }

  private curves(): Curve[] { return this.spec.curves.filter((curve) => !this.hidden.has(curve.name)); }

  private drawIfStale(): void {
    if (!this.stale || !this.spec) return;
    this.stale = false;
    this.placePoints();
    this.plot?.destroy();
    this.plot = null;
    this.hovered = -1;
    this.place.replaceChildren();
    this.reset.disabled = true;
    this.readout.textContent = '\u00a0';
    if (this.placed.length === 0) {
      this.place.append(h('p', { class: 'nothing' }, this.spec.empty));
      return;
    }
    this.plot = new uPlot(this.options(), [null, [this.placed.map((p) => p.x), this.placed.map((p) => p.y)]] as unknown as uPlot.AlignedData, this.place);
    this.plot.over.append(this.ring, this.tip);
    this.ring.hidden = this.tip.hidden = true;
    if (this.kept) this.setRanges(this.kept.x, this.kept.y, true);
  }

  // Logarithms; zeros are drawn on a separate line below all other values.
  private placePoints(): void {
    const curves = this.curves();
    const xOf = (x: number) => (this.spec.xLog ? Math.log10(x) : x);
    const logs: number[] = [];
    for (const curve of curves) for (const p of curve.points) if (p.y > 0) logs.push(Math.log10(p.y));
    const low = logs.length ? Math.min(...logs) : -16;
    const hasZero = curves.some((curve) => curve.points.some((p) => p.y === 0));
    this.zeroLine = hasZero ? Math.floor(low) - 1 : null;
    this.placed = [];
    curves.forEach((curve, index) => curve.points.forEach((point) => {
      const x = xOf(point.x);
      const zero = point.y === 0;
      const y = zero ? this.zeroLine! : Math.log10(point.y);
      if (Number.isFinite(x) && Number.isFinite(y)) this.placed.push({ curve: index, x, y, zero, point });
    }));
    if (!this.placed.length) return;
    const xs = this.placed.map((p) => p.x);
    const ys = this.placed.map((p) => p.y);
    if (this.spec.floor && this.spec.floor > 0) {
      const floor = Math.log10(this.spec.floor);
      if (floor > Math.min(...ys) - 4) ys.push(floor);
    }
    this.full = { x: padded(Math.min(...xs), Math.max(...xs), this.spec.xLog ? 0.05 : 0), y: padded(Math.min(...ys), Math.max(...ys), 0.06) };
  }

  private options(): uPlot.Options {
    const axis = (log: boolean, label: string): uPlot.Axis => ({
      stroke: token('--soft'), font: '12px system-ui, sans-serif', label, labelFont: '12px system-ui, sans-serif', labelSize: 20,
      size: 46, grid: { stroke: token('--line'), width: 1 }, ticks: { stroke: token('--line'), width: 1, size: 5 },
      ...(log ? {
        splits: (u: uPlot, i: number, min: number, max: number) => decades(min, max, (i === 0 ? u.bbox.width : u.bbox.height) / dpr() / (i === 0 ? 60 : 30)),
        values: (_: uPlot, splits: number[]) => splits.map(powerWord),
      } : { values: (_: uPlot, splits: number[]) => splits.map((v) => figure(v, 4)) }),
    });
    const xAxis = axis(this.spec.xLog, this.spec.xLabel);
    xAxis.size = 34;
    return {
      mode: 2, width: this.width(), height: this.height(), legend: { show: false }, padding: [10, 12, 0, 0],
      scales: {
        x: { time: false, range: () => this.full.x },
        y: { range: () => this.full.y },
      },
      axes: [xAxis, axis(true, this.spec.yLabel)],
      series: [{}, { facets: [{ scale: 'x', auto: true }, { scale: 'y', auto: true }], paths: () => null, points: { show: false } }] as unknown as uPlot.Series[],
      cursor: {
        drag: { x: true, y: true, uni: 14, setScale: false }, points: { show: false }, focus: { prox: -1 }, dataIdx: () => null as unknown as number,
        bind: { dblclick: () => () => { this.resetZoom(); return null; } },
      },
      hooks: {
        draw: [(u) => this.paint(u)],
        setCursor: [(u) => this.hover(u)],
        setSelect: [(u) => this.zoom(u)],
      },
    };
  }

  private zoom(u: uPlot): void {
    const { left, top, width, height } = u.select;
    if (width < 6 && height < 6) return;
    const whole = (size: number) => size < 1;
    const x: Range = whole(width) ? [u.scales.x.min!, u.scales.x.max!] : [u.posToVal(left, 'x'), u.posToVal(left + width, 'x')];
    const y: Range = whole(height) ? [u.scales.y.min!, u.scales.y.max!] : [u.posToVal(top + height, 'y'), u.posToVal(top, 'y')];
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.setRanges(x, y, true);
    this.kept = { x, y };
    this.zoomed([...x, ...y]);
  }
  private setRanges(x: Range, y: Range, zoomed: boolean): void {
    this.reset.disabled = !zoomed;
    this.element.dataset.zoomed = String(zoomed);
    this.plot!.batch(() => {
      this.plot!.setScale('x', { min: x[0], max: x[1] });
      this.plot!.setScale('y', { min: y[0], max: y[1] });
    });
    this.element.dataset.x = x.map((v) => v.toPrecision(6)).join(' ');
  }
  private resetZoom(): void {
    this.kept = null;
    this.zoomed(null);
    if (this.plot) this.setRanges(this.full.x, this.full.y, false);
  }
  // x from, x to, y from, y to, in the units of the axes (logarithms where they are); null: all.
  setZoom(ranges: number[] | null): void {
    const valid = ranges?.length === 4 && ranges.every(Number.isFinite) && ranges[0] < ranges[1] && ranges[2] < ranges[3];
    this.kept = valid ? { x: [ranges[0], ranges[1]], y: [ranges[2], ranges[3]] } : null;
    if (this.plot) this.setRanges(this.kept?.x ?? this.full.x, this.kept?.y ?? this.full.y, valid);
  }
  current(): { spec: ChartSpec; curves: Curve[]; x: Range; y: Range; zeroLine: number | null } {
    if (!this.placed.length) this.placePoints();
    return { spec: this.spec, curves: this.curves(), x: this.kept?.x ?? this.full.x, y: this.kept?.y ?? this.full.y, zeroLine: this.zeroLine };
  }

  // ---- hover ---------------------------------------------------------------------------------------------------
  private hover(u: uPlot): void {
    const { left, top } = u.cursor;
    let best = -1, least = 30 * 30;
    if (left !== undefined && top !== undefined && left >= 0) {
      this.placed.forEach((p, i) => {
        const dx = u.valToPos(p.x, 'x') - left, dy = u.valToPos(p.y, 'y') - top;
        if (dx * dx + dy * dy < least) { least = dx * dx + dy * dy; best = i; }
      });
    }
    if (best !== this.hovered) this.point(best);
  }
  private point(index: number): void {
    const u = this.plot!;
    this.hovered = index;
    this.ring.hidden = this.tip.hidden = index < 0;
    if (index < 0) return;
    const p = this.placed[index];
    const curve = this.curves()[p.curve];
    const x = u.valToPos(p.x, 'x'), y = u.valToPos(p.y, 'y');
    this.ring.style.transform = `translate(${x - 8}px, ${y - 8}px)`;
    this.ring.style.borderColor = curve.look.colour();
    this.tip.replaceChildren(h('b', {}, curve.name), ...p.point.note.map((line) => h('span', {}, line)));
    const width = u.bbox.width / dpr();
    this.tip.style.left = x > width / 2 ? 'auto' : `${x + 14}px`;
    this.tip.style.right = x > width / 2 ? `${width - x + 14}px` : 'auto';
    this.tip.style.top = `${Math.max(0, Math.min(y - 20, u.bbox.height / dpr() - 90))}px`;
    this.readout.textContent = [curve.name, ...p.point.note].join(' \u00b7 ');
  }
  private onKey(event: KeyboardEvent): void {
    this.drawIfStale();
    if (!this.plot || !this.placed.length) return;
    const count = this.placed.length;
    const jump = (by: number) => this.point(((this.hovered < 0 ? (by > 0 ? -1 : 0) : this.hovered) + by + count) % count);
    const curveStep = (by: number) => {
      const curves = this.placed[count - 1].curve + 1;
      const now = this.hovered < 0 ? 0 : this.placed[this.hovered].curve;
      for (let k = 1; k <= curves; k += 1) {
        const found = this.placed.findIndex((p) => p.curve === (now + by * k + curves * k) % curves);
        if (found >= 0) { this.point(found); return; }
      }
    };
    switch (event.key) {
      case 'ArrowRight': jump(1); break;
      case 'ArrowLeft': jump(-1); break;
      case 'ArrowDown': curveStep(1); break;
      case 'ArrowUp': curveStep(-1); break;
      case 'Escape': this.point(-1); this.resetZoom(); break;
      default: return;
    }
    event.preventDefault();
  }

  // ---- drawing -------------------------------------------------------------------------------------------------
  private paint(u: uPlot): void {
    const { ctx } = u;
    const { left, top, width, height } = u.bbox;
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    this.paintFloor(u);
    this.paintGuides(u);
    this.curves().forEach((curve, index) => this.paintCurve(u, curve, index));
    ctx.restore();
  }

  private paintFloor(u: uPlot): void {
    const { ctx } = u;
    const { left, top, width, height } = u.bbox;
    const line = (log: number, words: string, fill: boolean) => {
      const y = u.valToPos(log, 'y', true);
      if (y > top + height) return;
      ctx.fillStyle = token('--floor');
      if (fill) ctx.fillRect(left, Math.max(y, top), width, top + height - y);
      ctx.strokeStyle = ctx.fillStyle = token('--soft');
      ctx.setLineDash([4 * dpr(), 3 * dpr()]);
      ctx.lineWidth = dpr();
      ctx.beginPath();
      ctx.moveTo(left, y);
      ctx.lineTo(left + width, y);
      ctx.stroke();
      ctx.setLineDash([]);
      ctx.font = `${11 * dpr()}px system-ui, sans-serif`;
      ctx.textAlign = 'center';
      ctx.textBaseline = 'top';
      ctx.fillText(words, left + width * 0.42, y + 3 * dpr());
    };
    if (this.spec.floor && this.spec.floor > 0) line(Math.log10(this.spec.floor), `truth's bar ${figure(this.spec.floor, 2)}`, true);
    if (this.zeroLine !== null) line(this.zeroLine, 'exactly 0', false);
  }

  // Lines of order 1, 2, 4, 5 through the corner where the steps are largest; with labels where they leave the plot.
  private paintGuides(u: uPlot): void {
    if (!this.spec.guides.length) return;
    const { ctx } = u;
    const x = u.scales.x, y = u.scales.y;
    const falling = this.spec.guides[0] < 0;
    const x0 = falling ? x.min! : x.max!;
    const y0 = y.max! - (y.max! - y.min!) * 0.04;
    ctx.strokeStyle = ctx.fillStyle = token('--soft');
    ctx.globalAlpha = 0.75;
    ctx.lineWidth = dpr();
    ctx.font = `${11 * dpr()}px system-ui, sans-serif`;
    ctx.textBaseline = 'middle';
    for (const slope of this.spec.guides) {
      const xEnd = falling ? x.max! : x.min!;
      const yEnd = y0 + slope * (xEnd - x0);
      ctx.setLineDash([1.5 * dpr(), 4 * dpr()]);
      ctx.beginPath();
      ctx.moveTo(u.valToPos(x0, 'x', true), u.valToPos(y0, 'y', true));
      ctx.lineTo(u.valToPos(xEnd, 'x', true), u.valToPos(yEnd, 'y', true));
      ctx.stroke();
      ctx.setLineDash([]);
      const bottom = y.min! + (y.max! - y.min!) * 0.04;
      const leavesBelow = yEnd < bottom;
      const xl = leavesBelow ? x0 + (bottom - y0) / slope : xEnd;
      const px = u.valToPos(xl, 'x', true), py = u.valToPos(leavesBelow ? bottom : yEnd, 'y', true);
      ctx.textAlign = falling ? 'right' : 'left';
      ctx.fillText(`order ${Math.abs(slope)}`, px + (falling ? -6 : 6) * dpr(), py - (leavesBelow ? 0 : 8 * dpr()));
    }
    ctx.globalAlpha = 1;
  }

  private paintCurve(u: uPlot, curve: Curve, index: number): void {
    const { ctx } = u;
    const points = this.placed.filter((p) => p.curve === index);
    const at = points.map((p) => [u.valToPos(p.x, 'x', true), u.valToPos(p.y, 'y', true)]);
    const dense = points.length > 24;
    const colour = curve.look.colour();
    ctx.globalAlpha = this.lit && this.lit !== curve.name ? 0.15 : 1;
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.lineWidth = (this.lit === curve.name ? 2.6 : 1.5) * dpr();
    ctx.lineJoin = 'round';
    ctx.setLineDash(curve.look.dash.map((d) => d * dpr()));
    ctx.beginPath();
    at.forEach(([x, y], i) => (i ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
    ctx.stroke();
    ctx.setLineDash([]);
    const every = dense ? Math.ceil(points.length / 7) : 1;
    const offset = dense ? (index * 5) % every : 0;
    at.forEach(([x, y], i) => {
      if (i % every !== offset) return;
      const path = new Path2D(markerPath(curve.look.marker, x, y, 3.6 * dpr()));
      ctx.fillStyle = points[i].zero ? token('--panel') : colour;
      ctx.fill(path);
      if (points[i].zero) ctx.stroke(path);
    });
    ctx.globalAlpha = 1;
  }
}
