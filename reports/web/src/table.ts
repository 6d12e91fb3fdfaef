// Tables: a small sortable one, and the table of all rows, which contains only the rows in view.
import { Child, copyButton, h, labelledSelect, option } from './dom';
import { figure, fitted, isFit, real, rerunCommand, withBar } from './data';
import { RowIndex } from './rows';
import { fileName, ownLines } from './save';
import { current, put } from './state';

export interface Column<T> { name: string; number?: boolean; value: (row: T) => string | number; cell?: (row: T) => Child; wide?: boolean }

// A long id breaks after its engine, before its response and before its settings.
export function brokenId(method: string): (string | HTMLElement)[] {
  return method.split(/(?=[+{])|(?<=\/)(?=\S)/).flatMap((part, k) => (k ? [h('wbr'), part] : [part]));
}

function compare(a: string | number, b: string | number): number {
  if (typeof a === 'string' || typeof b === 'string') return String(a).localeCompare(String(b), 'en', { numeric: true });
  if (Number.isNaN(a) || Number.isNaN(b)) return Number(Number.isNaN(a)) - Number(Number.isNaN(b));  // last in both directions
  return a - b;
}

function markSorted(heads: Element, column: number, up: boolean): void {
  heads.querySelectorAll('th[aria-sort]').forEach((head, i) => head.setAttribute('aria-sort', i === column ? (up ? 'ascending' : 'descending') : 'none'));
}

function sortHeads(names: { name: string; number?: boolean }[], changed: (column: number, up: boolean) => void): HTMLTableRowElement {
  const heads = names.map(({ name, number }, i) => {
    const head = h('th', { scope: 'col', 'aria-sort': 'none', class: number ? 'number' : undefined },
      h('button', { type: 'button', onclick: () => {
        const up = head.getAttribute('aria-sort') !== 'ascending';
        markSorted(line, i, up);
        changed(i, up);
      } }, ...brokenId(name)));
    return head;
  });
  const line = h('tr', {}, ...heads);
  return line;
}

// Tables that can be sorted follow the address: `by.NAME` is the heading and the way.
const followers = new WeakMap<Element, (state: URLSearchParams) => void>();
export function applySorts(state: URLSearchParams): void {
  document.querySelectorAll('#app .scroll').forEach((region) => followers.get(region)?.(state));
}

export function smallTable<T>(columns: Column<T>[], rows: T[], label: string): HTMLElement {
  const body = h('tbody'), key = `by.${fileName(label)}`;
  const fill = (sorted: T[]) => body.replaceChildren(...sorted.map((row) => h('tr', {}, ...columns.map((column) =>
    h('td', { class: [column.number ? 'number' : '', column.wide ? 'wide' : ''].join(' ').trim() || undefined },
      ...(column.cell ? [column.cell(row)] : brokenId(String(column.value(row)))))))));
  const sort = (i: number, up: boolean) => fill([...rows].sort((a, b) => {
    const x = columns[i].value(a), y = columns[i].value(b);
    const last = compare(x, y);
    return typeof x === 'number' && (Number.isNaN(x) || Number.isNaN(y)) ? last : up ? last : -last;
  }));
  let shown = '';
  const heads = sortHeads(columns, (i, up) => {
    sort(i, up);
    shown = `${columns[i].name},${up ? 'up' : 'down'}`;
    put({ [key]: shown });
  });
  const follow = (state: URLSearchParams) => {
    const told = state.get(key) ?? '', comma = told.lastIndexOf(',');
    const at = columns.findIndex((column) => column.name === told.slice(0, Math.max(comma, 0)));
    const marked = at < 0 ? '' : told;
    if (marked === shown) return;
    shown = marked;
    const up = !told.endsWith(',down');
    markSorted(heads, at, up);
    if (at < 0) fill(rows);
    else sort(at, up);
  };
  fill(rows);
  const region = h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': label },
    h('table', {}, h('thead', {}, heads), body));
  followers.set(region, follow);
  follow(current());
  return region;
}

// A wide table: on a screen its first column stays in view; on paper it is split into blocks of columns, each with the
// first column.
const columnsOnPaper = 6;
export function wideTable<T>(lead: Column<T>[], columns: Column<T>[], rows: T[], label: string, paper: boolean): HTMLElement {
  const block = paper ? columnsOnPaper : Math.max(1, columns.length);
  const blocks = Array.from({ length: Math.max(1, Math.ceil(columns.length / block)) }, (_, k) => columns.slice(k * block, (k + 1) * block));
  return h('div', { class: 'blocks' }, ...blocks.map((some) => smallTable([...lead, ...some], rows, label)));
}
// Draws once for paper, then for the screen again.
export function redrawOnPaper(draw: (paper: boolean) => void): void {
  addEventListener('beforeprint', () => draw(true));
  addEventListener('afterprint', () => draw(false));
}

