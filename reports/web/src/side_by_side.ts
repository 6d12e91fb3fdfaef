// One scenario at one step count: every method that ran it, a column a figure. What an engine costs beside what it errs.
import { Report, figure, real, unitWord, withBar } from './data';
import { h, labelledSelect, option, section } from './dom';
import { Cell, RowIndex, richest } from './rows';
import { Column, smallTable } from './table';

const figures = ['error-position-end', 'error-velocity-end', 'error-attitude-end', 'error-body-rate-end', 'energy-max', 'angular-momentum-error',
  'landing-range-error', 'impact-time-error', 'impact-place-error', 'impact-normal-impulse-error', 'impact-tangential-impulse-error', 'impact-count-error',
  'transition-time-error', 'restitution-error', 'apex-error', 'penetration-max', 'penetration-relative', 'cone-violation', 'signorini-gap', 'signorini-pull',
  'dissipation-defect', 'contact-energy-gain', 'rate-evaluations', 'step-time'];

export function sideBySide(report: Report, index: RowIndex): HTMLElement | null {
  const ids = index.names('scenario');
  const first = richest(index);
  const place = h('div');
  const ladders = (id: string) => figures.map((name) => [name, index.ladders(id, name, '')] as const).filter(([, found]) => found.size);

  const draw = () => {
    const id = scenario.select.value, wanted = Number(steps.select.value);
    interface Line { method: string; cells: (Cell | undefined)[] }
    const columns = ladders(id);
    const lines: Line[] = index.names('method', index.of(id)).map((method) => ({ method, cells: columns.map(([, found]) => found.get(method)?.find((c) => c.steps === wanted)) }))
      .filter((line) => line.cells.some(Boolean));
    const unit = (cell: Cell | undefined) => (cell ? unitWord(index.text(index.rows.unit[cell.row])) : '');
    const table: Column<Line>[] = columns.map(([name], k) => {
      const words = unit(lines.map((line) => line.cells[k]).find(Boolean));
      return { name: words ? `${name} [${words}]` : name, number: true, value: (line) => line.cells[k]?.value ?? NaN,
        cell: (line) => (line.cells[k] ? withBarShort(line.cells[k]!) : '\u2013') };
    });
    const timed = new Map(report.bench.filter((b) => b.scenario === id && b.steps === wanted).map((b) => [b.method, real(b.ns_per_step_median)]));
    if (timed.size) {
      table.push({ name: 'benchmark [ns/step]', number: true, value: (line) => timed.get(line.method) ?? NaN,
        cell: (line) => (timed.has(line.method) ? figure(timed.get(line.method)!, 3) : '\u2013') });
    }
    place.replaceChildren(smallTable<Line>([{ name: 'method', value: (line) => line.method }, ...table], lines, `Methods on ${id} side by side`));
  };
  const choose = () => {
    const id = scenario.select.value;
    const found = new Map<number, number>();
    for (const [, methods] of ladders(id)) for (const cells of methods.values()) for (const cell of cells) if (cell.steps) found.set(cell.steps, (found.get(cell.steps) ?? 0) + 1);
    const t_end = real(report.scenarios.find((s) => s.id === id)?.t_end_s ?? 1);
    const sorted = [...found.keys()].sort((a, b) => a - b);
    const most = Math.max(0, ...found.values());
    const shared = sorted.filter((n) => found.get(n)! * 2 > most);
    const away = (n: number) => Math.abs(Math.log(n / (60 * t_end)));
    const best = shared.reduce((a, b) => (away(b) < away(a) ? b : a), shared[0]);
    steps.select.replaceChildren(...sorted.map((n) => option(String(n), `${n} (h = ${figure(t_end / n, 3)} s)`, n === best)));
    draw();
  };
  const scenario = labelledSelect('scenario', 'compare-scenario', choose);
  const steps = labelledSelect('steps', 'compare-steps', draw);
  scenario.select.append(...ids.map((id) => option(id, id, id === first)));
  choose();
  return section('compare', 'Side by side', h('p', { class: 'hint' }, 'Every method on one scenario at the same steps; a heading sorts. Adaptive methods (a tolerance after the colon) choose their own steps: the count is their first guess.'),
    h('div', { class: 'bar' }, scenario.box, steps.box), place);
}

function withBarShort(cell: Cell): string {
  return cell.bar > 0 && Math.abs(cell.value) < 3 * cell.bar ? withBar(Math.abs(cell.value), cell.bar) : figure(cell.value, 3);
}
