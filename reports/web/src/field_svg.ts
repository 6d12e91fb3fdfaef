// A field of a fluid as an SVG document of its own: particles as squares, axes in metres, the scale of the colours.
import { svgRoot, svgText } from './chart_svg';
import { Picture, figure, real } from './data';
import { svg } from './dom';
import { decades, linearTicks, powerWord } from './drawing';
import { FieldName, ValueRange, colour, colourIn } from './field_colours';
import { token } from './style';

const [left, right, width] = [72, 24, 720];
const tallest = 560, shortest = 24;  // of the particles' frame, in pixels
const headLine = 18, underFrame = 66, scaleHeight = 12, underScale = 46;
const shades = 60;                   // steps of the scale that is drawn; particles have the colour of their own value

// Words in lines of at most `most` characters, broken after spaces and after commas in ids.
function lines(words: string, most: number): string[] { return words.match(new RegExp(`.{1,${most - 1}}(?:[\\s,]|$)|.{1,${most}}`, 'g')) ?? []; }

// One path for each colour: of the particles of a colour, squares.
function particles(picture: Picture, name: FieldName, range: ValueRange, place: (x: number, y: number) => [number, number], side: number): SVGElement[] {
  const field = picture[name]!, low = real(field.low), span = real(field.high) - low;
  const paths = new Map<string, string>();
  field.at.forEach((level, i) => {
    const [x, y] = place(picture.x.at[i] / 4096, picture.y.at[i] / 4096), ink = colourIn(range, low + span * level / 250);
    paths.set(ink, `${paths.get(ink) ?? ''}M${(x - side / 2).toFixed(1)} ${(y - side / 2).toFixed(1)}h${side.toFixed(1)}v${side.toFixed(1)}h-${side.toFixed(1)}z`);
  });
  return [...paths].map(([fill, d]) => svg('path', { d, fill }));
}

function colourScale(name: FieldName, range: ValueRange, title: string, at: number, up: number, long: number): SVGElement[] {
  const flat = !(range.high > range.low), step = long / shades;
  const px = (value: number) => at + (flat ? 0.5 : (value - range.low) / (range.high - range.low)) * long;
  const ticks = flat ? [range.low] : name === 'error' ? decades(range.low, range.high, long / 70) : linearTicks(range.low, range.high, Math.max(2, Math.floor(long / 80)));
  const boxes = Array.from({ length: shades }, (_, k) => svg('rect', { x: (at + k * step).toFixed(2), y: up, width: (step + 0.5).toFixed(2), height: scaleHeight, fill: colour((k + 0.5) / shades) }));
  return [...boxes, svg('rect', { x: at, y: up, width: long, height: scaleHeight, fill: 'none', stroke: token('--line') }),
    ...ticks.flatMap((v) => [svg('path', { d: `M${px(v).toFixed(1)} ${up + scaleHeight}v4`, stroke: token('--soft') }), svgText(px(v), up + scaleHeight + 17, name === 'error' ? powerWord(v) : figure(v, 4), 'middle')]),
    svgText(at + long / 2, up + scaleHeight + 36, title, 'middle')];
}

// `title` names the field with its unit, `head` what it is a field of.
export function fieldSvg(picture: Picture, name: FieldName, range: ValueRange, title: string, head: string): SVGElement {
  const x = [real(picture.x.low), real(picture.x.high)], y = [real(picture.y.low), real(picture.y.high)];
  const scale = Math.min((width - left - right) / (x[1] - x[0] || 1e-300), tallest / (y[1] - y[0] || 1e-300), 1e290);
  const inner = [Math.max(shortest, (x[1] - x[0]) * scale), Math.max(shortest, (y[1] - y[0]) * scale)];
  const words = lines(head, 92), top = 14 + headLine * words.length;
  const start = left + (width - left - right - inner[0]) / 2, bottom = top + inner[1];
  const px = (v: number) => start + inner[0] / 2 + (v - (x[0] + x[1]) / 2) * scale, py = (v: number) => top + inner[1] / 2 - (v - (y[0] + y[1]) / 2) * scale;
  const root = svgRoot(width, Math.ceil(bottom + underFrame + scaleHeight + underScale));
  words.forEach((line, i) => root.append(svgText(left, 20 + headLine * i, line.trim(), 'start', 13, token('--ink'))));
  const frame = svg('svg', { x: start, y: top, width: inner[0], height: inner[1], viewBox: `${start} ${top} ${inner[0]} ${inner[1]}` });
  frame.append(...particles(picture, name, range, (a, b) => [px(x[0] + a * (x[1] - x[0])), py(y[0] + b * (y[1] - y[0]))], Math.max(1, real(picture.side) * scale * 1.5)));
  root.append(frame, svg('rect', { x: start, y: top, width: inner[0], height: inner[1], fill: 'none', stroke: token('--soft') }));
  for (const v of linearTicks(x[0], x[1], Math.max(1, Math.floor(inner[0] / 70)))) root.append(svg('path', { d: `M${px(v).toFixed(1)} ${bottom}v5`, stroke: token('--soft') }), svgText(px(v), bottom + 18, figure(v, 4), 'middle'));
  for (const v of linearTicks(y[0], y[1], Math.max(1, Math.floor(inner[1] / 36)))) root.append(svg('path', { d: `M${start} ${py(v).toFixed(1)}h-5`, stroke: token('--soft') }), svgText(start - 8, py(v) + 4, figure(v, 4), 'end'));
  const up = svgText(0, 0, 'y [m]', 'middle');
  up.setAttribute('transform', `translate(${start - 54} ${top + inner[1] / 2}) rotate(-90)`);
  root.append(svgText(start + inner[0] / 2, bottom + 36, 'x [m]', 'middle'), up, ...colourScale(name, range, title, left, bottom + underFrame, width - left - right));
  return root;
}
