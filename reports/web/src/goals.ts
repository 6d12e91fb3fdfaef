// The project's goals: the requirement, our best method, the best rival, and whether the goal is reached.
import { Goal, GoalEntrant, Report, figure, real, rungWords, seconds, unitWord, withBar, family } from './data';
import { Child, h, section } from './dom';

function asked(goal: Goal): string {
  const error = real(goal.wanted_error), budget = real(goal.budget);
  const words = goal.low != null ? `${goal.metric} from ${figure(real(goal.low), 4)} to ${figure(real(goal.high), 4)}`
    : Number.isFinite(error) ? `${goal.metric} ${figure(error, 2)} ${unitWord(goal.unit)}`.trim() : '';
  if (goal.wanted_ratio && !Number.isFinite(budget)) return `${words ? `${words} and ` : ''}${goal.wanted_ratio} times as fast as the best rival`;
  const kind: Record<string, string> = { seconds: seconds(budget), evaluations: `${budget} evaluations`, ns_per_step: `${figure(budget, 4)} ns per step`, ns: `${figure(budget, 4)} ns` };
  const limit = kind[goal.budget_kind] ?? '';
  return words && limit ? `${words} ${goal.budget_kind === 'ns_per_step' ? 'at' : 'in'} ${limit}` : words || limit;
}

function figures(entrant: GoalEntrant | null, unit: string): Child {
  if (!entrant) return h('span', { class: 'soft' }, 'no method');
  const parts: string[] = [];
  const error = real(entrant.error), evaluations = real(entrant.evaluations), time = real(entrant.seconds), step = real(entrant.ns_per_step);
  const bar = real(entrant.bar);
  if (Number.isFinite(error)) parts.push(`error ${bar > 0 && error < 3 * bar ? withBar(error, bar) : figure(error, 3)} ${unitWord(unit)}`.trim());
  const quarter = real(entrant.last_quarter);
  if (!Number.isNaN(quarter)) parts.push(`${Number.isFinite(quarter) ? figure(quarter, 2) : 'not finite'} over the last quarter`);
  if (Number.isFinite(evaluations)) parts.push(`${evaluations} evaluations`);
  if (Number.isFinite(time)) parts.push(seconds(time));
  if (Number.isFinite(step)) parts.push(`${figure(step, 4)} ns${entrant.steps ? ' per step' : ''}`);
  const at = entrant.steps ? `, ${rungWords(entrant.method, entrant.steps)}` : '';
  return h('span', {}, h('b', {}, family(entrant.method)), at, h('br'), parts.join(', '), entrant.accurate ? null : h('em', { class: 'short' }, ' not accurate enough'));
}

// The best of a side, then those of it that reach the error at up to 1.2 times its cost.
function side(best: GoalEntrant | null, goal: Goal, ours: boolean): Child {
  const engine = (entrant: GoalEntrant) => entrant.method.split('/')[0];
  const near = (goal.close ?? []).filter((entrant) => (goal.ours !== null && engine(entrant) === engine(goal.ours)) === ours);
  return h('span', {}, figures(best, goal.unit), near.length ? h('span', { class: 'soft' }, h('br'), `within 20 %: ${near.map((e) => `${e.method}${e.steps ? `, ${rungWords(e.method, e.steps)}` : ''}`).join('; ')}`) : null);
}

// The error that rounding the initial state to double makes alone: no method in double is reliably more accurate.
function floorWords(goal: Goal): Child {
  const floor = real(goal.ours?.floor);
  if (!Number.isFinite(floor)) return null;
  return h('span', { class: 'soft' }, h('br'), `floor: error ${figure(floor, 2)} ${unitWord(goal.unit)}`.trim() + ' by rounding the initial state alone (condition \u00d7 unit round-off)');
}

function machineWords(goal: Goal): Child {
  const machine = goal.machine;
  if (!machine) return null;
  const words = `${machine.interrupted} of ${machine.timings} timings interrupted, ${figure(real(machine.ghz_low), 3)} to ${figure(real(machine.ghz_high), 3)} GHz${machine.again ? `, the calmest of ${machine.again + 1}` : ''}`;
  return h('span', { class: machine.busy ? 'short' : 'soft' }, h('br'), machine.busy ? `${words}: a busy machine, times may be too long` : words);
}

function leftOutWords(goal: Goal): Child {
  if (!goal.left_out?.length) return null;
  return h('span', { class: 'soft' }, h('br'), `left out: ${goal.left_out.length} finer rungs whose coarser ones need more than 10 times the evaluations of their engine\u2019s cheapest that reaches the error`);
}

export function goals(report: Report): HTMLElement | null {
  if (!report.goals.length) return null;
  const reached = report.goals.filter((g) => g.reached).length;
  const line = (goal: Goal) => {
    const ratio = real(goal.ratio), low = real(goal.ratio_low), high = real(goal.ratio_high);
    const interval = low < high ? ` [${figure(low, 3)}, ${figure(high, 3)}]` : '';
    return h('tr', {}, h('td', {}, h('span', { class: `badge ${goal.reached ? 'pass' : 'fail'}` }, goal.reached ? '\u2713 reached' : '\u2717 not reached')),
      h('td', { class: 'wide' }, goal.title, h('br'), h('span', { class: 'soft' }, asked(goal)), goal.why ? h('span', { class: 'short' }, h('br'), goal.why) : null, machineWords(goal)),
      h('td', { class: 'wide' }, side(goal.ours, goal, true), floorWords(goal)), h('td', { class: 'wide' }, side(goal.rival, goal, false), leftOutWords(goal)),
      h('td', { class: ratio < 1 ? 'number short' : 'number' }, Number.isFinite(ratio) ? `${figure(ratio, 3)}${interval}` : '\u2013'));
  };
  const uncounted = report.goals.filter((g) => g.uncounted);
  return section('goals', `Goals: ${reached} of ${report.goals.length} reached`,
    h('p', { class: 'hint' }, 'Measured by atwood bench goals, all candidates in one run, timed alternately. Shown is the cheapest method that reaches the error, or else the most accurate one. The ratio is the best rival\u2019s cost divided by ours with its 95 % interval, where both reach the error.'),
    h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Goals' }, h('table', { class: 'goals' },
      h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, ''), h('th', { scope: 'col' }, 'goal'), h('th', { scope: 'col' }, 'ours'), h('th', { scope: 'col' }, 'best rival'), h('th', { scope: 'col', class: 'number' }, 'rival / ours'))),
      h('tbody', {}, ...report.goals.map(line)))),
    uncounted.length ? h('p', { class: 'hint' }, `Compared, but not counted for a goal (exact flows of the free top): ${uncounted.map((g) => `${g.id}: ${g.uncounted!.method}, error ${figure(real(g.uncounted!.error), 2)}, ${seconds(real(g.uncounted!.seconds))}`).join('; ')}.`) : null);
}
