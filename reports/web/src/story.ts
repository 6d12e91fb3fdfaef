// The first screen: sentences made from the rows. Who is cheapest, what each engine loses, what float costs, what is missing.
import { Contest, Dominance, Loose, Report, engineOf, figure, inBrackets, placeWords, real, rungWords, seconds, unitWord, withBar } from './data';
import { Child, h, section } from './dom';
import { changeCounts } from './history';
import { RowIndex } from './rows';
import { Figure, figuresOf, inSentence, nearRate, sceneMetric, secondsOf, tellingScenes, titleOf } from './scene_metric';
import { isSweep } from './sweep';

const hertz = 240, wanted = 1e-6;
const toScene = (id: string, words: string) => h('a', { href: `#scene=${encodeURIComponent(id)}` }, words);
const power = (value: number) => value.toExponential(0);
const times = (ratio: number) => `${figure(Number(ratio.toPrecision(2)), 3)} times`;
export const metricWords = (metric: string) => metric.replace(/^error-(.*?)(-max|-end|-rms)?$/, (_, what: string, when?: string) => `error of the ${what.replace('-', ' ')}${when === '-max' ? ', largest over the run' : when === '-end' ? ' at the end' : ''}`).replace(/^impact-place-error$/, 'error of the places of impact').replace(/-/g, ' ');
const list = (words: string[]) => (words.length < 2 ? words.join('') : `${words.slice(0, -1).join(', ')} and ${words[words.length - 1]}`);

// The contest whose level is nearest to the wanted error; the smaller of two.
function contestAt(table: Dominance): Contest | undefined {
  const away = (contest: Contest) => Math.abs(Math.log10(real(contest.asked) / wanted));
  return [...table.by_error].reverse().reduce<Contest | undefined>((best, contest) => (!best || away(contest) < away(best) - 1e-9 ? contest : best), undefined);
}
function costWords(table: Dominance, cost: Loose): string {
  return table.cost === 'seconds' ? seconds(real(cost)) : `${Math.round(real(cost))} evaluations`;
}

// What the engines outside a contest reach: their smallest error at any step that was measured.
function outside(index: RowIndex, table: Dominance, contest: Contest): Child {
  const inside = new Set(contest.ranked.map((r) => engineOf(r.family)));
  const asked = real(contest.asked), reach: string[] = [], not: string[] = [];
  const ladders = index.ladders(table.scenario, table.metric, '');
  for (const engine of new Set([...ladders.keys()].map(engineOf))) {
    if (inside.has(engine)) continue;
    let best: Figure | undefined;
    for (const [method, cells] of ladders) if (engineOf(method) === engine) for (const cell of cells) if (Number.isFinite(cell.value) && (!best || cell.value < best.cell.value)) best = { method, cell };
    if (!best) continue;
    if (best.cell.value > asked) not.push(`${engine} (${figure(best.cell.value, 2)} at best)`);
    else {
      const first = [...ladders].filter(([method]) => engineOf(method) === engine).flatMap(([method, cells]) => cells.filter((c) => c.value <= asked).map((cell) => ({ method, cell }))).sort((a, b) => a.cell.steps - b.cell.steps)[0];
      reach.push(`${first.method} at ${rungWords(first.method, first.cell.steps)}`);
    }
  }
  const parts = [reach.length ? `It is also reached by ${list(reach)}, at a higher cost or one that was not measured.` : '', not.length ? `Not reached at any step size that ran by ${list(not)}.` : ''].filter(Boolean);
  return parts.length ? h('details', { class: 'soft' }, h('summary', {}, 'Other engines'), parts.join(' ')) : null;
}

