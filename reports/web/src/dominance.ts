// The cheapest method for an error, the most accurate one within a budget, and the step from which a method is stable.
import { Contest, Dominance, Reached, Report, engineOf, figure, inBrackets, placeWords, real, rungWords, seconds, unitWord } from './data';
import { Child, h, labelledSelect, option, section } from './dom';
import { choose, linkSelects } from './state';
import { brokenId } from './table';

const isOurs = (reached: Reached) => engineOf(reached.family) === 'atwood';
const mark = (reached: Reached) => `${reached.coarsest ? ' <' : ''}${reached.at_bar ? ' *' : ''}`;
const costWords = (table: Dominance, cost: number) => (table.cost === 'seconds' ? seconds(cost) : String(Math.round(cost)));
const level = (value: number) => value.toExponential(0);
const norm = (metric: string) => metric.replace(/^error-/, '').replace(/-max$/, ', largest over the run').replace(/-end$/, ', at the end');
const otherEngine = (contest: Contest) => contest.ranked.find((r) => engineOf(r.family) !== engineOf(contest.ranked[0].family));

function name(reached: Reached): Child {
  return h('span', { class: isOurs(reached) ? 'ours' : 'theirs' }, reached.family);
}

function scrolled(label: string, heads: string[], lines: Child[][], words: number[]): HTMLElement {
  const cls = (i: number) => (words.includes(i) ? undefined : 'number');
  return h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': label }, h('table', {},
    h('thead', {}, h('tr', {}, ...heads.map((head, i) => h('th', { scope: 'col', class: cls(i) }, head)))),
    h('tbody', {}, ...lines.map((line) => h('tr', {}, ...line.map((child, i) => h('td', { class: cls(i) }, child)))))));
}

function ratioWords(contest: Contest, other: Reached | undefined): string {
  if (!other) return '\u2013';
  const best = contest.ranked[0];
  const timed = contest.to_next && other === contest.ranked[1] ? contest.to_next : null;
  return timed ? `${figure(real(timed.value), 3)} [${figure(real(timed.low), 3)}, ${figure(real(timed.high), 3)}]` : figure(real(other.cost) / real(best.cost), 3);
}

function byError(table: Dominance): HTMLElement | null {
  if (!table.by_error.length) return null;
  const what = table.cost === 'seconds' ? 'time of the run' : 'evaluations';
  const behind = (contest: Contest, other: Reached | undefined, none: string): Child => (other ? h('span', {}, name(other), h('span', { class: 'behind' }, `\u00d7 ${ratioWords(contest, other)}`)) : none);
  return scrolled('Cheapest for an error', [`error${inBrackets(table.unit)}`, 'cheapest', 'at', what, 'runner-up and its cost', 'best other engine and its cost'],
    table.by_error.map((contest) => {
      const best = contest.ranked[0];
      return [level(real(contest.asked)), name(best), placeWords(best), costWords(table, real(best.cost)) + mark(best),
        behind(contest, contest.ranked[1], 'alone'), behind(contest, otherEngine(contest), '\u2013')];
    }), [1, 2, 4, 5]);
}

function byBudget(table: Dominance): HTMLElement | null {
  if (!table.by_budget.length) return null;
  const error = (reached: Reached | undefined) => (reached ? figure(real(reached.error), 2) + mark(reached) : '\u2013');
  return scrolled('Most accurate within a budget', ['budget', 'most accurate', 'at', `error${inBrackets(table.unit)}`, 'runner-up', 'error', 'best other engine', 'error'],
    table.by_budget.map((contest) => {
      const best = contest.ranked[0], next = contest.ranked[1], other = otherEngine(contest);
      return [costWords(table, real(contest.asked)), name(best), placeWords(best), error(best), next ? name(next) : 'alone', error(next), other ? name(other) : '\u2013', error(other)];
    }), [1, 2, 4, 6]);
}

// Fluids: the methods at one spacing and sound speed, the most accurate first.
function bySpacing(table: Dominance): HTMLElement | null {
  if (!table.by_spacing?.length) return null;
  return h('div', {}, h('h3', {}, 'At equal spacing and sound speed'),
    scrolled('At equal spacing', ['spacing [m]', 'sound speed [m/s]', 'method', 'at', `error${inBrackets(table.unit)}`, 'time of the run'],
      table.by_spacing.flatMap((place) => place.ranked.map((reached, i): Child[] => [i ? '' : figure(real(place.spacing_m), 4), i ? '' : figure(real(place.sound_speed_m_per_s), 4),
        name(reached), rungWords(reached.method, reached.steps), figure(real(reached.error), 2) + (reached.at_bar ? ' *' : ''), seconds(real(reached.cost))])), [2, 3]));
}

