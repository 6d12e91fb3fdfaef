// Tables of measured figures: the frame budget, the comparison of broad phases.
import { FigureTable, Report, figure } from './data';
import { h, section } from './dom';

function cell(value: string | number | null): HTMLElement {
  if (typeof value === 'string') return h('td', {}, value);
  return h('td', { class: 'number' }, value === null ? '\u2013' : Math.abs(value) >= 1000 ? value.toFixed(0) : figure(value, 3));
}

const mostRows = 24;  // a longer table is folded, and left out on paper

function one(table: FigureTable): HTMLElement[] {
  const rows = h('div', {}, h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': table.title }, h('table', {},
    h('thead', {}, h('tr', {}, ...table.columns.map((column, i) => h('th', { scope: 'col', class: typeof table.rows[0]?.[i] === 'string' ? '' : 'number' }, column)))),
    h('tbody', {}, ...table.rows.map((row) => h('tr', {}, ...row.map(cell)))))));
  return [h('h3', {}, table.title), ...table.notes.map((note) => h('p', { class: 'hint' }, note)),
    table.rows.length > mostRows ? h('details', {}, h('summary', {}, `${table.rows.length} rows`), rows) : rows];
}

export function tables(report: Report): HTMLElement | null {
  if (!report.tables?.length) return null;
  return section('tables', 'Measured tables', ...report.tables.flatMap(one));
}