function cheapest(report: Report, index: RowIndex, ids: string[]): HTMLElement[] {
  const tables = ids.map((id) => report.dominance.find((t) => t.scenario === id && t.cost === 'seconds') ?? report.dominance.find((t) => t.scenario === id)).filter((t): t is Dominance => !!t?.by_error.length);
  return tables.map((table) => {
    const contest = contestAt(table)!, best = contest.ranked[0];
    const other = contest.ranked.find((r) => engineOf(r.family) !== engineOf(best.family));
    return h('li', {}, toScene(table.scenario, titleOf(report, table.scenario)), `, to ${`${power(real(contest.asked))} ${unitWord(table.unit)}`.trim()} (${metricWords(table.metric)}): use `,
      h('b', {}, best.family.replace(':tol', '')), ` (${placeWords(best)}, ${costWords(table, best.cost)}). `,
      other ? `The best of another engine is ${other.family.replace(':tol', '')} (${placeWords(other)}), at ${real(other.cost) < 1.05 * real(best.cost) ? 'the same' : `${times(real(other.cost) / real(best.cost))} the`} cost.` : `No other engine with a measured cost reaches it.`,
      outside(index, table, contest));
  });
}

// Wins and losses over all scenes at one level.
function tally(report: Report): Child {
  const kind = report.dominance.some((t) => t.cost === 'seconds') ? 'seconds' : 'evaluations';
  const contests = report.dominance.filter((t) => t.cost === kind).map((table) => ({ table, contest: table.by_error.find((c) => Math.abs(Math.log10(real(c.asked) / wanted)) < 0.01) }))
    .filter((entry): entry is { table: Dominance; contest: Contest } => !!entry.contest && new Set(entry.contest.ranked.map((r) => engineOf(r.family))).size > 1);
  if (contests.length < 2) return null;
  const wins = new Map<string, typeof contests>();
  for (const entry of contests) { const engine = engineOf(entry.contest.ranked[0].family); wins.set(engine, [...(wins.get(engine) ?? []), entry]); }
  const parts = [...wins].sort((a, b) => b[1].length - a[1].length).map(([engine, won]) => `${engine} on ${won.length}`);
  const lost = contests.map(({ table, contest }) => {
    const ours = contest.ranked.find((r) => engineOf(r.family) === 'atwood');
    return { table, best: contest.ranked[0], ratio: ours ? real(ours.cost) / real(contest.ranked[0].cost) : Infinity };
  }).filter((l) => l.ratio > 1 && engineOf(l.best.family) !== 'atwood').sort((a, b) => b.ratio - a.ratio);
  const shown = lost.slice(0, 3).flatMap((l, i): Child[] => [i ? ', ' : '', toScene(l.table.scenario, l.table.scenario), Number.isFinite(l.ratio) ? ` (${times(l.ratio)} the cost of ${l.best.family.replace(':tol', '')})` : ` (does not reach it, ${l.best.family.replace(':tol', '')} does)`]);
  return h('p', {}, h('b', {}, `Cheapest to 1e-6 by ${kind === 'seconds' ? 'time' : 'evaluations'}`), `, on the ${contests.length} scenes where more than one engine reaches it: ${list(parts)}. `,
    ...(lost.length ? [`Atwood\u2019s own methods lose most on `, ...shown, lost.length > 3 ? `, and on ${lost.length - 3} more. ` : '. '] : []), h('a', { href: '#dominance' }, 'All scenes and errors'), '.');
}

