// What a plot shows, apart from where it is drawn: the points on the logarithms of the axes, the ranges, the line of zeros.
import { figure } from './data';
import type { Look } from './style';

export interface Point { x: number; y: number; note: string[] }
export interface Curve { name: string; look: Look; points: Point[] }
export interface ChartSpec {
  id: string; title: string; xLabel: string; yLabel: string; xLog: boolean;
  curves: Curve[]; floor: number | null; guides: number[];  // slopes on the logs; floor: in units of y
  empty: string;                                            // the text shown where there is nothing to draw
}
export interface Placed { curve: number; x: number; y: number; zero: boolean; point: Point }
export type Range = [number, number];
export interface Drawing { spec: ChartSpec; curves: Curve[]; placed: Placed[]; x: Range; y: Range; zeroLine: number | null }

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
// At most `most` round values of a linear axis.
export function linearTicks(min: number, max: number, most: number): number[] {
  const span = max - min;
  if (!(span > 0 && Number.isFinite(span))) return [];
  const power = 10 ** Math.floor(Math.log10(span / (most + 1))), wide = power * [1, 2, 5, 10].find((m) => span / (m * power) < most)!;
  return Array.from({ length: most + 1 }, (_, i) => (Math.ceil(min / wide) + i) * wide).filter((v) => v <= max);
}
const superscripts = '\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079';
export function powerWord(log: number): string {
  const value = 10 ** log;
  if (Math.abs(log - Math.round(log)) > 1e-9) return figure(value, 2);
  if (log >= -2 && log <= 3) return String(Number(value.toPrecision(3)));
  const digits = String(Math.abs(Math.round(log))).split('').map((d) => superscripts[Number(d)]).join('');
  return `10${log < 0 ? '\u207b' : ''}${digits}`;
}

// Whether a label at this place (pixels, times `scale` on a canvas) would lie on none of `labels`; it is then one of them.
export function hasRoom(labels: [number, number][], x: number, y: number, scale = 1): boolean {
  if (labels.some(([x0, y0]) => Math.abs(x - x0) < 48 * scale && Math.abs(y - y0) < 13 * scale)) return false;
  labels.push([x, y]);
  return true;
}

// Logarithms; zeros are drawn on a separate line below all other values.
export function arrange(spec: ChartSpec, hidden: Set<string>): Drawing {
  const curves = spec.curves.filter((curve) => !hidden.has(curve.name));
  const logs = curves.flatMap((curve) => curve.points.filter((p) => p.y > 0).map((p) => Math.log10(p.y)));
  const low = logs.reduce((a, b) => Math.min(a, b), logs.length ? Infinity : -16);
  const zeroLine = curves.some((curve) => curve.points.some((p) => p.y === 0)) ? Math.floor(low) - 1 : null;
  const placed: Placed[] = [];
  curves.forEach((curve, index) => curve.points.forEach((point) => {
    const x = spec.xLog ? Math.log10(point.x) : point.x, zero = point.y === 0;
    const y = zero ? zeroLine! : Math.log10(point.y);
    if (Number.isFinite(x) && Number.isFinite(y)) placed.push({ curve: index, x, y, zero, point });
  }));
  if (!placed.length) return { spec, curves, placed, x: [0, 1], y: [0, 1], zeroLine };
  const xs = placed.map((p) => p.x), ys = placed.map((p) => p.y);
  const floor = spec.floor && spec.floor > 0 ? Math.log10(spec.floor) : NaN;
  if (floor > Math.min(...ys) - 4) ys.push(floor);
  return { spec, curves, placed, zeroLine, x: padded(Math.min(...xs), Math.max(...xs), spec.xLog ? 0.05 : 0), y: padded(Math.min(...ys), Math.max(...ys), 0.06) };
}
