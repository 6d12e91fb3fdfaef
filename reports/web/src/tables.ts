// Tables of measured figures: the frame budget, the comparison of broad phases.
import { FigureTable, Report, figure } from './data';
import { h, section } from './dom';

function cell(value: string | number | null): HTMLElement {
  if (typeof value === 'string') return h('td', {}, value);
  return h('td', { class: 'number' }, value === null ? '\u2013' : Math.abs(value) >= 1000 ? value.toFixed(0) : figure(value, 3));
}

function one(table: FigureTable): HTMLElement[] {
  return [h('h3', {}, table.title),
    h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': table.title }, h('table', {},
      h('thead', {}, h('tr', {}, ...table.columns.map((column, i) => h('th', { scope: 'col', class: i === 0 ? '' : 'number' }, column)))),
      h('tbody', {}, ...table.rows.map((row) => h('tr', {}, ...row.map(cell)))))),
    ...table.notes.map((note) => h('p', { class: 'hint' }, note))];
}

export function tables(report: Report): HTMLElement | null {
  if (!report.tables?.length) return null;
  return section('tables', 'Measured tables', ...report.tables.flatMap(one));
}
