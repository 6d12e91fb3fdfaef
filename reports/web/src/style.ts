// Colour, marker and dash of every method: eight colours that colour-blind readers can tell apart (Okabe and Ito 2008;
// yellow darkened on white), seven markers. 8 and 7 share no divisor, so the first 56 methods all differ.
import { svg } from './dom';

const light = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#000000', '#a89a00'];
const dark = ['#4aa3df', '#ff7f2a', '#1fc796', '#e39ac4', '#f0b429', '#8fd0f5', '#f2f2f2', '#f0e442'];
export const markers = ['circle', 'square', 'up', 'diamond', 'down', 'cross', 'plus'] as const;
export type Marker = (typeof markers)[number];
const dashes: number[][] = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

export interface Look { colour: () => string; marker: Marker; dash: number[] }

let paper = false;  // printing: always light
export function setPaper(on: boolean): void { paper = on; }
export function isDark(): boolean {
  if (paper) return false;
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
}

export function look(index: number): Look {
  return {
    colour: () => (isDark() ? dark : light)[index % 8],
    marker: markers[index % 7],
    dash: dashes[Math.floor(index / 8) % dashes.length],
  };
}

// The outline of a marker around (x, y), for canvas and for SVG alike.
export function markerPath(marker: Marker, x: number, y: number, r: number): string {
  const p = (points: number[][]) => `M${points.map(([a, b]) => `${x + a * r} ${y + b * r}`).join('L')}Z`;
  switch (marker) {
    case 'circle': return `M${x - r} ${y}A${r} ${r} 0 1 0 ${x + r} ${y}A${r} ${r} 0 1 0 ${x - r} ${y}Z`;
    case 'square': return p([[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]);
    case 'up': return p([[0, -1.15], [1.1, 0.85], [-1.1, 0.85]]);
    case 'down': return p([[0, 1.15], [1.1, -0.85], [-1.1, -0.85]]);
    case 'diamond': return p([[0, -1.3], [1.15, 0], [0, 1.3], [-1.15, 0]]);
    case 'cross': return p([[-1.1, -0.7], [-0.7, -1.1], [0, -0.4], [0.7, -1.1], [1.1, -0.7], [0.4, 0], [1.1, 0.7],
                            [0.7, 1.1], [0, 0.4], [-0.7, 1.1], [-1.1, 0.7], [-0.4, 0]]);
    case 'plus': return p([[-0.3, -1.25], [0.3, -1.25], [0.3, -0.3], [1.25, -0.3], [1.25, 0.3], [0.3, 0.3],
                           [0.3, 1.25], [-0.3, 1.25], [-0.3, 0.3], [-1.25, 0.3], [-1.25, -0.3], [-0.3, -0.3]]);
  }
}

export function swatch(style: Look): SVGElement {
  const colour = style.colour();
  return svg('svg', { width: 34, height: 14, viewBox: '0 0 34 14', 'aria-hidden': 'true' },
    svg('line', { x1: 1, x2: 33, y1: 7, y2: 7, stroke: colour, 'stroke-width': 2, 'stroke-dasharray': style.dash.join(' ') }),
    svg('path', { d: markerPath(style.marker, 17, 7, 4.5), fill: colour }));
}

export function token(name: string): string {
  const source = paper ? paperTokens[name] : undefined;
  return source ?? getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
const paperTokens: Record<string, string> = {
  '--ink': '#16191d', '--soft': '#50575f', '--line': '#d9dde1', '--panel': '#ffffff', '--floor': 'rgba(110,118,126,.16)',
};