const rowHeight = 30;
interface Filters { text: string; scenario: string; method: string; metric: string; status: string }

export class RowTable {
  readonly element: HTMLElement;
  private order: number[] = [];
  private sort: { column: number; up: boolean } | null = null;
  private filters: Filters = { text: '', scenario: '', method: '', metric: '', status: '' };
  private readonly body = h('tbody');
  private readonly count = h('output', { class: 'count', id: 'row-count' });
  private readonly view = h('div', { class: 'scroll rows', tabindex: 0, role: 'region', 'aria-label': 'Rows' });
  private readonly table = h('table', { class: 'virtual' });
  private readonly selects = new Map<keyof Filters, HTMLSelectElement>();
  private drawn = '';
  private search!: HTMLInputElement;
  private readonly columns: { name: string; number?: boolean; key: (i: number) => string | number; cell: (i: number) => Child }[];

  constructor(private readonly index: RowIndex) {
    const { rows } = index;
    const text = (name: string, column: number[]) => ({ name, key: (i: number) => index.text(column[i]), cell: (i: number): Child => index.text(column[i]) });
    const number = (name: string, column: (number | string | null)[], show: (i: number) => string) => (
      { name, number: true, key: (i: number) => real(column[i] as number), cell: (i: number): Child => show(i) });
    this.columns = [
      text('scenario', rows.scenario), text('method', rows.method),
      number('steps', rows.steps, (i) => (rows.steps[i] ? String(rows.steps[i]) : 'ladder')),
      number('h [s]', rows.h_s, (i) => (rows.steps[i] ? figure(real(rows.h_s[i]), 4) : '')),
      text('body', rows.body),
      number('t [s]', rows.t_s, (i) => (rows.t_s[i] === null ? '' : figure(real(rows.t_s[i]), 4))),
      text('metric', rows.metric),
      number('value', rows.value, (i) => this.valueWords(i)), text('unit', rows.unit),
      number('truth\u2019s bar', rows.truth_bar, (i) => (real(rows.truth_bar[i]) ? figure(real(rows.truth_bar[i]), 2) : '')),
      text('status', rows.status), text('reason', rows.reason),
    ];
    this.table.append(h('thead', {}, sortHeads(this.columns, (column, up) => {
      this.sort = { column, up };
      this.update();
    })), this.body);
    this.table.querySelector('thead tr')!.append(h('th', { scope: 'col' }, 'rerun'));
    this.view.append(this.table);
    this.view.addEventListener('scroll', () => requestAnimationFrame(() => this.draw()), { passive: true });
    ownLines.set(this.view, () => [this.columns.map((c) => c.name), ...this.order.map((i) => this.columns.map((c) => c.number ? String(c.key(i)) : String(c.cell(i))))]);
    this.element = h('div', {}, this.bar(), this.view);
    this.update();
  }

  private valueWords(i: number): string {
    const { rows } = this.index;
    if (this.index.text(rows.status[i]) !== 'ok') return '\u2013';
    const metric = this.index.text(rows.metric[i]), value = real(rows.value[i]), bar = real(rows.truth_bar[i]);
    return isFit(metric) ? fitted(metric, value, bar) : withBar(value, bar);
  }

  private bar(): HTMLElement {
    const search = this.search = h('input', { id: 'row-search', type: 'search', placeholder: 'words, all must match', autocomplete: 'off' });
    let timer = 0;
    search.addEventListener('input', () => {
      clearTimeout(timer);
      timer = window.setTimeout(() => { this.filters.text = search.value; this.update(); }, 80);
    });
    const select = (label: string, key: 'scenario' | 'method' | 'metric' | 'status') => {
      const made = labelledSelect(label, `row-${key}`, (value) => { this.filters[key] = value; this.update(); });
      made.select.append(option('', 'all'), ...this.index.names(key).map((name) => option(name, name)));
      this.selects.set(key, made.select);
      return made.box;
    };
    const clear = h('button', { type: 'button', onclick: () => {
      search.value = '';
      this.filter({ text: '', scenario: '', method: '', metric: '', status: '' });
    } }, 'clear');
    return h('div', { class: 'bar' },
      h('label', { class: 'field grow', for: 'row-search' }, h('span', {}, 'search'), search),
      select('scenario', 'scenario'), select('method', 'method'), select('metric', 'metric'), select('status', 'status'), clear, this.count);
  }

