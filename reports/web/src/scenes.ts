// The scenes as pictures, each a link to its page; and what a scene's page has besides its plot.
import { Report, engineOf, figure, inBrackets, placeWords, real, seconds, unitWord } from './data';
import { Child, h, section } from './dom';
import { fluidOf, fluidPicture, fluidWords } from './fluid_picture';
import { RowIndex } from './rows';
import { inSentence, sceneMetric, titleOf } from './scene_metric';
import { savePlotButtons } from './save';
import { picture } from './scene_picture';
import { scenePlayer } from './scene_player';
import { gatesTable } from './sections';
import { metricWords } from './story';
import { standaloneSvg } from './standalone';
import { smallTable } from './table';

const drawnScene = (report: Report, id: string) => report.scenes?.find((s) => s.id === id);

// A still: the motion of the truth, or the particles of a fluid; null where the report has neither.
export function still(report: Report, id: string, width: number, height: number): SVGElement | null {
  const drawn = drawnScene(report, id), fluid = fluidOf(report, id);
  return drawn ? picture(drawn, '', width, height).element : fluid ? fluidPicture(fluid, '', width, height, 5 * width) : null;
}

function winnerOf(report: Report, id: string): string {
  const table = report.dominance.find((t) => t.scenario === id && t.cost === 'seconds') ?? report.dominance.find((t) => t.scenario === id);
  const contest = table && [...table.by_error].sort((a, b) => Math.abs(Math.log10(real(a.asked)) + 6) - Math.abs(Math.log10(real(b.asked)) + 6))[0];
  return contest ? `${`${real(contest.asked).toExponential(0)} ${unitWord(table.unit)}`.trim()}: ${contest.ranked[0].family.replace(':tol', '')}` : '';
}

export function gallery(report: Report, ids: string[]): HTMLElement | null {
  if (ids.length < 2) return null;
  const bad = new Set(report.verdicts.filter((v) => v.judgement !== 'pass').map((v) => v.scenario));
  const all = ids.map((id) => {
    const winner = winnerOf(report, id), place = h('span', { class: 'thumbnail' });
    place.append(still(report, id, 200, 130) ?? '');
    return h('li', {}, h('a', { href: `#scene=${encodeURIComponent(id)}` }, place, h('b', {}, titleOf(report, id)), h('span', { class: 'soft' }, id),
      winner ? h('span', { class: 'soft' }, winner) : null, bad.has(id) ? h('span', { class: 'badge fail' }, 'a gate did not pass') : null));
  });
  const few = 12;
  return section('scenes', `${ids.length} scenes`, h('p', { class: 'hint' }, 'Shapes at the start and the path of the truth, or the particles at the end by their speed. Below each: the cheapest method for an error. A click opens the scene: claim, motion, plot, winners, gates.'),
    h('ul', { class: 'gallery' }, ...all.slice(0, few)),
    all.length > few ? h('details', {}, h('summary', {}, `${all.length - few} more scenes`), h('ul', { class: 'gallery' }, ...all.slice(few))) : null);
}

function ofFluid(report: Report, id: string): Child {
  const fluid = fluidOf(report, id);
  if (!fluid) return null;
  const words = fluidWords(report, fluid), drawn = fluidPicture(fluid, words, 480, 300, 2500);
  return h('figure', { class: 'scene-picture' }, drawn as unknown as Node,
    h('div', { class: 'bar' }, ...savePlotButtons('this picture', () => `${id} picture`, () => standaloneSvg(drawn, titleOf(report, id)))), h('figcaption', { class: 'hint' }, `${words}.`));
}

export function winners(report: Report, id: string): Child {
  const table = report.dominance.find((t) => t.scenario === id && t.cost === 'seconds') ?? report.dominance.find((t) => t.scenario === id);
  if (!table?.by_error.length) return null;
  const cost = (value: number) => (table.cost === 'seconds' ? seconds(value) : `${Math.round(value)} evaluations`);
  type Line = (typeof table.by_error)[number];
  const other = (line: Line) => line.ranked.find((r) => engineOf(r.family) !== engineOf(line.ranked[0].family));
  return h('div', {}, h('h3', {}, `Cheapest for an error: ${metricWords(table.metric)}${inBrackets(table.unit)}`), smallTable<Line>([
    { name: 'error', number: true, value: (l) => real(l.asked), cell: (l) => real(l.asked).toExponential(0) },
    { name: 'cheapest', value: (l) => l.ranked[0].family, cell: (l) => h('b', {}, l.ranked[0].family) },
    { name: 'at', value: (l) => placeWords(l.ranked[0]) },
    { name: table.cost === 'seconds' ? 'time' : 'evaluations', number: true, value: (l) => real(l.ranked[0].cost), cell: (l) => cost(real(l.ranked[0].cost)) },
    { name: 'best of another engine', value: (l) => other(l)?.family ?? 'none reaches it' },
    { name: 'its cost', number: true, value: (l) => real(other(l)?.cost) / real(l.ranked[0].cost), cell: (l) => (other(l) ? `\u00d7 ${figure(real(other(l)!.cost) / real(l.ranked[0].cost), 3)}` : '\u2013') },
  ], table.by_error, `Cheapest on ${id}`));
}

function aboutWords(report: Report, index: RowIndex, id: string): string {
  const metric = sceneMetric(report, index, id), named = report.scenarios.find((s) => s.id === id)?.metric;
  const missing = named && named !== metric ? ` Its file names ${named}, of which there is no figure here.` : '';
  return `This scene is about the ${inSentence(metricWords(metric))}.${missing}`;
}

export function sceneHead(report: Report, index: RowIndex, id: string, colours: (methods: string[]) => string[]): Child[] {
  const drawn = drawnScene(report, id);
  return [drawn ? scenePlayer(drawn, titleOf(report, id), colours) : ofFluid(report, id), h('p', { class: 'hint' }, aboutWords(report, index, id))];
}

export function moreOfScene(report: Report, index: RowIndex, id: string): Child[] {
  const verdicts = report.verdicts.filter((v) => v.scenario === id);
  const passed = verdicts.filter((v) => v.judgement === 'pass').length, rows = index.of(id).length;
  const link = h('a', { href: `#row-scenario=${encodeURIComponent(id)}&row-method=&row-metric=&row-status=&q=&at=rows&scene=${encodeURIComponent(id)}` }, `${rows} rows`);
  return [winners(report, id), verdicts.length ? h('div', {}, h('h3', {}, 'Gates'), h('details', { open: passed < verdicts.length || undefined }, h('summary', {}, `${passed} of ${verdicts.length} gates pass`), gatesTable(verdicts, `Gates of ${id}`))) : null, h('p', {}, 'All figures of this scene: ', link, '.')];
}
