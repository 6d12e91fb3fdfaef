// Figures from several runs: round-off by ensembles, reversal, symplecticity, chaos, tolerances, runs without a truth. Each
// table has the definitions of its figures.
import { Report, fitted, isFit, real, unitWord, withBar } from './data';
import { h, section } from './dom';
import { RowIndex } from './rows';
import { smallTable } from './table';

const groups: [string, string[]][] = [
  ['Growth of round-off, by ensembles', ['growth-exponent-round-off-energy', 'growth-exponent-round-off-position', 'growth-exponent-round-off-attitude', 'round-off-rms-position']],
  ['Reversal', ['reversal-over-round-off', 'reversal-error-position', 'reversal-error-velocity', 'reversal-error-attitude', 'reversal-error-body-rate']],
  ['Symplecticity', ['symplecticity-defect', 'poisson-defect']],
  ['Chaos', ['lyapunov-exponent', 'horizon']],
  ['The same bits', ['state-differences', 'state-hash']],
  ['The step of least error', ['round-off-best-error', 'round-off-best-step']],
  ['Error and tolerance', ['tolerance-exponent', 'tolerance-ratio']],
  ['Without a truth: grid convergence', ['richardson-order-position', 'gci-position', 'gci-effectivity']],
];

interface Figure { scenario: string; method: string; steps: number; metric: string; unit: string; value: number; bar: number; status: string; reason: string }

function words(f: Figure): string {
  if (f.status !== 'ok') return f.status;
  if (f.metric === 'state-hash') return f.value.toString(16).padStart(12, '0');
  if (isFit(f.metric)) return `${fitted(f.metric, f.value, f.bar)} ${unitWord(f.unit)}`.trim();
  if (Number.isNaN(f.value)) return 'inconclusive';
  const value = withBar(f.value, f.bar);
  return `${value} ${unitWord(f.unit)}`.trim();
}

function table(title: string, list: Figure[]): HTMLElement {
  return smallTable<Figure>([
    { name: 'scenario', value: (f) => f.scenario }, { name: 'method', value: (f) => f.method },
    { name: 'steps', value: (f) => f.steps, number: true, cell: (f) => (f.steps ? String(f.steps) : '\u2013') },
    { name: 'metric', value: (f) => f.metric }, { name: 'figure', value: (f) => f.value, cell: words, number: true },
    { name: 'details', value: (f) => f.reason, wide: true },
  ], list, title);
}

export function statistics(report: Report, index: RowIndex): HTMLElement | null {
  const { rows } = index;
  const found = new Map<string, Figure[]>();
  for (let i = 0; i < index.count; i += 1) {
    const metric = index.text(rows.metric[i]);
    if (!groups.some(([, metrics]) => metrics.includes(metric)) || rows.t_s[i] !== null) continue;
    const list = found.get(metric) ?? [];
    list.push({ scenario: index.text(rows.scenario[i]), method: index.text(rows.method[i]), steps: rows.steps[i], metric, unit: index.text(rows.unit[i]),
      value: real(rows.value[i]), bar: real(rows.truth_bar[i]), status: index.text(rows.status[i]), reason: index.text(rows.reason[i]) });
    found.set(metric, list);
  }
  if (!found.size) return null;
  const parts = groups.map(([title, metrics]) => {
    const here = metrics.filter((metric) => found.has(metric));
    const list = here.flatMap((metric) => found.get(metric)!);
    if (!list.length) return null;
    const terms = here.map((metric) => h('p', {}, h('strong', {}, metric), h('span', { class: 'soft' }, `: ${report.metrics.find((m) => m.name === metric)?.definition ?? ''}`)));
    return h('details', { open: list.length <= 24 || undefined }, h('summary', {}, `${title} (${list.length} figures)`),
      ...terms, table(title, list));
  });
  return section('statistics', 'Statistics', ...parts);
}
