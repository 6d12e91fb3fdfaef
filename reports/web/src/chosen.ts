// The curves that a plot opens with: the best of ours, the best of each other engine, and their default settings.
import { engineOf, family } from './data';
import { Cell } from './rows';

// The median of the errors' logarithms, by which families of one ladder compare.
function score(cells: Cell[]): number {
  const logs = cells.filter((c) => Number.isFinite(c.value)).map((c) => (c.value === 0 ? -40 : Math.log10(Math.abs(c.value)))).sort((a, b) => a - b);
  return logs.length ? logs[Math.floor(logs.length / 2)] : Infinity;
}

export function chosenMethods(ladders: Map<string, Cell[]>, drawn: (method: string) => boolean, most = 8): string[] {
  const families = new Map<string, Cell[]>();
  for (const [method, cells] of ladders) if (drawn(method)) families.set(family(method), [...(families.get(family(method)) ?? []), ...cells]);
  const ranked = [...families].map(([name, cells]) => ({ name, engine: engineOf(name), score: score(cells) })).filter((f) => f.score < Infinity).sort((a, b) => a.score - b.score);
  const usual = ranked.filter((f) => !/@(long-double|quad|float)/.test(f.name));
  const pool = usual.length ? usual : ranked;
  const engines = [...new Set(pool.map((f) => f.engine))];
  const twin = (engine: string) => engine.endsWith('32') && engines.includes(engine.replace(/32$/, '64'));  // one engine in two precisions
  const best = engines.filter((engine) => !twin(engine)).map((engine) => pool.find((f) => f.engine === engine)!);
  const ours = best.filter((f) => f.engine === 'atwood'), rivals = best.filter((f) => f.engine !== 'atwood');
  const defaults = rivals.map((rival) => pool.find((f) => f.engine === rival.engine && /\/default/.test(f.name) && f.score > rival.score + 0.02)).filter((f) => f !== undefined);
  const list = [...ours, ...rivals, ...defaults, ...(engines.length < 2 ? pool : [])].map((f) => f.name);
  return [...new Set(list)].slice(0, most);
}
