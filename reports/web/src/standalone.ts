// A drawing of the page as an SVG document of its own: what style sheets say of each part becomes its attributes.
import { svg } from './dom';

// What a part has that says nothing.
const usual: Record<string, string> = { fill: 'rgb(0, 0, 0)', stroke: 'none', 'stroke-width': '1px', 'stroke-dasharray': 'none', 'stroke-linejoin': 'miter', opacity: '1' };
const ofText = ['font-size', 'text-anchor'];
const headLine = 26;

// Colours of the kind color(srgb r g b), which `color-mix` gives, are unknown to many programs that read SVG.
function plainColour(value: string): string {
  const parts = /^color\(srgb ([\d.e-]+) ([\d.e-]+) ([\d.e-]+)(?: \/ ([\d.e-]+))?\)$/.exec(value);
  if (!parts) return value;
  const [r, g, b] = parts.slice(1, 4).map((part) => Math.round(255 * Number(part)));
  return parts[4] === undefined ? `rgb(${r},${g},${b})` : `rgba(${r},${g},${b},${parts[4]})`;
}

function background(element: Element): string {
  for (let at: Element | null = element; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor;
    if (!/^(transparent|rgba\(.*, 0\))$/.test(colour)) return plainColour(colour);
  }
  return '#fff';
}

export function standaloneSvg(shown: SVGElement, title: string): SVGElement {
  const [x, y, width, height] = shown.getAttribute('viewBox')!.split(' ').map(Number);
  const copy = shown.cloneNode(true) as SVGElement, parts = copy.querySelectorAll('*');
  shown.querySelectorAll('*').forEach((from, i) => {
    if (!(from instanceof SVGGraphicsElement)) return;
    const style = getComputedStyle(from), to = parts[i];
    // A group hands most on to its parts, each of which is asked; but not its opacity.
    for (const name of from.tagName === 'g' ? ['opacity'] : Object.keys(usual)) {
      const value = style.getPropertyValue(name);
      if (value !== usual[name]) to.setAttribute(name, plainColour(value));
    }
    if (from.tagName === 'text') for (const name of ofText) to.setAttribute(name, style.getPropertyValue(name));
    to.removeAttribute('class');
  });
  const ink = getComputedStyle(shown).color, full = height + headLine;
  const words = svg('text', { x: x + 8, y: y - 8, 'font-size': 13, fill: ink });
  words.textContent = title;
  return svg('svg', { xmlns: 'http://www.w3.org/2000/svg', viewBox: `${x} ${y - headLine} ${width} ${full}`, width, height: full, 'font-family': 'system-ui, sans-serif' },
    svg('rect', { x, y: y - headLine, width, height: full, fill: background(shown) }), words,
    svg('svg', { x, y, width, height, viewBox: shown.getAttribute('viewBox')! }, ...copy.childNodes));  // cuts off what leaves the picture
}
