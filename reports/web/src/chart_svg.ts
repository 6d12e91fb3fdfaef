// A plot as an SVG document of its own: to save, and for paper.
import { figure } from './data';
import { svg } from './dom';
import { Drawing, decades, hasRoom, linearTicks, powerWord } from './drawing';
import { markerPath, token } from './style';

const [left, right, top, bottom] = [64, 14, 34, 46];

export function svgRoot(width: number, height: number, ...children: Node[]): SVGElement {
  return svg('svg', { xmlns: 'http://www.w3.org/2000/svg', viewBox: `0 0 ${width} ${height}`, width, height, 'font-family': 'system-ui, sans-serif' },
    svg('rect', { width, height, fill: token('--panel') }), ...children);
}
export function svgText(at: number, up: number, words: string, anchor: string, size = 12, colour = token('--soft')): SVGElement {
  const element = svg('text', { x: at.toFixed(1), y: up.toFixed(1), 'text-anchor': anchor, 'font-size': size, fill: colour });
  element.textContent = words;
  return element;
}

export function chartSvg({ spec, curves, x, y, zeroLine }: Drawing, width = 760, height = 460): SVGElement {
  const ink = token('--ink'), soft = token('--soft'), line = token('--line');
  const lines = Math.ceil(curves.length / 2), full = height + lines * 18;
  const inner = [width - left - right, height - top - bottom];
  const px = (v: number) => left + ((v - x[0]) / (x[1] - x[0] || 1)) * inner[0], py = (v: number) => top + (1 - (v - y[0]) / (y[1] - y[0] || 1)) * inner[1];
  const root = svgRoot(width, full, svgText(left, 20, spec.title, 'start', 14, ink));
  for (const v of spec.xLog ? decades(x[0], x[1], inner[0] / 60) : linearTicks(x[0], x[1], 7))
    root.append(svg('path', { d: `M${px(v)} ${top}V${height - bottom}`, stroke: line }), svgText(px(v), height - bottom + 16, spec.xLog ? powerWord(v) : figure(v, 4), 'middle'));
  for (const v of decades(y[0], y[1], inner[1] / 30)) root.append(svg('path', { d: `M${left} ${py(v)}H${width - right}`, stroke: line }), svgText(left - 6, py(v) + 4, powerWord(v), 'end'));
  root.append(svgText(left + inner[0] / 2, height - 10, spec.xLabel, 'middle'));
  const label = svgText(0, 0, spec.yLabel, 'middle');
  label.setAttribute('transform', `translate(14 ${top + inner[1] / 2}) rotate(-90)`);
  root.append(label);
  // An inner document cuts off what leaves the axes, and needs no id.
  const area = svg('svg', { x: left, y: top, width: inner[0], height: inner[1], viewBox: `${left} ${top} ${inner[0]} ${inner[1]}` });
  const level = (log: number, words: string) => {
    const at = py(log).toFixed(1);
    area.append(svg('path', { d: `M${left} ${at}H${width - right}`, stroke: soft, 'stroke-dasharray': '4 3' }), svgText(left + inner[0] * 0.42, Number(at) + 14, words, 'middle', 11));
  };
  if (spec.floor && spec.floor > 0) level(Math.log10(spec.floor), `truth's bar ${figure(spec.floor, 2)}`);
  if (zeroLine !== null) level(zeroLine, 'exactly 0');
  // Lines of the guides' slopes from the corner of the largest steps, as the plot shows them.
  const falling = spec.guides[0] < 0, from = falling ? x[0] : x[1], to = falling ? x[1] : x[0], up = y[1] - (y[1] - y[0]) * 0.04, down = y[0] + (y[1] - y[0]) * 0.04;
  const labels: [number, number][] = [];
  for (const slope of spec.guides) {
    const end = up + slope * (to - from), below = end < down, at = below ? from + (down - up) / slope : to;
    area.append(svg('path', { d: `M${px(from).toFixed(1)} ${py(up).toFixed(1)}L${px(to).toFixed(1)} ${py(end).toFixed(1)}`, stroke: soft, 'stroke-dasharray': '1.5 4' }));
    const lx = px(at), ly = py(below ? down : end);
    if (hasRoom(labels, lx, ly)) area.append(svgText(lx + (falling ? -6 : 6), ly + (below ? 4 : -4), `order ${Math.abs(slope)}`, falling ? 'end' : 'start', 11));
  }
  curves.forEach((curve, i) => {
    const points = curve.points.map((p) => [px(spec.xLog ? Math.log10(p.x) : p.x), py(p.y === 0 ? zeroLine ?? y[0] : Math.log10(p.y))]).filter((p) => p.every(Number.isFinite));
    const colour = curve.look.colour(), every = points.length > 24 ? Math.ceil(points.length / 7) : 1;
    area.append(svg('polyline', { points: points.map((p) => p.map((v) => v.toFixed(1)).join(',')).join(' '), fill: 'none', stroke: colour, 'stroke-width': 1.5, 'stroke-dasharray': curve.look.dash.join(' ') || 'none' }));
    points.filter((_, k) => k % every === 0).forEach(([a, b]) => area.append(svg('path', { d: markerPath(curve.look.marker, a, b, 3.6), fill: colour })));
    const at = [left + (i % 2) * (inner[0] / 2), height + 12 + Math.floor(i / 2) * 18];
    root.append(svg('path', { d: `M${at[0]} ${at[1] - 4}h26`, stroke: colour, 'stroke-width': 1.5, 'stroke-dasharray': curve.look.dash.join(' ') || 'none' }), svg('path', { d: markerPath(curve.look.marker, at[0] + 13, at[1] - 4, 3.6), fill: colour }), svgText(at[0] + 32, at[1], curve.name, 'start', 12, ink));
  });
  root.append(area, svg('rect', { x: left, y: top, width: inner[0], height: inner[1], fill: 'none', stroke: line }));
  return root;
}
