// Error and energy against time, with the cursor that the scene shares: a press or a drag sets the time.
import { h } from '../dom';
import { download, fileName } from '../save';
import { look, token } from '../style';
import { Motion } from './motion';
import { Ink, SvgInk } from './svg_ink';

const kHeight = 150, kLeft = 52, kRight = 12, kTop = 8, kBottom = 26;

export function number(x: number): string {
  if (x === 0) return '0';
  return Math.abs(x) >= 1e-3 && Math.abs(x) < 1e4 ? `${Number(x.toPrecision(3))}` : x.toExponential(1).replace('+', '').replace('.0e', 'e');
}

export class Curve {
  readonly element: HTMLElement;
  readonly canvas = h('canvas', { tabindex: 0 });
  private width = 360;
  private range: [number, number];
  private bar: ArrayLike<number> | undefined;
  private shownAt = 0;  // [s]

  // `values`: one list a run; logarithmic, so values that are not positive are left out.
  constructor(private motion: Motion, name: string, title: string, private values: (ArrayLike<number> | undefined)[], bar: ArrayLike<number> | undefined,
              private visible: boolean[], scrub: (t: number) => void) {
    let low = Infinity, high = -Infinity;
    const extent = (lists: (ArrayLike<number> | undefined)[]) => { for (const list of lists) for (let i = 0; i < (list?.length ?? 0); i += 1) if (list![i] > 0 && Number.isFinite(list![i])) { low = Math.min(low, list![i]); high = Math.max(high, list![i]); } };
    extent(values);
    // The bar belongs to the picture where it is near the errors; where it is not, the title says where it is.
    const most = bar ? Math.max(...Array.from(bar)) : 0, near = most > low * 1e-3;
    if (near) extent([bar]);
    else if (most > 0) title += `, bar of the truth at most ${number(most)}`;
    this.bar = near ? bar : undefined;
    high = high > 0 ? high : 1;
    this.range = [Math.floor(Math.log10(Math.max(Math.min(low, high), high * 1e-24, 1e-300)) + 1e-9), Math.ceil(Math.log10(high) - 1e-9)];
    if (this.range[1] <= this.range[0]) this.range[1] = this.range[0] + 1;
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', `${title} against time; press to set the time`);
    this.element = h('figure', { class: 'curve', id: `curve-${name}` }, h('figcaption', {}, h('span', {}, title), this.saveButton('SVG', title), this.saveButton('PNG', title)), this.canvas);
    const take = (event: PointerEvent) => {
      const box = this.canvas.getBoundingClientRect();
      scrub(Math.min(Math.max((event.clientX - box.left - kLeft) / (this.width - kLeft - kRight), 0), 1) * motion.end);
    };
    this.canvas.addEventListener('pointerdown', (event) => { this.canvas.setPointerCapture(event.pointerId); take(event); });
    this.canvas.addEventListener('pointermove', (event) => { if (event.buttons & 1) take(event); });
  }

  resize(): void {
    this.width = Math.max(200, this.canvas.clientWidth);
    const ratio = devicePixelRatio || 1;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(kHeight * ratio);
  }

  private saveButton(kind: 'SVG' | 'PNG', title: string): HTMLElement {
    const name = `${fileName(`${this.motion.page.id} ${title}`)}.${kind.toLowerCase()}`;
    return h('button', { type: 'button', class: 'save-curve', 'aria-label': `Save as ${kind}: ${title}`, onclick: () => {
      if (kind === 'PNG') return this.canvas.toBlob((blob) => { if (blob) download(name, blob); }, 'image/png');
      const ink = new SvgInk();
      ink.fillStyle = token('--panel');
      ink.fillRect(0, 0, this.width, kHeight);
      this.draw(this.shownAt, ink);
      download(name, new Blob([ink.svg(this.width, kHeight)], { type: 'image/svg+xml' }));
    } }, kind);
  }

  draw(t: number, ink: Ink = this.canvas.getContext('2d')!): void {
    const ratio = devicePixelRatio || 1, [low, high] = this.range, end = this.motion.end || 1;
    const x = (time: number) => kLeft + (this.width - kLeft - kRight) * time / end;
    const y = (value: number) => kTop + (kHeight - kTop - kBottom) * (high - Math.max(Math.log10(value), low)) / (high - low);
    this.shownAt = t;
    ink.setTransform(ratio, 0, 0, ratio, 0, 0);
    ink.clearRect(0, 0, this.width, kHeight);
    this.axes(ink, x, y, end);
    const path = (list: ArrayLike<number>) => {
      ink.beginPath();
      let pen = false;
      for (let i = 0; i < list.length; i += 1) {
        if (!(list[i] > 0) || !Number.isFinite(list[i])) { pen = false; continue; }
        if (pen) ink.lineTo(x(this.motion.t[i]), y(list[i])); else ink.moveTo(x(this.motion.t[i]), y(list[i]));
        pen = true;
      }
    };
    if (this.bar) {
      ink.strokeStyle = token('--soft');
      ink.setLineDash([2, 3]);
      path(this.bar);
      ink.stroke();
      ink.setLineDash([]);
    }
    this.values.forEach((list, run) => {
      if (!list || !this.visible[run]) return;
      ink.strokeStyle = run || !this.motion.page.truth ? look(run - (this.motion.page.truth ? 1 : 0)).colour() : token('--soft');
      ink.lineWidth = 1.7;
      path(list);
      ink.stroke();
    });
    ink.strokeStyle = token('--ink');
    ink.lineWidth = 1;
    ink.beginPath();
    ink.moveTo(x(t), kTop);
    ink.lineTo(x(t), kHeight - kBottom);
    ink.stroke();
    this.canvas.dataset.cursor = `${x(t)}`;
  }

  private axes(ink: Ink, x: (t: number) => number, y: (value: number) => number, end: number): void {
    const [low, high] = this.range, every = Math.max(1, Math.ceil((high - low) / 6));
    ink.font = '11px system-ui, "DejaVu Sans", sans-serif';
    ink.fillStyle = token('--soft');
    ink.strokeStyle = token('--line');
    ink.lineWidth = 1;
    ink.textBaseline = 'middle';
    ink.textAlign = 'right';
    for (let power = high; power >= low; power -= every) {
      ink.beginPath();
      ink.moveTo(kLeft, y(10 ** power));
      ink.lineTo(this.width - kRight, y(10 ** power));
      ink.stroke();
      ink.fillText(`1e${power}`, kLeft - 6, y(10 ** power));
    }
    ink.textBaseline = 'alphabetic';
    const rough = end / 5, power = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= rough)!;
    for (let i = 0; i * step <= end * (1 + 1e-9); i += 1) {
      const at = x(i * step);
      ink.textAlign = at > this.width - kRight - 24 ? 'right' : i ? 'center' : 'left';
      ink.fillText(`${number(i * step)}${i ? '' : ' s'}`, at, kHeight - 9);
    }
  }
}
