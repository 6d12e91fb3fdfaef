// Parts of the page that keep nothing: a check box, the choices of speed, the words about the page.
import { copyButton, h, option } from '../dom';
import { Motion } from './motion';

const kSpeeds: [number, string][] = [[0.01, '1/100'], [0.03, '1/30'], [0.1, '1/10'], [0.3, '1/3'], [1, '1'], [3, '3'], [10, '10']];

export function speeds(chosen: number): HTMLOptionElement[] {
  const name = (value: number, text: string) => value === 1 ? 'real time' : value < 1 ? `${text} of real time` : `${text} \u00d7 real time`;
  return [option('whole', 'whole run in 10 s', chosen !== 1), ...kSpeeds.map(([value, text]) => option(String(value), name(value, text), value === chosen))];
}

export function checkBox(id: string, name: string, on: boolean, changed: (on: boolean) => void): { label: HTMLElement; box: HTMLInputElement } {
  const box = h('input', { type: 'checkbox', id, checked: on });
  box.addEventListener('change', () => changed(box.checked));
  return { label: h('label', { class: 'check', for: id }, box, name), box };
}

// Chooses as a reader would; nothing where there is no such choice.
export function choose(select: HTMLSelectElement, value: string | undefined): void {
  if (value === undefined || ![...select.options].some((one) => one.value === value)) return;
  select.value = value;
  select.dispatchEvent(new Event('change'));
}
export function tick(box: HTMLInputElement | undefined, on: boolean): void {
  if (!box || box.checked === on) return;
  box.checked = on;
  box.dispatchEvent(new Event('change'));
}

export const kKeys = 'Keys: space plays, left and right step by frames (with Shift by ten); in the scene Shift and arrows turn, W A S D move, + and \u2212 zoom, F fits.';

export function about(motion: Motion): HTMLElement {
  const { page } = motion, lost = motion.runs.reduce((sum, run) => sum + (run.events_left_out ?? 0), 0);
  return h('details', { class: 'about' }, h('summary', {}, 'About this page'),
    page.claim ? h('p', {}, page.claim) : null, page.source ? h('p', {}, `Source: ${page.source}`) : null,
    page.truth ? h('p', {}, `Truth: ${motion.runs[0].source}. The dotted line is its bar.`) : null,
    h('p', {}, `${page.samples} samples, ${motion.frames} frames here. Positions keep 16 bits of each body\u2019s range, differences from the truth 16 bits of their own. Between frames positions follow a cubic (straight lines where there are contacts) and attitudes a constant rate. Points and bodies too small to be seen are drawn as dots.`),
    lost ? h('p', {}, `${lost} events are left out.`) : null,
    h('p', {}, h('code', {}, page.command), ' ', copyButton(page.command)),
    h('p', { class: 'hint' }, 'Drag turns, shift and drag moves, the wheel zooms, a double click fits. '), h('p', { class: 'hint', id: 'keys' }, kKeys),
    h('p', { class: 'hint' }, 'The address keeps what is chosen here. three.js draws (MIT licence).'));
}
