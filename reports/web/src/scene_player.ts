// The motion of a scene: the truth solid, methods beside it in outline with their errors magnified; play, pause, a slider.
import { commandLine, figure, real, shellWord } from './data';
import { copyButton, h, labelledSelect, option } from './dom';
import { DrawnScene, fittingMagnification, fromCentre, magnified, picture } from './scene_picture';
import { savePlotButtons } from './save';
import { standaloneSvg } from './standalone';
import { Changes, current, put } from './state';

export function scenePlayer(whole: DrawnScene, title: string, coloursOf: (methods: string[]) => string[]): HTMLElement {
  const drawn = fromCentre(whole), methods = drawn.methods ?? [], colours = coloursOf(methods.map((m) => m.id));
  const { element, show, beside } = picture(drawn, `${title}: shapes and the path of the truth`, 480, 300);
  const asked = current().get('scene') === drawn.id ? current() : new URLSearchParams();
  const tell = (changes: Changes) => put({ scene: drawn.id, ...changes });  // the scene that the page opens with has no name there yet
  const end = real(drawn.t_end);
  const slider = h('input', { type: 'range', min: 0, max: 1000, value: 0, 'aria-label': 'Time', class: 'time' }), words = h('output', { class: 'soft' });
  let running = false, t = 0, before = 0;
  const set = (time: number) => {
    t = Math.min(end, Math.max(0, time));
    show(t);
    slider.value = String(Math.round((1000 * t) / end));
    slider.setAttribute('aria-valuetext', `${figure(t, 3)} s`);
    words.textContent = `t = ${t.toFixed(end < 20 ? 2 : 1)} of ${figure(end, 4)} s`;
  };
  const span = Math.min(Math.max(end, 4), 12);  // seconds that the whole motion takes
  const frame = (now: number) => {
    if (!running || !element.isConnected) { running = false; return; }
    set(t + ((now - before) / 1000) * (end / span));
    before = now;
    if (t >= end) stop();
    else requestAnimationFrame(frame);
  };
  const stop = () => { running = false; button.textContent = 'play'; tell({ t: t > 0 ? String(Number(t.toPrecision(5))) : null }); };
  const button = h('button', { type: 'button', class: 'play', onclick: () => {
    if (running) { stop(); return; }
    if (t >= end) set(0);
    running = true;
    button.textContent = 'pause';
    before = performance.now();
    requestAnimationFrame(frame);
  } }, 'play');
  slider.addEventListener('input', () => { running = false; button.textContent = 'play'; set((Number(slider.value) / 1000) * end); tell({ t: String(Number(t.toPrecision(5))) }); });

  // The methods: which are drawn, and how many times as far from the truth as they are.
  const without = new Set(asked.get('without')?.split('\n') ?? []), told = h('span', {});
  const draw = () => {
    const shown = methods.filter((m) => !without.has(m.id)), fitting = fittingMagnification(drawn, shown);
    const chosen = magnify.select.value, k = chosen === 'fit' ? fitting : Number(chosen);
    beside(shown.map((m) => ({ drawn: magnified(drawn, m, k), colour: colours[methods.indexOf(m)] })));
    told.textContent = !shown.length ? '' : k === 1 ? ' Outlines: the methods as they are.' : ` Outlines: the methods, drawn ${figure(k, 2)} times as far from the truth as they are.`;
  };
  const magnify = labelledSelect('errors', 'scene-magnify', (value) => { draw(); tell({ magnify: value === 'fit' ? null : value }); });
  magnify.select.append(option('fit', 'magnified to be seen', true), option('1', 'as they are'), ...[10, 1e2, 1e3, 1e4, 1e6, 1e8, 1e10].map((k) => option(String(k), `${figure(k, 2)} times`)));
  const wanted = asked.get('magnify');
  if (wanted && [...magnify.select.options].some((one) => one.value === wanted)) magnify.select.value = wanted;
  const legend = methods.map((m, i) => {
    const one = h('button', { type: 'button', class: 'of-method', 'aria-pressed': String(!without.has(m.id)), style: `--colour: ${colours[i]}`, onclick: () => {
      if (without.has(m.id)) without.delete(m.id);
      else without.add(m.id);
      one.setAttribute('aria-pressed', String(!without.has(m.id)));
      draw();
      tell({ without: [...without].join('\n') });
    } }, `${m.id}, ${m.steps} steps`);
    return one;
  });
  if (methods.length) draw();
  const time = Number(asked.get('t') ?? 0);
  set(Number.isFinite(time) ? time : 0);
  const play = commandLine(`play ${shellWord(drawn.id)}${methods.map((m) => ` --method ${shellWord(m.id)}`).join('')}`);
  return h('figure', { class: 'scene-picture' }, element as unknown as Node, h('div', { class: 'bar' }, button, slider, words, ...savePlotButtons('this picture', () => `${drawn.id} picture`, () => standaloneSvg(element, `${title}, t = ${figure(t, 4)} s`))),
    methods.length ? h('div', { class: 'bar methods' }, ...legend, magnify.box) : null,
    h('figcaption', { class: 'hint' }, `Solid: the truth${fromCentre(whole) === whole ? '' : ', seen from the centre of the body'}.`, told, ' In three dimensions, with forces and contacts: ', h('code', {}, play), ' ', copyButton(play)));
}
