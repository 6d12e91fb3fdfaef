// Contacts against exact geometry: seeded poses of every pair of shapes, a line a pair, a column an engine.
import { figure, real, unitWord } from './data';
import { h, labelledSelect, option, section } from './dom';
import { RowIndex } from './rows';
import { Column, smallTable } from './table';

const counts = /-(misses|false-hits)$/;

export function sweep(index: RowIndex): HTMLElement | null {
  const { rows } = index;
  const ids = index.names('scenario').filter((id) => index.names('metric', index.of(id)).some((name) => counts.test(name)));
  if (!ids.length) return null;
  const id = ids[0], mine = index.of(id);
  const figures = index.names('metric', mine).filter((name) => /^(contact|touch)-/.test(name));
  const place = h('div');

  const draw = () => {
    const steps = Number(poses.select.value), metric = chosen.select.value;
    const found = new Map<string, Map<string, { value: number; unit: string }>>();
    for (const i of mine) {
      if (rows.steps[i] !== steps || index.text(rows.metric[i]) !== metric || index.text(rows.status[i]) !== 'ok') continue;
      const pair = index.text(rows.body[i]);
      found.set(pair, (found.get(pair) ?? new Map()).set(index.text(rows.method[i]), { value: real(rows.value[i]), unit: index.text(rows.unit[i]) }));
    }
    const whole = found.get('');
    const pairs = [...found.keys()].filter((pair) => pair).sort();
    const methods = index.names('method', mine).filter((method) => [...found.values()].some((line) => line.has(method)));
    const unit = unitWord([...found.values()].flatMap((line) => [...line.values()])[0]?.unit ?? '');
    const asked = (pair: string, method: string) => found.get(pair)?.get(method);
    const words = (value: number) => (counts.test(metric) ? String(value) : figure(value, 2));
    const engines: Column<string>[] = methods.map((method) => ({ name: method, number: true, value: (pair) => asked(pair, method)?.value ?? NaN,
      cell: (pair) => { const one = asked(pair, method); return one ? h('span', { class: counts.test(metric) && one.value > 0 ? 'short' : undefined }, words(one.value)) : '\u2013'; } }));
    place.replaceChildren(smallTable<string>([{ name: unit ? `${metric} [${unit}]` : metric, value: (pair) => pair || '\u0000', cell: (pair) => pair || h('b', {}, 'all pairs') }, ...engines],
      whole ? ['', ...pairs] : pairs, `${metric} by pair of shapes and engine`));
  };
  const chosen = labelledSelect('figure', 'sweep-figure', draw);
  chosen.select.append(...figures.map((name) => option(name, name)));
  const poses = labelledSelect('poses a pair', 'sweep-poses', draw);
  const ladder = [...new Set(mine.map((i) => rows.steps[i]))].filter((n) => n > 0).sort((a, b) => b - a);
  poses.select.append(...ladder.map((n) => option(String(n), String(n))));
  draw();
  return section('sweep', 'Contacts against exact geometry', h('p', { class: 'hint' },
    'Misses: bodies overlap and the engine finds no contact; false hits: the other way round. \u2013 the engine does not answer for that pair. Each figure is defined under Metrics; the worst poses are kept as scenes beside the report, in poses/.'),
    h('div', { class: 'bar' }, chosen.box, poses.box), place);
}
