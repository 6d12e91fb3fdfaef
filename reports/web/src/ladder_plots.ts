// The plots of a ladder: a figure against the step, the CPU time, the evaluations; and the methods that they open with.
import { chosenMethods } from './chosen';
import { family, figure, isAdaptive, unitWord, withBar } from './data';
import { ChartSpec, Curve, Point } from './drawing';
import { Cell, RowIndex } from './rows';
import { Look } from './style';

export function openingMethods(index: RowIndex, id: string, metric: string): string[] {
  const timed = index.ladders(id, 'step-time', '').size > 0;
  const ladders = index.ladders(id, metric, '');
  const few = chosenMethods(ladders, (method) => timed || !isAdaptive(method));
  return few.length ? few : chosenMethods(ladders, () => true);
}

function secondsPer(unit: string): number {
  return unit.startsWith('us') || unit.startsWith('\u00b5s') ? 1e-6 : unit.startsWith('ms') ? 1e-3 : unit === 's' || unit.startsWith('s/') ? 1 : 1e-9;
}

type Place = (method: string, cell: Cell) => number | null;
function curves(ladders: Map<string, Cell[]>, unit: string, looks: Map<string, Look>, xOf: Place, xWords: (x: number) => string): Curve[] {
  const groups = new Map<string, { point: Point; order: number }[]>();
  for (const [method, cells] of ladders) {
    const name = family(method);
    if (!looks.has(name)) continue;
    for (const cell of cells) {
      const x = xOf(method, cell);
      if (x === null || !(x > 0) || !Number.isFinite(cell.value)) continue;
      const y = Math.abs(cell.value);
      const note = [isAdaptive(method) ? `${method}, ${cell.steps} steps` : `${cell.steps} steps`, xWords(x), `${withBar(cell.value, cell.bar)} ${unit}`];
      if (!groups.has(name)) groups.set(name, []);
      groups.get(name)!.push({ point: { x, y, note }, order: isAdaptive(method) ? -y : cell.steps });
    }
  }
  return [...groups].map(([name, entries]) => ({ name, look: looks.get(name)!, points: entries.sort((a, b) => a.order - b.order).map((entry) => entry.point) }));
}

// Of the methods that have a look. Costs are those of the same method at the same steps.
export function ladderPlots(index: RowIndex, id: string, metric: string, body: string, looks: Map<string, Look>): Record<'step' | 'time' | 'evaluations', ChartSpec> {
  const ladders = index.ladders(id, metric, body), times = index.ladders(id, 'step-time', ''), evaluations = index.ladders(id, 'rate-evaluations', '');
  const all = [...ladders.values()].flat(), timeCell = [...times.values()].flat()[0];
  const unit = all.length ? unitWord(index.text(index.rows.unit[all[0].row])) : '';
  const toSeconds = timeCell ? secondsPer(index.text(index.rows.unit[timeCell.row])) : 1e-9;
  const floor = Math.max(0, ...all.map((cell) => cell.bar).filter(Number.isFinite));
  const shared = { yLabel: `|${metric}|${unit ? ` [${unit}]` : ''}`, floor: floor || null, xLog: true, empty: 'No figures of this metric.' };
  const cost = (from: Map<string, Cell[]>): Place => (method, cell) => from.get(method)?.find((other) => other.steps === cell.steps)?.value ?? null;
  const seconds: Place = (method, cell) => {
    const each = cost(times)(method, cell);
    return each === null ? null : each * toSeconds * cell.steps;
  };
  return {
    step: { ...shared, id: 'step', title: 'Error against step', xLabel: 'step h [s]', guides: [1, 2, 4, 5],
      curves: curves(ladders, unit, looks, (method, cell) => (isAdaptive(method) ? null : cell.h), (x) => `h = ${figure(x, 4)} s`) },
    time: { ...shared, id: 'cpu', title: 'Work against precision: CPU time', xLabel: 'CPU time [s] = time of a step \u00d7 steps', guides: [-1, -2, -4, -5],
      curves: curves(ladders, unit, looks, seconds, (x) => `${figure(x, 3)} s`), empty: 'No timings of this scenario.' },
    evaluations: { ...shared, id: 'evaluations', title: 'Work against precision: evaluations', xLabel: 'rate evaluations', guides: [-1, -2, -4, -5],
      curves: curves(ladders, unit, looks, cost(evaluations), (x) => `${figure(x, 6)} evaluations`), empty: 'No evaluation counts of this scenario (rivals do not report theirs).' },
  };
}
