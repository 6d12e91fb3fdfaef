// Scenario x method: one figure per cell at one rung, coloured by its rank in the row, with the gates' verdict as a sign.
import { Report, figure, fitted, isFit, noOrder, withBar } from './data';
import { h, labelledSelect, option, section } from './dom';
import { Cell, RowIndex } from './rows';
import { moves } from './scene_metric';
import { linkSelects } from './state';
import { brokenId } from './table';

const short: Record<string, string> = { unsupported: 'n/s', diverged: 'div', 'not finite': 'n/f', timeout: 'time', crashed: 'crash', 'not built': 'n/b' };

// The share of the row's figures that are smaller, 0 to 1; figures within three bars of the truth share the first rank.
// null: no rank, where nothing moves, or all figures are equal.
function rankIn(row: (Cell | null)[], moving: boolean): (cell: Cell) => number | null {
  const size = (cell: Cell) => (Math.abs(cell.value) < 3 * cell.bar ? 0 : Math.abs(cell.value));
  const sizes = row.filter((cell): cell is Cell => !!cell && Number.isFinite(cell.value)).map(size).sort((a, b) => a - b);
  if (!moving || sizes.length < 2 || sizes[0] === sizes[sizes.length - 1]) return () => null;
  return (cell) => (Number.isFinite(cell.value) ? sizes.filter((other) => other < size(cell) * (1 - 1e-9)).length / (sizes.length - 1) : null);
}

// One figure of the table can be reached with Tab, the others from there with the arrow keys: thousands of stops would
// keep a keyboard from what follows.
function moveByArrows(table: HTMLElement): void {
  const to = (next: HTMLElement | null | undefined) => {
    if (!next) return;
    table.querySelectorAll('button[tabindex="0"]').forEach((one) => one.setAttribute('tabindex', '-1'));
    next.tabIndex = 0;
    next.focus();
  };
  table.addEventListener('keydown', (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;  // the browser's own keys
    const cell = (event.target as Element).closest('td'), row = cell?.parentElement;
    if (!cell || !row) return;
    const [down, right] = { ArrowDown: [1, 0], ArrowUp: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] }[event.key] ?? [0, 0];
    if (!down && !right) return;
    event.preventDefault();
    let line: Element | null = row, at = [...row.children].indexOf(cell);
    do {  // over cells without a figure
      line = down ? (down > 0 ? line.nextElementSibling : line.previousElementSibling) : line;
      at += right;
    } while (line?.children[at] && !line.children[at].querySelector('button'));
    to(line?.children[at]?.querySelector('button'));
  });
}

