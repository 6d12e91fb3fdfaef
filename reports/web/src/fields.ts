// Fluids: the fields at the last sample, drawn from particles. Each particle is a square of the area that it stands for.
import { Picture, Report, figure, real } from './data';
import { h, section } from './dom';
import { FieldName, ValueRange, colourIn, fieldWords, gradient } from './field_colours';
import { fieldSvg } from './field_svg';
import { RowIndex } from './rows';
import { savePlotButtons } from './save';

// One range of a quantity for all methods of a scenario, so that equal colours are equal values.
function common(pictures: Picture[], name: FieldName): ValueRange | null {
  const found = pictures.map((p) => p[name]).filter((field) => field).map((field) => ({ low: real(field!.low), high: real(field!.high) }));
  return found.length ? { low: Math.min(...found.map((r) => r.low)), high: Math.max(...found.map((r) => r.high)) } : null;
}

function draw(canvas: HTMLCanvasElement, picture: Picture, name: FieldName, range: ValueRange): void {
  const wide = real(picture.x.high) - real(picture.x.low), high = real(picture.y.high) - real(picture.y.low);
  const scale = 640 / Math.max(wide, high, 1e-300);
  canvas.width = Math.max(8, Math.round(wide * scale));
  canvas.height = Math.max(8, Math.round(high * scale));
  const ink = canvas.getContext('2d')!;
  const field = picture[name]!, low = real(field.low), span = real(field.high) - low;
  const side = Math.max(2, real(picture.side) * scale * 1.5);
  for (let i = 0; i < field.at.length; i += 1) {
    const value = low + span * field.at[i] / 250;
    ink.fillStyle = colourIn(range, value);
    const x = picture.x.at[i] / 4096 * canvas.width, y = (1 - picture.y.at[i] / 4096) * canvas.height;
    ink.fillRect(x - side / 2, y - side / 2, side, side);
  }
}

function scaleBar(name: FieldName, range: ValueRange): HTMLElement {
  const word = (value: number) => figure(name === 'error' ? 10 ** value : value, 3);
  return h('div', { class: 'scale' }, h('span', {}, word(range.low)), h('i', { style: `background: ${gradient}` }), h('span', {}, word(range.high)));
}

export class Fields {
  readonly element: HTMLElement;
  private waiting = new Map<HTMLDetailsElement, () => void>();

  constructor(report: Report, index: RowIndex) {
    const scenarios = [...new Set(report.pictures!.map((p) => p.s))];
    const blocks = scenarios.map((s, i) => this.scenario(report, index, s, i === 0));
    this.element = section('fields', 'Fields of the fluids',
      h('p', { class: 'hint' }, 'The particles at the end, of each method at its finest spacing, highest sound speed and most steps. One scale for all methods of a scenario: equal colours are equal values. The error is the distance from the exact field at each particle, on a logarithmic scale. Of more than 2500 particles one of each square of a grid is drawn; in three dimensions those of the middle plane.'), ...blocks);
  }

  // Before printing: every picture.
  drawAll(): void {
    for (const paint of [...this.waiting.values()]) paint();
    this.waiting.clear();
  }

  private scenario(report: Report, index: RowIndex, s: number, open: boolean): HTMLElement {
    const pictures = report.pictures!.filter((p) => p.s === s);
    const names = (['speed', 'pressure', 'temperature', 'error'] as FieldName[]).filter((name) => pictures.some((p) => p[name]));
    const ranges = new Map(names.map((name) => [name, common(pictures, name)!]));
    const still = (name: FieldName) => { const r = ranges.get(name)!; return name !== 'error' && !(r.high - r.low > 1e-12 * Math.max(Math.abs(r.high), Math.abs(r.low))); };
    const shown = names.filter((name) => !still(name));
    const canvases: [HTMLCanvasElement, Picture, FieldName][] = [];
    const rows = pictures.map((picture) => {
      const method = index.text(picture.m);
      const facts = `${picture.particles} particles, dx = ${figure(real(picture.dx), 3)} m, c = ${figure(real(picture.c), 3)} m/s, ${picture.n} steps, t = ${figure(real(picture.t), 3)} s`;
      return h('div', { class: 'method' }, h('h3', {}, method, h('span', { class: 'soft' }, ` ${facts}`)),
        h('div', { class: 'fields' }, ...shown.map((name) => {
          const field = picture[name];
          const title = name === 'error' ? `error of the ${picture.error_of}` : fieldWords[name];
          if (!field) return h('figure', {}, h('figcaption', {}, name === 'error' ? 'error: no exact field is known' : `no ${name}`));
          const canvas = h('canvas', { role: 'img', 'aria-label': `${method}: ${title}` }) as HTMLCanvasElement;
          canvases.push([canvas, picture, name]);
          const most = name === 'error' ? `, at most ${figure(10 ** real(field.high), 2)}` : '';
          const buttons = savePlotButtons(`${name} of ${method}`, () => `${index.text(s)} ${name} ${method}`, () => fieldSvg(picture, name, ranges.get(name)!, title, `${index.text(s)}, ${method}: ${facts}`));
          return h('figure', {}, h('figcaption', {}, h('span', {}, `${title}${most}`), h('span', { class: 'pair' }, ...buttons)), canvas, scaleBar(name, ranges.get(name)!));
        })));
    });
    const box = h('details', { open: open || undefined }, h('summary', {}, `${index.text(s)}: ${pictures.length} method${pictures.length > 1 ? 's' : ''}`), h('p', { class: 'paper-only' }, h('b', {}, index.text(s))), ...rows) as HTMLDetailsElement;
    const paint = () => { for (const [canvas, picture, name] of canvases) draw(canvas, picture, name, ranges.get(name)!); };
    if (open) paint();
    else {
      this.waiting.set(box, paint);
      box.addEventListener('toggle', () => { this.waiting.get(box)?.(); this.waiting.delete(box); });
    }
    return box;
  }
}
