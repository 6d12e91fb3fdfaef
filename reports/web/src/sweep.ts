// Contacts compared with exact geometry: seeded poses of every pair of shapes, one line per pair, one column per engine.
import { figure, real, unitWord } from './data';
import { Child, h, labelledSelect, option, section } from './dom';
import { RowIndex } from './rows';
import { linkSelects } from './state';
import { Column, redrawOnPaper, wideTable } from './table';

const counts = /-(misses|false-hits)$/;
export function isSweep(index: RowIndex, scenario: string): boolean { return index.names('metric', index.of(scenario)).some((name) => counts.test(name)); }

export function sweep(index: RowIndex): HTMLElement | null {
  const { rows } = index;
  const ids = index.names('scenario').filter((id) => isSweep(index, id));
  if (!ids.length) return null;
  const place = h('div');
  let mine: number[] = [];

  const draw = (onPaper: boolean) => {
    const steps = Number(poses.select.value), metric = chosen.select.value;
    interface Figure { value: number; unit: string; reason: string }
    const found = new Map<string, Map<string, Figure>>();
    for (const i of mine) {
      if (rows.steps[i] !== steps || index.text(rows.metric[i]) !== metric || index.text(rows.status[i]) !== 'ok') continue;
      const pair = index.text(rows.body[i]);
      found.set(pair, (found.get(pair) ?? new Map<string, Figure>()).set(index.text(rows.method[i]), { value: real(rows.value[i]), unit: index.text(rows.unit[i]), reason: index.text(rows.reason[i]) }));
    }
    const whole = found.get('');
    const pairs = [...found.keys()].filter((pair) => pair).sort();
    const methods = index.names('method', mine).filter((method) => [...found.values()].some((line) => line.has(method)));
    const unit = unitWord([...found.values()].flatMap((line) => [...line.values()])[0]?.unit ?? '');
    const asked = (pair: string, method: string) => found.get(pair)?.get(method);
    const words = (value: number) => (counts.test(metric) ? String(value) : figure(value, 2));
    // Sums over different numbers of pairs are not comparable: each shows its number.
    const answered = (method: string) => pairs.filter((pair) => asked(pair, method)).length;
    const cell = (pair: string, method: string): Child => {
      const one = asked(pair, method);
      if (!one) return '\u2013';
      return h('span', { class: counts.test(metric) && one.value > 0 ? 'short' : undefined, title: one.reason }, words(one.value), pair ? null : h('span', { class: 'soft' }, ` of ${answered(method)} ${answered(method) === 1 ? 'pair' : 'pairs'}`));
    };
    const engines: Column<string>[] = methods.map((method) => ({ name: method, number: true, value: (pair) => asked(pair, method)?.value ?? NaN, cell: (pair) => cell(pair, method) }));
    // "of 15 poses": in tables of cases the number differs by pair, in sweeps it is the same.
    const posesOf = (pair: string) => [...(found.get(pair)?.values() ?? [])].map((one) => /^of (\d+) poses/.exec(one.reason)?.[1]).find(Boolean);
    const sizes: Column<string>[] = pairs.some((pair) => posesOf(pair)) ? [{ name: 'poses', number: true, value: (pair) => Number(posesOf(pair) ?? NaN), cell: (pair) => (pair ? posesOf(pair) ?? '\u2013' : '') }] : [];
    place.replaceChildren(wideTable<string>([{ name: unit ? `${metric} [${unit}]` : metric, value: (pair) => pair || '\u0000', cell: (pair) => pair || h('b', {}, 'all pairs answered') }, ...sizes], engines,
      whole ? ['', ...pairs] : pairs, `${metric} by pair of shapes and engine`, onPaper));
  };
  const choose = () => {
    const before = chosen.select.value;
    mine = index.of(scenario.select.value);
    chosen.select.replaceChildren(...index.names('metric', mine).filter((name) => /^(contact|touch)-/.test(name)).map((name) => option(name, name, name === before)));
    const ladder = [...new Set(mine.map((i) => rows.steps[i]))].filter((n) => n > 0).sort((a, b) => b - a);
    poses.select.replaceChildren(...ladder.map((n) => option(String(n), String(n))));
    poses.box.hidden = ladder.length < 2;
    draw(false);
  };
  const chosen = labelledSelect('figure', 'sweep-figure', () => draw(false));
  const poses = labelledSelect('poses a pair', 'sweep-poses', () => draw(false));
  const scenario = labelledSelect('scenario', 'sweep-scenario', choose);
  scenario.select.append(...ids.map((id) => option(id, id)));
  scenario.box.hidden = ids.length < 2;
  choose();
  linkSelects(scenario.select, chosen.select, poses.select);
  redrawOnPaper(draw);
  const seeded = ids.some((id) => index.of(id).some((i) => rows.steps[i] > 1));
  return section('sweep', 'Contacts against exact geometry', h('p', { class: 'hint' },
    'Misses: bodies overlap and the engine finds no contact; false hits: bodies are apart and it finds one. \u2013 the engine does not answer for that pair, which its sums leave out. Each figure is defined under Metrics.', seeded ? ' The worst poses of each pair are kept as scene files beside the report.' : ''),
    h('div', { class: 'bar' }, scenario.box, chosen.box, poses.box), place);
}