  filter(filters: Partial<Filters>): void {
    Object.assign(this.filters, filters);
    for (const [key, select] of this.selects) select.value = this.filters[key];
    this.update();
  }

  // The filters and the sorting of a link.
  apply(state: URLSearchParams): void {
    const [column, way] = (state.get('sort') ?? '').split(',');
    const at = this.columns.findIndex((c) => c.name === column);
    this.sort = at < 0 ? null : { column: at, up: way !== 'down' };
    markSorted(this.table, at, this.sort?.up ?? true);
    this.search.value = state.get('q') ?? '';
    const known = (key: 'scenario' | 'method' | 'metric' | 'status') => { const value = state.get(`row-${key}`) ?? ''; return this.report().strings.includes(value) ? value : ''; };
    this.filter({ text: this.search.value, scenario: known('scenario'), method: known('method'), metric: known('metric'), status: known('status') });
  }
  private report() { return this.index.report; }

  private update(): void {
    const told = Object.fromEntries((['scenario', 'method', 'metric', 'status'] as const).map((key) => [`row-${key}`, this.filters[key]]));
    put({ ...told, q: this.filters.text, sort: this.sort ? `${this.columns[this.sort.column].name},${this.sort.up ? 'up' : 'down'}` : null });
    const { rows, report } = this.index;
    const words = this.filters.text.toLowerCase().split(/\s+/).filter(Boolean);
    // A word is searched once in each distinct string, not in each row.
    const hits = words.map((word) => report.strings.map((text) => text.toLowerCase().includes(word)));
    const wanted = (['scenario', 'method', 'metric', 'status'] as const).filter((key) => this.filters[key])
      .map((key) => [rows[key], report.strings.indexOf(this.filters[key])] as const);
    const searched = [rows.scenario, rows.method, rows.metric, rows.status, rows.body, rows.reason];
    this.order = [];
    for (let i = 0; i < this.index.count; i += 1) {
      if (wanted.every(([column, id]) => column[i] === id) && hits.every((hit) => searched.some((column) => hit[column[i]]))) this.order.push(i);
    }
    if (this.sort) {
      const { column, up } = this.sort;
      const keys = new Map(this.order.map((i) => [i, this.columns[column].key(i)]));
      this.order.sort((a, b) => {
        const x = keys.get(a)!, y = keys.get(b)!;
        const either = typeof x === 'number' && (Number.isNaN(x) || Number.isNaN(y as number));
        return (either || up ? compare(x, y) : compare(y, x)) || a - b;
      });
    }
    this.count.textContent = `${this.order.length} of ${this.index.count} rows`;
    this.table.setAttribute('aria-rowcount', String(this.order.length + 1));
    this.view.scrollTop = 0;
    this.drawn = '';
    this.draw();
  }

  private draw(): void {
    const first = Math.max(0, Math.floor(this.view.scrollTop / rowHeight) - 8);
    const last = Math.min(this.order.length, first + Math.ceil((this.view.clientHeight || 560) / rowHeight) + 18);
    const key = `${first} ${last} ${this.order.length}`;
    if (key === this.drawn) return;
    this.drawn = key;
    const spacer = (rows: number) => h('tr', { 'aria-hidden': 'true', class: 'spacer' }, h('td', { colspan: this.columns.length + 1, style: `height:${rows * rowHeight}px` }));
    const lines = this.order.slice(first, last).map((i, k) => this.line(i, first + k));
    this.body.replaceChildren(...(first ? [spacer(first)] : []), ...lines, ...(last < this.order.length ? [spacer(this.order.length - last)] : []));
    if (!this.order.length) this.body.append(h('tr', {}, h('td', { colspan: this.columns.length + 1, class: 'nothing' }, 'No row matches.')));
  }

  private line(i: number, at: number): HTMLTableRowElement {
    const { rows } = this.index;
    const status = this.index.text(rows.status[i]);
    const cells = this.columns.map((column) => {
      const content = column.cell(i);
      return h('td', { class: column.number ? 'number' : undefined, title: column.name === 'reason' || column.name === 'method' ? String(content) : undefined }, content);
    });
    const command = rerunCommand(this.index.text(rows.scenario[i]), this.index.text(rows.method[i]), rows.steps[i]);
    return h('tr', { 'aria-rowindex': at + 2, class: status === 'ok' ? undefined : 'not-ok' }, ...cells, h('td', {}, copyButton(command)));
  }
}