function stable(table: Dominance, t_end: number): HTMLElement | null {
  const failed = (range: Dominance['stable'][number]) => {
    const kinds = new Map<string, string[]>();
    for (const rung of range.failed) {
      const key = `${rung.status}: ${rung.reason}`;
      kinds.set(key, [...(kinds.get(key) ?? []), rungWords(rung.method, rung.steps)]);
    }
    return [...kinds].map(([why, rungs]) => `${rungs.length > 2 ? `${rungs[0]} \u2026 ${rungs[rungs.length - 1]}` : rungs.join(', ')}: ${why}`).join('; ');
  };
  if (!table.stable.length) return null;
  return h('details', {}, h('summary', {}, `Stable from: ${table.stable.length} methods`),
    h('p', { class: 'hint' }, 'The coarsest rung such that neither it nor a finer one diverges. An error as large as the motion itself counts as a failure.'),
    scrolled('Stable steps', ['method', 'stable from', 'h [s]', 'error there', 'rungs without an error'], table.stable.map((range) => [
      range.family, range.stable ? rungWords(range.method!, range.steps!) : 'nowhere on this ladder', range.stable && real(range.h_s) > 0 ? figure(t_end / range.steps!, 3) : '\u2013',
      range.stable ? figure(real(range.error), 2) : '\u2013', h('span', { class: 'long' }, failed(range))]), [0, 1, 4]));
}

// All scenarios: the cheapest method for each error; a click shows the scenario's tables.
function overview(tables: Dominance[], chosen: (table: Dominance) => void): HTMLElement {
  const levels = [...new Set(tables.flatMap((t) => t.by_error.map((c) => real(c.asked))))].sort((a, b) => b - a);
  const short = (family: string) => (family.startsWith('atwood/') ? family.slice(7) : family).replace(':tol', '');
  return h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Cheapest, scenario by error' }, h('table', { class: 'winners' },
    h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'scenario'), ...levels.map((v) => h('th', { scope: 'col' }, level(v))))),
    h('tbody', {}, ...tables.map((table) => h('tr', {}, h('th', { scope: 'row' }, h('button', { type: 'button', onclick: () => chosen(table) }, table.scenario)),
      ...levels.map((value) => {
        const contest = table.by_error.find((c) => real(c.asked) === value);
        if (!contest) return h('td', { class: 'absent', title: 'no method reaches this error' }, '\u00b7');
        const best = contest.ranked[0], other = otherEngine(contest);
        const apart = other ? real(other.cost) / real(best.cost) : NaN;
        return h('td', { class: isOurs(best) ? 'ours' : 'theirs', title: `${table.scenario}, ${`${level(value)} ${unitWord(table.unit)}`.trim()}: ${best.family}, ${costWords(table, real(best.cost))}${mark(best)}; ${other ? `best other engine ${other.family} \u00d7 ${figure(apart, 3)}` : 'no other engine reaches it'}` },
          h('b', {}, ...brokenId(short(best.family))), h('span', {}, other ? `\u00d7 ${figure(apart, 2)}` : 'alone'));
      }))))));
}

export function dominance(report: Report): HTMLElement | null {
  if (!report.dominance.length) return report.notes.length ? section('dominance', 'Cheapest method for an error', ...report.notes.map((note) => h('p', { class: 'hint' }, note))) : null;
  const kinds = [...new Set(report.dominance.map((t) => t.cost))];
  const t_end = new Map(report.scenarios.map((s) => [s.id, real(s.t_end_s)]));
  const place = h('div', { class: 'contest' }), table = h('div');
  const of = () => report.dominance.filter((t) => t.cost === cost.select.value);
  const draw = () => {
    const found = of().find((t) => t.scenario === scenario.select.value);
    place.replaceChildren(...(found ? [h('h3', {}, `${found.scenario}: ${norm(found.metric)}${inBrackets(found.unit)}`), byError(found), h('h3', {}, 'Most accurate within a budget'), byBudget(found), bySpacing(found), found.by_spacing?.length ? null : stable(found, t_end.get(found.scenario) ?? 1)].filter(Boolean) as HTMLElement[]
      : [h('p', { class: 'nothing' }, 'No such cost was measured on this scenario.')]));
  };
  const fill = () => {
    const tables = of(), before = scenario.select.value;
    scenario.select.replaceChildren(...tables.map((t) => option(t.scenario, t.scenario, t.scenario === before)));
    table.replaceChildren(...(tables.length > 1 ? [overview(tables, (t) => { choose(scenario.select, t.scenario); place.scrollIntoView({ block: 'nearest' }); })] : []));
    scenario.box.hidden = tables.length < 2;
    draw();
  };
  const cost = labelledSelect('cost', 'dominance-cost', fill);
  cost.select.append(...kinds.map((kind) => option(kind, kind === 'seconds' ? 'time of the run' : 'evaluations of the equations')));
  const scenario = labelledSelect('scenario', 'dominance-scenario', draw);
  fill();
  linkSelects(cost.select, scenario.select);
  return section('dominance', 'Cheapest method for an error',
    h('p', { class: 'hint' }, 'For each error the cheapest method that reaches it, and for each budget the most accurate one. \u00d7: cost of the best other engine divided by that of the cheapest method; alone: no other engine reaches that error. Solid: a method of Atwood is cheapest; outlined: one of another engine. All figures are of measured rungs. <: no cheaper rung was measured. *: the error is below three bars of the truth. Times come from the timed pass of this report.'),
    report.notes.length ? h('details', {}, h('summary', {}, 'How these methods were run'), ...report.notes.map((note) => h('p', { class: 'hint' }, note))) : null,
    h('div', { class: 'bar' }, cost.box, scenario.box), table, place);
}