// A table: what the default method of each engine loses at about 240 steps per second, and its best method.
function losses(report: Report, index: RowIndex, ids: string[]): HTMLElement | null {
  const columns = ids.map((id) => {
    const metric = sceneMetric(report, index, id), t_end = secondsOf(report, id);
    return { id, metric, t_end, ladders: index.ladders(id, metric, '') };
  });
  const engines = [...new Set(columns.flatMap((c) => [...c.ladders.keys()].map(engineOf)))];
  if (engines.length < 2 || !columns.length) return null;
  const found = engines.map((engine) => columns.map((column) => {
    const figures = figuresOf(column.ladders, engine, hertz, column.t_end);
    const standard = figures.find((f) => /\/default/.test(f.method));
    return { best: figures[0] as Figure | undefined, shown: standard ?? figures[0] };
  }));
  const least = columns.map((_, c) => Math.min(...found.map((line) => Math.abs(line[c].best?.cell.value ?? Infinity))));
  const unitOf = (c: number) => { const one = found.map((l) => l[c].shown).find(Boolean); return one ? unitWord(index.text(index.rows.unit[one.cell.row])) : ''; };
  const rate = (c: number) => { const one = found.map((l) => l[c].shown).find((f) => f && f.cell.steps); return one ? figure(one.cell.steps / columns[c].t_end, 3) : '\u2013'; };
  const words = (f: Figure) => withBar(Number(f.cell.value.toPrecision(3)), f.cell.bar);
  const line = (engine: string, e: number) => h('tr', {}, h('th', { scope: 'row' }, engine), ...columns.map((_, c) => {
    const { best, shown } = found[e][c];
    if (!shown || !best) return h('td', { class: 'soft' }, h('a', { href: '#cells' }, 'no figure'));
    const first = Math.abs(best.cell.value) <= least[c];
    const improved = best.method !== shown.method && Math.abs(best.cell.value) < 0.9 * Math.abs(shown.cell.value);
    return h('td', {}, h(first && !improved ? 'b' : 'span', {}, words(shown)), h('span', { class: 'soft' }, ` ${shown.method.split('/').slice(1).join('/')}`),
      improved ? h('span', { class: 'behind' }, first ? h('b', {}, words(best)) : words(best), ` ${best.method.split('/').slice(1).join('/')}`) : null);
  }));
  return h('div', {}, h('h3', {}, `What each engine loses at ${hertz} steps a second: its error`),
    h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Errors at 240 steps a second' }, h('table', { class: 'losses' },
      h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'engine'), ...columns.map((c, i) => h('th', { scope: 'col' }, toScene(c.id, c.id), h('span', { class: 'behind' }, `${metricWords(c.metric)}${inBrackets(unitOf(i))}${rate(i) === String(hertz) ? '' : `, at ${rate(i)} a second, the nearest that ran`}`))))),
      h('tbody', {}, ...engines.map(line)))),
    h('p', { class: 'hint' }, 'The default settings of each engine, or its best method where it has none; the second line is its best method where that is better by a tenth. Methods that choose their steps count where an engine has no others. Bold: the smallest error of the column.'));
}

function float(report: Report, index: RowIndex, ids: string[]): Child {
  interface Pair { id: string; metric: string; method: string; steps: number; single: number; double: number }
  const pairs: Pair[] = [];
  for (const id of ids) {
    const metric = sceneMetric(report, index, id), ladders = index.ladders(id, metric, ''), t_end = secondsOf(report, id);
    for (const [method, cells] of ladders) {
      const twin = method.endsWith('@float') ? method.slice(0, -6) : method.startsWith('bullet32/') ? method.replace('bullet32/', 'bullet64/') : '';
      const near = nearRate(cells, hertz, t_end);
      const other = twin && near ? ladders.get(twin)?.find((c) => c.steps === near.steps) : undefined;
      if (near && other && near.value > 0 && other.value > 0) pairs.push({ id, metric, method, steps: near.steps, single: near.value, double: other.value });
    }
  }
  if (!pairs.length) return null;
  const sentences = ['atwood', 'bullet32'].flatMap((engine): Child[] => {
    const own = pairs.filter((p) => engineOf(p.method) === engine).sort((a, b) => b.single / b.double - a.single / a.double);
    if (!own.length) return [];
    const worst = own[0], little = own.filter((p) => p.single / p.double < 1.1).length;
    const words = worst.single / worst.double > 1.1 ? [`${worst.method} has ${figure(worst.single, 2)} on `, toScene(worst.id, worst.id), ` at ${worst.steps} steps, where double has ${figure(worst.double, 2)} (${times(worst.single / worst.double)}). `] : [`${engine} has the same error in float within a tenth. `];
    return [...words, own.length > 1 && worst.single / worst.double > 1.1 ? little ? `In ${little} of its ${own.length} runs with a twin in double the errors differ by less than a tenth. ` : '' : ''];
  });
  return h('p', {}, h('b', {}, 'What float costs'), ' at about 240 steps a second: ', ...sentences);
}

