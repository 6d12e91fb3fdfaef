// The metric that a scene is about, and the figures of its methods near a given rate of steps.
import { Report, engineOf, isAdaptive, real } from './data';
import { Cell, RowIndex } from './rows';

// What the scene's file names, where it was measured. Else impacts where most methods report them; else the metric of the
// ranking, in which methods differ most; else the first error.
export function sceneMetric(report: Report, index: RowIndex, id: string): string {
  const names = index.names('metric', index.of(id)), named = report.scenarios.find((s) => s.id === id)?.metric;
  if (named && names.includes(named) && index.ladders(id, named, '').size) return named;
  const count = (name: string) => [...index.ladders(id, name, '').values()].filter((cells) => cells.some((c) => Number.isFinite(c.value))).length;
  const ranked = report.dominance.find((t) => t.scenario === id)?.metric;
  const basic = ranked ?? ['error-attitude-max', 'error-position-max', 'error-position-end'].find((name) => names.includes(name)) ?? names.find((name) => /^error-/.test(name)) ?? names.find((name) => /error/.test(name)) ?? names.find((name) => name !== 'status') ?? '';
  const telling = (name: string) => {  // places of impact that no method can miss tell nothing
    const cells = [...index.ladders(id, name, '').values()].flat().filter((c) => Number.isFinite(c.value));
    return cells.filter((c) => Math.abs(c.value) > 3 * c.bar && c.value !== 0).length * 2 >= cells.length;
  };
  const impact = ['impact-place-error', 'impact-time-error'].find((name) => names.includes(name) && telling(name) && count(name) >= 2 && count(name) * 2 >= count(basic));
  return impact ?? basic;
}

// Whether the metric compares with something that moves: an error of 0 where nothing moves tells nothing.
export function moves(index: RowIndex, id: string, metric: string): boolean {
  const of = /attitude|body-rate/.test(metric) ? 'size-body-rate' : /position/.test(metric) ? 'size-position' : /velocity/.test(metric) ? 'size-velocity' : '';
  if (!of) return true;
  const sizes = [...index.ladders(id, of, '').values()].flat();
  return !sizes.length || sizes.some((cell) => cell.value > 0);
}

export function secondsOf(report: Report, id: string): number { return real(report.scenarios.find((s) => s.id === id)?.t_end_s) || 1; }

// The rung nearest to a number of steps per second; of an adaptive method its only one.
export function nearRate(cells: Cell[] | undefined, hertz: number, t_end: number): Cell | undefined {
  const away = (cell: Cell) => Math.abs(Math.log(cell.steps / (hertz * t_end)));
  return cells?.filter((cell) => cell.steps > 0 && Number.isFinite(cell.value)).reduce<Cell | undefined>((best, cell) => (!best || away(cell) < away(best) ? cell : best), undefined);
}

export interface Figure { method: string; cell: Cell }
// The figures of an engine's methods at the rung nearest to a rate, the smallest error first. Steps that a method
// chooses itself are no rung: adaptive methods are left out unless the engine has no others.
export function figuresOf(ladders: Map<string, Cell[]>, engine: string, hertz: number, t_end: number): Figure[] {
  const all = [...ladders].filter(([method]) => engineOf(method) === engine && !/@(long-double|quad)/.test(method));
  const fixed = all.filter(([method]) => !isAdaptive(method));
  const found = (fixed.length ? fixed : all).map(([method, cells]) => ({ method, cell: nearRate(cells, hertz, t_end) }));
  return (found.filter((f) => f.cell) as Figure[]).sort((a, b) => Math.abs(a.cell.value) - Math.abs(b.cell.value));
}

// Titles of scenes as parts of a sentence.
export function titleOf(report: Report, id: string): string { return report.scenarios.find((s) => s.id === id)?.title || id; }
export function inSentence(title: string): string { return title.replace(/^[A-Z](?=[a-z ])/, (c) => c.toLowerCase()); }

// One scene for each kind of motion: attitude, contact, position; of each the one that most engines and methods ran.
export function tellingScenes(report: Report, index: RowIndex, ids: string[]): string[] {
  const kinds = new Map<string, { id: string; rank: number }>();
  for (const id of ids) {
    const metric = sceneMetric(report, index, id);
    if (!metric || !moves(index, id, metric)) continue;
    const methods = index.names('method', index.of(id));
    const kind = index.hasContacts(id) ? 'contact' : /attitude|body-rate/.test(metric) ? 'attitude' : 'position';
    const rank = new Set(methods.map(engineOf)).size * 1000 + methods.length;
    if (rank > (kinds.get(kind)?.rank ?? 0)) kinds.set(kind, { id, rank });
  }
  return ['attitude', 'contact', 'position'].map((kind) => kinds.get(kind)?.id).filter((id): id is string => !!id);
}
