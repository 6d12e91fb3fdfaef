// One scenario at one step count: every method that ran it, one column per figure, errors and costs.
import { Report, absence, figure, real, unitWord, withBar } from './data';
import { Child, h, labelledSelect, option, section } from './dom';
import { Cell, RowIndex, richest } from './rows';
import { linkSelects } from './state';
import { Column, brokenId, redrawOnPaper, wideTable } from './table';

const ends = ['error-position-end', 'error-velocity-end', 'error-attitude-end', 'error-body-rate-end', 'energy-max', 'angular-momentum-error', 'landing-range-error'];
const contacts = ['impact-time-error', 'impact-place-error', 'impact-normal-impulse-error', 'impact-tangential-impulse-error', 'impact-count-error',
  'transition-time-error', 'restitution-error', 'apex-error', 'penetration-max', 'penetration-relative', 'cone-violation', 'signorini-gap', 'signorini-pull',
  'dissipation-defect', 'contact-energy-gain'];
// Where bodies are at rest at the end, errors at the end do not distinguish methods: contacts and the largest error over the
// run come first.
const foremost = ['error-position-max', 'impact-time-error', 'apex-error', 'restitution-error', 'penetration-max'];
const costs = ['rate-evaluations', 'step-time'];
function order(hasContacts: boolean): string[] {
  return hasContacts ? [...foremost, ...contacts.filter((name) => !foremost.includes(name)), ...ends, ...costs] : [...ends, ...contacts, ...costs];
}

interface Line { method: string; cells: (Cell | undefined)[] }

export function sideBySide(report: Report, index: RowIndex): HTMLElement | null {
  const ladders = (id: string) => order(index.hasContacts(id)).map((name) => [name, index.ladders(id, name, '')] as const).filter(([, found]) => found.size);
  const ids = index.names('scenario').filter((id) => ladders(id).length);
  if (!ids.length) return null;
  const first = richest(index, ids);
  const place = h('div');

  // A run that takes too long is timed on the coarsest rung only, which gives the time of a step.
  const missing = (name: string, found: Map<string, Cell[]>, method: string, wanted: number): Child =>
    (name === 'step-time' && found.get(method)?.some((c) => c.steps < wanted) ? h('span', { class: 'soft', title: `timed at ${found.get(method)![0].steps} steps; a run at ${wanted} takes too long to repeat` }, 'not timed: slow') : '\u2013');
  const shown = (cell: Cell): Child => {
    if (!Number.isNaN(cell.value)) return withBarShort(cell);
    const reason = index.text(index.rows.reason[cell.row]);
    return reason ? h('span', { class: 'soft', title: reason }, `\u2013 ${absence(reason)}`) : '\u2013';
  };
  const draw = (onPaper: boolean) => {
    const id = scenario.select.value, wanted = Number(steps.select.value);
    const columns = ladders(id);
    const lines: Line[] = index.names('method', index.of(id)).map((method) => ({ method, cells: columns.map(([, found]) => found.get(method)?.find((c) => c.steps === wanted)) }))
      .filter((line) => line.cells.some(Boolean));
    const unit = (cell: Cell | undefined) => (cell ? unitWord(index.text(index.rows.unit[cell.row])) : '');
    const table = columns.map(([name, found], k): Column<Line> => {
      const words = unit(lines.map((line) => line.cells[k]).find(Boolean));
      return { name: words ? `${name} [${words.replace(/ /g, '\u00a0')}]` : name, number: true, value: (line) => line.cells[k]?.value ?? NaN,
        cell: (line) => (line.cells[k] ? shown(line.cells[k]!) : missing(name, found, line.method, wanted)) };
    }).filter((_, k) => lines.some((line) => line.cells[k]));
    const timed = new Map(report.bench.filter((b) => b.scenario === id && b.steps === wanted).map((b) => [b.method, real(b.ns_per_step_median)]));
    if (timed.size) {
      table.push({ name: 'benchmark [ns/step]', number: true, value: (line) => timed.get(line.method) ?? NaN,
        cell: (line) => (timed.has(line.method) ? figure(timed.get(line.method)!, 3) : '\u2013') });
    }
    const method: Column<Line> = { name: 'method', value: (line) => line.method, cell: (line) => h('span', {}, ...brokenId(line.method)) };
    place.replaceChildren(onPaper ? h('h3', {}, `${id}, ${wanted} steps`) : '', wideTable([method], table, lines, `Methods on ${id} side by side`, onPaper));
  };
  const choose = () => {
    const id = scenario.select.value;
    const found = new Map<number, Set<string>>();
    for (const [, methods] of ladders(id)) for (const [method, cells] of methods) for (const cell of cells) if (cell.steps) found.set(cell.steps, (found.get(cell.steps) ?? new Set()).add(method));
    const t_end = real(report.scenarios.find((s) => s.id === id)?.t_end_s ?? 1);
    const sorted = [...found.keys()].sort((a, b) => a - b);
    const most = Math.max(0, ...[...found.values()].map((methods) => methods.size));
    const shared = sorted.filter((n) => found.get(n)!.size * 2 > most);
    const away = (n: number) => Math.abs(Math.log(n / (60 * t_end)));
    const best = index.hasContacts(id) ? shared[shared.length - 1] : shared.reduce((a, b) => (away(b) < away(a) ? b : a), shared[0]);
    steps.select.replaceChildren(...sorted.map((n) => option(String(n), `${n} (h = ${figure(t_end / n, 3)} s)`, n === best)));
    draw(false);
  };
  const scenario = labelledSelect('scenario', 'compare-scenario', choose);
  const steps = labelledSelect('steps', 'compare-steps', () => draw(false));
  scenario.select.append(...ids.map((id) => option(id, id, id === first)));
  choose();
  linkSelects(scenario.select, steps.select);
  redrawOnPaper(draw);
  return section('compare', 'Side by side', h('p', { class: 'hint' }, 'All methods on one scenario at the same steps; click a heading to sort. Adaptive methods (a tolerance after the colon) choose their steps: the count only sets their first step. For scenes with contacts the finest steps that most methods have are shown first. \u2013 no figure; where the engine reported too little for one, what is missing.'),
    h('div', { class: 'bar' }, scenario.box, steps.box), place);
}

function withBarShort(cell: Cell): string {
  return cell.bar > 0 && Math.abs(cell.value) < 3 * cell.bar ? withBar(Math.abs(cell.value), cell.bar) : figure(cell.value, 3);
}