export function matrix(report: Report, index: RowIndex, chosen: (scenario: string, method: string) => void): HTMLElement {
  const table = h('table', { class: 'matrix' });
  moveByArrows(table);
  const allScenarios = index.names('scenario');
  const tagsOf = new Map(report.scenarios.map((s) => [s.id, s.tags]));
  let scenarios = allScenarios, methods = index.names('method');
  const wanted = index.names('metric').filter((name) => !/^status$/.test(name));
  const preferred = ['error-position-max', 'error-position-end'].find((name) => wanted.includes(name)) ?? wanted[0];
  const verdicts = new Map<string, { bad: number; good: number }>();
  for (const verdict of report.verdicts) {
    const key = `${verdict.scenario}\n${verdict.method}`;
    const sum = verdicts.get(key) ?? { bad: 0, good: 0 };
    if (verdict.judgement === 'pass') sum.good += 1;
    else sum.bad += 1;
    verdicts.set(key, sum);
  }
  const ladderOf = new Map(report.scenarios.map((s) => [s.id, s.steps]));

  // The rung: the middle of the scenario's ladder, the same for each method; the finest is another choice.
  const figureAt = (cells: Cell[] | undefined, scenario: string, rung: string) => {
    if (!cells?.length) return null;
    if (cells[0].steps === 0) return cells[0];
    if (rung === 'finest') return cells[cells.length - 1];
    const ladder = ladderOf.get(scenario) ?? cells.map((c) => c.steps);
    const steps = rung === 'coarsest' ? ladder[0] : ladder[Math.floor(ladder.length / 2)];
    return cells.find((c) => c.steps === steps) ?? cells[Math.floor(cells.length / 2)];
  };

  const climbs = allScenarios.some((id) => new Set(index.of(id).map((i) => index.rows.steps[i]).filter((n) => n > 0)).size > 1);
  const draw = () => {
    const tag = tagSelect.select.value;
    scenarios = allScenarios.filter((id) => !tag || tagsOf.get(id)?.includes(tag));
    methods = index.names('method', tag ? scenarios.flatMap((id) => index.of(id)) : undefined);
    const metric = metricSelect.select.value, rung = rungSelect.select.value;
    const found = scenarios.map((scenario) => {
      const ladders = index.ladders(scenario, metric, '');
      return methods.map((method) => figureAt(ladders.get(method), scenario, rung));
    });
    const isLadder = isFit(metric);
    const ranks = scenarios.map((id, s) => rankIn(found[s], moves(index, id, metric)));
    rungSelect.box.hidden = isLadder || !climbs;
    const head = h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'scenario'), ...methods.map((method) => h('th', { scope: 'col', class: 'tilted' }, h('span', {}, ...brokenId(method))))));
    const body = h('tbody', {}, ...scenarios.map((scenario, s) => h('tr', {}, h('th', { scope: 'row', title: scenario }, scenario), ...methods.map((method, m) => {
      const cell = found[s][m];
      const gates = verdicts.get(`${scenario}\n${method}`);
      const sign = gates ? (gates.bad ? h('i', { class: 'bad', title: `${gates.bad} gates did not pass` }, '\u2717') : h('i', { class: 'good', title: `${gates.good} gates pass` }, '\u2713')) : null;
      if (!cell) {
        const trouble = index.trouble(scenario, method);
        return h('td', { class: trouble ? 'trouble' : 'absent', title: trouble ? `${scenario}, ${method}: ${trouble.status}. ${trouble.reason}` : 'not in this study' }, trouble ? short[trouble.status] ?? trouble.status : '\u00b7', sign);
      }
      const size = ranks[s](cell);
      const words = isLadder ? (noOrder(metric, cell.value, cell.bar) ? '?' : cell.value.toFixed(2)) : cell.value === 0 ? '0' : figure(cell.value, 2);
      const reason = index.text(index.rows.reason[cell.row]);
      const told = `${scenario}, ${method}${cell.steps ? `, ${cell.steps} steps` : ''}: ${isLadder ? fitted(metric, cell.value, cell.bar) : withBar(cell.value, cell.bar)}`;
      return h('td', { class: gates?.bad ? 'figure refused' : 'figure', style: isLadder || size === null || gates?.bad ? undefined : `--part:${(size * 100).toFixed(0)}%`, title: `${told}${isLadder || Number.isNaN(cell.value) ? `. ${reason}` : ''}` },
        h('button', { type: 'button', tabindex: -1, 'aria-label': told, onclick: () => chosen(scenario, method) }, words), sign);
    }))));
    table.replaceChildren(head, body);
    table.querySelector('button')?.setAttribute('tabindex', '0');
  };
  const metricSelect = labelledSelect('figure', 'matrix-metric', draw);
  metricSelect.select.append(...wanted.map((name) => option(name, name, name === preferred)));
  const tagSelect = labelledSelect('scenarios', 'matrix-tag', draw);
  tagSelect.select.append(option('', 'all', true), ...[...new Set(report.scenarios.flatMap((s) => s.tags))].sort().map((tag) => option(tag, tag)));
  const rungSelect = labelledSelect('rung of the ladder', 'matrix-rung', draw);
  rungSelect.select.append(option('middle', 'middle, the same steps for all'), option('finest', 'finest of each method'), option('coarsest', 'coarsest'));
  draw();
  linkSelects(tagSelect.select), linkSelects(metricSelect.select), linkSelects(rungSelect.select);
  const legend = h('p', { class: 'hint' }, 'Colours rank the methods of a row, from the smallest error (blue) to the largest (orange); figures within three bars of the truth share the first rank. No colour: nothing moves, or all are equal. Struck out: a gate, which is the claim, did not pass. \u2713 all gates of the cell pass, \u2717 one does not. n/s unsupported, div diverged, n/f a state that is not finite, n/b not built, \u2013 no figure, ? inconclusive order: the reason is in the tooltip and in the rows. A click opens plots and rows; the arrow keys lead from figure to figure.');
  return section('matrix', 'Scenario by method', h('div', { class: 'bar' }, tagSelect.box, metricSelect.box, rungSelect.box), legend,
    h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Scenario by method' }, table));
}
