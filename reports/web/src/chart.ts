// One plot: uPlot gives axes, canvas, cursor and drag; curves, floor and slope guides are drawn here, because
// work-precision curves are parametric (their x is not sorted). Data are stored as log10, so that every zoom is linear.
import uPlot from 'uplot';
import { h } from './dom';
import { figure } from './data';
import { chartSvg } from './chart_svg';
import { ChartSpec, Curve, Drawing, Placed, Range, arrange, decades, hasRoom, powerWord } from './drawing';
import { savePlotButtons } from './save';
import { markerPath, token } from './style';

const dpr = () => window.devicePixelRatio || 1;
const nothing: Drawing = arrange({ id: '', title: '', xLabel: '', yLabel: '', xLog: true, curves: [], floor: null, guides: [], empty: '' }, new Set());

export class Chart {
  readonly element: HTMLElement;
  private plot: uPlot | null = null;
  private spec!: ChartSpec;
  private drawing: Drawing = nothing;
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
    this.element = h('figure', { class: 'chart', id }, h('figcaption', {}, this.caption, h('span', { class: 'pair' }, ...savePlotButtons('this plot', () => this.fileName(), () => chartSvg(this.current())), this.reset)), this.place, this.readout);
    this.place.addEventListener('keydown', (event) => this.onKey(event));
    new IntersectionObserver((entries) => {
      this.visible = entries[entries.length - 1].isIntersecting;
      if (this.visible) this.drawIfStale();
    }, { rootMargin: '200px' }).observe(this.element);
    new ResizeObserver(() => {
      if (this.plot && this.place.clientWidth > 0 && Math.abs(this.plot.width - this.place.clientWidth) > 1) {
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
  fileName: () => string = () => this.spec.title;
  isEmpty(): boolean { return this.spec.curves.length === 0; }
  title(): string { return `${this.spec.title} (${this.spec.empty.replace(/\.$/, '').replace(/^./, (c) => c.toLowerCase())})`; }
  highlight(name: string | null): void { this.lit = name; this.plot?.redraw(false); }
  restyle(): void { this.stale = true; if (this.visible) this.drawIfStale(); }
  private height(): number { return Math.round(Math.min(380, Math.max(270, this.place.clientWidth * 0.62))); }

  private get placed(): Placed[] { return this.drawing.placed; }
  private curves(): Curve[] { return this.drawing.curves; }

  private drawIfStale(): void {
    if (!this.stale || !this.spec) return;
    this.stale = false;
    this.drawing = arrange(this.spec, this.hidden);
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
      mode: 2, width: this.place.clientWidth, height: this.height(), legend: { show: false }, padding: [10, 12, 0, 0],
      scales: {
        x: { time: false, range: () => this.drawing.x },
        y: { range: () => this.drawing.y },
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
    if (this.plot) this.setRanges(this.drawing.x, this.drawing.y, false);
  }
  // x from, x to, y from, y to, in the units of the axes (logarithms where they are); null: all.
  setZoom(ranges: number[] | null): void {
    const valid = ranges?.length === 4 && ranges.every(Number.isFinite) && ranges[0] < ranges[1] && ranges[2] < ranges[3];
    this.kept = valid ? { x: [ranges[0], ranges[1]], y: [ranges[2], ranges[3]] } : null;
    if (this.plot) this.setRanges(this.kept?.x ?? this.drawing.x, this.kept?.y ?? this.drawing.y, valid);
  }
  current(): Drawing {
    const drawing = arrange(this.spec, this.hidden);
    return this.kept ? { ...drawing, ...this.kept } : drawing;
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
    if (this.drawing.zeroLine !== null) line(this.drawing.zeroLine, 'exactly 0', false);
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
    const labels: [number, number][] = [];  // a steeper line whose label would lie on one of these has none
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
      if (!hasRoom(labels, px, py, dpr())) continue;
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