function missing(index: RowIndex): Child {
  const cells = new Map<string, { status: string; engine: string; reason: string; cells: Set<string> }>();
  const { rows } = index;
  for (let i = 0; i < index.count; i += 1) {
    const status = index.text(rows.status[i]);
    if (status === 'ok') continue;
    const method = index.text(rows.method[i]), reason = index.text(rows.reason[i]), engine = engineOf(method);
    const key = [status, engine, reason.replace(/[\d.e+-]+/g, '#')].join('\n');
    const found = cells.get(key) ?? { status, engine, reason, cells: new Set() };
    found.cells.add(`${rows.scenario[i]} ${rows.method[i]} ${rows.steps[i]}`);
    cells.set(key, found);
  }
  if (!cells.size) return null;
  const groups = [...cells.values()].sort((a, b) => b.cells.size - a.cells.size);
  const counts = new Map<string, number>();
  for (const g of groups) counts.set(g.status, (counts.get(g.status) ?? 0) + g.cells.size);
  const cut = (text: string) => (text.length > 110 ? `${text.slice(0, 108)}\u2026` : text);
  return h('p', {}, h('b', {}, 'Without a figure'), `: ${list([...counts].map(([status, n]) => `${n} ${n === 1 ? 'cell' : 'cells'} ${status}`))}. `,
    ...groups.slice(0, 2).map((g, i) => `${i ? 'Then' : 'Most'}: ${g.engine}, ${g.cells.size} ${g.status}: ${cut(g.reason).replace(/\.$/, '')}. `), h('a', { href: '#cells' }, 'All, with reasons'), '.');
}

export function story(report: Report, index: RowIndex): HTMLElement | null {
  const ids = index.names('scenario').filter((id) => !isSweep(index, id));
  if (!ids.length) return null;
  const telling = tellingScenes(report, index, ids);
  const sentences = () => {
    const told = cheapest(report, index, telling);
    return told.length ? told : cheapest(report, index, [...new Set(report.dominance.map((t) => t.scenario))].slice(0, 2));
  };
  const best = sentences();
  const engines = [...new Set(index.names('method').map(engineOf))];
  const bad = report.verdicts.filter((v) => v.judgement !== 'pass');
  const judged = bad.length ? h('p', {}, h('b', {}, 'Not passed'), ': ', ...[...new Set(bad.map((v) => v.scenario))].slice(0, 4).flatMap((id, i): Child[] => [i ? ', ' : '', toScene(id, id)]), '. ', h('a', { href: '#failing' }, 'Each with its bound and command'), '.') : null;
  const changed = report.changes ? h('p', {}, h('b', {}, 'What changed'),
    ` against ${report.changes_against}: ${changeCounts(report)}.`,
    ...(report.changes.length ? [' ', h('a', { href: '#changes' }, 'Each figure before and now'), '.'] : [])) : report.first_run ? h('p', {}, h('b', {}, 'What changed'), ': nothing yet, this is the first run of these cells.') : null;
  const one = ids.length === 1 ? ` on ${inSentence(titleOf(report, ids[0]))}` : ` on ${ids.length} scenes`;
  const table = losses(report, index, telling);
  const counts = h('p', { class: 'soft' }, `${index.names('method').length} methods of ${engines.length === 1 ? '1 engine' : `${engines.length} engines`}${one}.`);
  // On a narrow screen the first sentence, without what other engines reach, is enough to begin with: the plot stands
  // below it, and all is unfolded.
  const wide = matchMedia('(min-width: 701px)').matches;
  const ends = [float(report, index, ids), missing(index)], beside = wide && best.length > 0 && table !== null;
  const rest = [best.length && !wide ? h('ul', { class: 'sentences' }, ...best) : null, wide ? null : tally(report), wide ? null : table, ...(beside ? [] : ends)].filter((part) => part);
  const lead = best.length ? h('div', {}, h('h3', {}, 'Which to use'), h('ul', { class: wide ? 'sentences' : 'sentences short-form' }, ...(wide ? best : sentences().slice(0, 1))), wide ? tally(report) : null, ...(beside ? ends : [])) : null;
  return section('story', 'What the figures say', judged, changed, counts, h('div', { class: lead && table ? 'twin' : undefined }, lead, wide ? table : null),
    ...(wide || !rest.length ? rest : [h('details', {}, h('summary', {}, 'More scenes, what each engine loses, what float costs, what is missing'), ...rest)]));
}
