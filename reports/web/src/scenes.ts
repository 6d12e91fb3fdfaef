// The scenes as pictures, each a link to its page; and what a scene's page has besides its plot.
import { Report, engineOf, figure, placeWords, real, seconds } from './data';
import { Child, copyButton, h, section } from './dom';
import { commandLine, shellWord } from './data';
import { RowIndex } from './rows';
import { inSentence, sceneMetric, titleOf } from './scene_metric';
import { DrawnScene, fromCentre, picture } from './scene_picture';
import { gatesTable } from './sections';
import { current, put } from './state';
import { metricWords } from './story';
import { smallTable } from './table';

const drawnScene = (report: Report, id: string) => report.scenes?.find((s) => s.id === id);

function winnerOf(report: Report, id: string): string {
  const table = report.dominance.find((t) => t.scenario === id && t.cost === 'seconds') ?? report.dominance.find((t) => t.scenario === id);
  const contest = table && [...table.by_error].sort((a, b) => Math.abs(Math.log10(real(a.asked)) + 6) - Math.abs(Math.log10(real(b.asked)) + 6))[0];
  return contest ? `${real(contest.asked).toExponential(0)} ${table.unit}: ${contest.ranked[0].family.replace(':tol', '')}` : '';
}

export function gallery(report: Report, ids: string[]): HTMLElement | null {
  if (ids.length < 2) return null;
  const bad = new Set(report.verdicts.filter((v) => v.judgement !== 'pass').map((v) => v.scenario));
  const all = ids.map((id) => {
    const drawn = drawnScene(report, id), winner = winnerOf(report, id);
    const place = h('span', { class: 'thumbnail' });
    if (drawn) place.append(picture(drawn, '', 200, 130).element);
    return h('li', {}, h('a', { href: `#scene=${encodeURIComponent(id)}` }, place, h('b', {}, titleOf(report, id)), h('span', { class: 'soft' }, id),
      winner ? h('span', { class: 'soft' }, winner) : null, bad.has(id) ? h('span', { class: 'badge fail' }, 'a gate did not pass') : null));
  });
  const few = 12;
  return section('scenes', `${ids.length} scenes`, h('p', { class: 'hint' }, 'Shapes at the start and the path of the truth. Below each: the cheapest method for an error. A click opens the scene: claim, motion, plot, winners, gates.'),
    h('ul', { class: 'gallery' }, ...all.slice(0, few)),
    all.length > few ? h('details', {}, h('summary', {}, `${all.length - few} more scenes`), h('ul', { class: 'gallery' }, ...all.slice(few))) : null);
}

// The picture with its time: play, pause, a slider.
function player(drawn: DrawnScene, title: string): HTMLElement {
  const { element, show } = picture(drawn, `${title}: shapes and the path of the truth`, 480, 300);
  const end = real(drawn.t_end), still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  const slider = h('input', { type: 'range', min: 0, max: 1000, value: 0, 'aria-label': 'Time', class: 'time' }), words = h('output', { class: 'soft' });
  const seen = fromCentre(drawn) === drawn ? '' : ', seen from the centre of the body';
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
  const stop = () => { running = false; button.textContent = 'play'; put({ t: t > 0 ? String(Number(t.toPrecision(5))) : null }); };
  const button = h('button', { type: 'button', class: 'play', onclick: () => {
    if (running) { stop(); return; }
    if (t >= end) set(0);
    running = true;
    button.textContent = 'pause';
    before = performance.now();
    requestAnimationFrame(frame);
  } }, 'play');
  slider.addEventListener('input', () => { running = false; button.textContent = 'play'; set((Number(slider.value) / 1000) * end); put({ t: String(Number(t.toPrecision(5))) }); });
  const asked = Number(current().get('t') ?? 0);
  set(Number.isFinite(asked) && current().get('scene') === drawn.id ? asked : 0);
  return h('figure', { class: 'scene-picture' }, element as unknown as Node, h('div', { class: 'bar' }, button, slider, words),
    still ? h('figcaption', { class: 'hint' }, `The motion of the truth${seen}.`) : h('figcaption', { class: 'hint' }, `The motion of the truth${seen}; several methods together: `, h('code', {}, commandLine(`play ${shellWord(drawn.id)} --method METHOD`)), ' ', copyButton(commandLine(`play ${shellWord(drawn.id)}`))));
}

function winners(report: Report, id: string): Child {
  const table = report.dominance.find((t) => t.scenario === id && t.cost === 'seconds') ?? report.dominance.find((t) => t.scenario === id);
  if (!table?.by_error.length) return null;
  const cost = (value: number) => (table.cost === 'seconds' ? seconds(value) : `${Math.round(value)} evaluations`);
  type Line = (typeof table.by_error)[number];
  const other = (line: Line) => line.ranked.find((r) => engineOf(r.family) !== engineOf(line.ranked[0].family));
  return h('div', {}, h('h3', {}, `Cheapest for an error: ${metricWords(table.metric)} [${table.unit}]`), smallTable<Line>([
    { name: 'error', number: true, value: (l) => real(l.asked), cell: (l) => real(l.asked).toExponential(0) },
    { name: 'cheapest', value: (l) => l.ranked[0].family, cell: (l) => h('b', {}, l.ranked[0].family) },
    { name: 'at', value: (l) => placeWords(l.ranked[0]) },
    { name: table.cost === 'seconds' ? 'time' : 'evaluations', number: true, value: (l) => real(l.ranked[0].cost), cell: (l) => cost(real(l.ranked[0].cost)) },
    { name: 'best of another engine', value: (l) => other(l)?.family ?? 'none reaches it' },
    { name: 'its cost', number: true, value: (l) => real(other(l)?.cost) / real(l.ranked[0].cost), cell: (l) => (other(l) ? `\u00d7 ${figure(real(other(l)!.cost) / real(l.ranked[0].cost), 3)}` : '\u2013') },
  ], table.by_error, `Cheapest on ${id}`));
}

export function aboutScene(report: Report, index: RowIndex, id: string): { head: Child[]; extra: Child[] } {
  const drawn = drawnScene(report, id), verdicts = report.verdicts.filter((v) => v.scenario === id);
  const passed = verdicts.filter((v) => v.judgement === 'pass').length, rows = index.of(id).length;
  const link = h('a', { href: `#row-scenario=${encodeURIComponent(id)}&at=rows&scene=${encodeURIComponent(id)}` }, `${rows} rows`);
  return {
    head: [drawn ? player(drawn, titleOf(report, id)) : null, h('p', { class: 'hint' }, `This scene is about the ${inSentence(metricWords(sceneMetric(report, index, id)))}.`)],
    extra: [winners(report, id), verdicts.length ? h('div', {}, h('h3', {}, 'Gates'), h('details', { open: passed < verdicts.length || undefined }, h('summary', {}, `${passed} of ${verdicts.length} gates pass`), gatesTable(verdicts, `Gates of ${id}`))) : null, h('p', {}, 'All figures of this scene: ', link, '.')],
  };
}
