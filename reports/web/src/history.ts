// What changed against an earlier run or a baseline: better, worse, appeared, vanished.
import type { Change, Report } from './data';
import { figure, real } from './data';
import { copyButton, h, section } from './dom';
import { Column, smallTable } from './table';

const words: Record<Change['kind'], string> = { regression: 'worse', improvement: 'better', missing: 'vanished', added: 'appeared' };

const badges: Record<Change['kind'], string> = { regression: 'fail', improvement: 'pass', missing: 'not-run', added: '' };

const countsOf = (report: Report) =>
  Object.keys(words).map((kind) => report.change_counts?.[kind as Change['kind']] ?? 0);

// "3 worse, 1 better", for a sentence; empty: nothing was compared.
export function changeCounts(report: Report): string {
  if (!report.changes) return '';
  const all = countsOf(report);
  const counts = Object.values(words).map((word, i) => (all[i] ? `${all[i]} ${word}` : '')).filter((text) => text);
  return counts.length ? counts.join(', ') : 'every figure is as it was';
}

export function history(report: Report): HTMLElement | null {
  if (!report.changes) return null;
  const shown = report.changes.length, all = countsOf(report).reduce((sum, count) => sum + count, 0);
  const part = shown < all ? ` The first ${shown} are shown.` : '';
  const sentence = h('p', {}, `Against ${report.changes_against}: ${changeCounts(report)}.${part}`);
  if (!report.changes.length) return section('changes', 'Changes', sentence);
  const order = Object.keys(words);
  const factor = (change: Change) => change.kind === 'improvement' ? 1 / real(change.ratio) : change.kind === 'regression' ? real(change.ratio) : NaN;
  const columns: Column<Change>[] = [
    { name: 'change', value: (c) => order.indexOf(c.kind), cell: (c) => h('span', { class: `badge ${badges[c.kind]}` }, words[c.kind]) },
    { name: 'scenario', value: (c) => c.scenario },
    { name: 'method', value: (c) => c.method },
    { name: 'figure', value: (c) => c.metric, cell: (c) => c.steps ? `${c.metric} at ${c.steps} steps` : c.metric },
    { name: 'before', number: true, value: (c) => real(c.before), cell: (c) => figure(real(c.before)) },
    { name: 'now', number: true, value: (c) => real(c.now), cell: (c) => figure(real(c.now)) },
    { name: 'unit', value: (c) => c.unit === '1' ? '' : c.unit },
    { name: 'by', number: true, value: factor, cell: (c) => Number.isFinite(factor(c)) ? `${figure(factor(c), 3)} \u00d7` : '' },
    { name: 'rerun', value: () => '', cell: (c) => c.rerun ? copyButton(c.rerun) : '' },
  ];
  return section('changes', 'Changes', sentence, smallTable(columns, report.changes, 'Figures that changed'));
}
