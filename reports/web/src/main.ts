import { Report, readReport } from './data';
import { h, section } from './dom';
import { dominance } from './dominance';
import { audit } from './audit';
import { Fields } from './fields';
import { goals } from './goals';
import { history } from './history';
import { tables } from './tables';
import { matrix } from './matrix';
import { Plots, plottable } from './plots';
import { RowIndex } from './rows';
import { gallery } from './scenes';
import * as sections from './sections';
import { sheets } from './sheets';
import { sideBySide } from './side_by_side';
import { statistics } from './statistics';
import { sweep } from './sweep';
import { isDark, setPaper } from './style';
import { citeButton, equipTables } from './save';
import { story } from './story';
import { applyFolds, applySelects, following, show, watch } from './state';
import { RowTable, applySorts } from './table';

function themeSwitch(changed: () => void): HTMLElement {
  const root = document.documentElement;
  const button = h('button', { type: 'button', id: 'theme' });
  const name = () => {
    button.textContent = isDark() ? 'light' : 'dark';
    button.setAttribute('aria-label', `Switch to ${button.textContent} colours`);
  };
  try {
    const kept = localStorage.getItem('atwood-theme');
    if (kept === 'dark' || kept === 'light') root.dataset.theme = kept;
  } catch { /* a page opened from disk may have no storage: the switch then lasts until it is closed */ }
  button.addEventListener('click', () => {
    root.dataset.theme = isDark() ? 'light' : 'dark';
    try { localStorage.setItem('atwood-theme', root.dataset.theme); } catch { /* as above */ }
    name();
    changed();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { name(); changed(); });
  name();
  return button;
}

const shortNames: Record<string, string> = { story: 'Summary', failing: 'Not passed', changes: 'Changes', laws: 'Laws', audit: 'Audit', goals: 'Goals', tables: 'Tables', dominance: 'Cheapest', cells: 'No figures', matrix: 'Matrix', compare: 'Side by side', sweep: 'Geometry', scenes: 'Scenes', plots: 'Plots', fields: 'Fields', statistics: 'Statistics', rows: 'Rows', gates: 'Gates', bench: 'Benchmarks', engines: 'Engines', scenarios: 'Catalogue', metrics: 'Metrics', provenance: 'Provenance' };
function navigation(parts: HTMLElement[]): HTMLElement {
  return h('nav', { 'aria-label': 'Sections' }, ...parts.map((part) => h('a', { href: `#${part.id}` }, shortNames[part.id] ?? part.id)));
}

// On paper the scenes stand one to a page in place of the gallery and of the plots of the scene that is open.
function preparePrinting(report: Report, index: RowIndex, ids: string[], fields: Fields | null): void {
  const opened: HTMLDetailsElement[] = [];
  let paper: HTMLElement | null = null;
  addEventListener('beforeprint', () => {
    setPaper(true);
    for (const details of document.querySelectorAll('details')) if (!details.open && !details.closest('#gates, #laws, #bench, #tables, #statistics, #scenes, #plots, #scenarios, #engines')) { details.open = true; opened.push(details); }
    paper?.remove();
    if (ids.length) (document.getElementById('plots') ?? document.getElementById('app')!.lastElementChild!).after(paper = sheets(report, index, ids));
    fields?.drawAll();
  });
  addEventListener('afterprint', () => {
    setPaper(false);
    paper?.remove();
    opened.splice(0).forEach((details) => { details.open = false; });
  });
}

async function start(): Promise<void> {
  const report = await readReport();
  const index = new RowIndex(report);
  const plots = plottable(index).length ? new Plots(report, index) : null;
  const fields = report.pictures?.length ? new Fields(report, index) : null;
  const table = index.count ? new RowTable(index) : null;
  const rows = table && section('rows', 'Rows', table.element, h('p', { class: 'paper-only' }, `${index.count} rows: on screen, and in the CSV and JSON reports.`));
  const open = (scenario: string, method: string) => {
    const drawn = plots?.select(scenario);
    table!.filter({ scenario, method, metric: '', status: '' });
    show(drawn ? plots!.element : table!.element);
  };
  const narrow = matchMedia('(max-width: 700px)').matches, pictures = gallery(report, plottable(index));
  // On a narrow screen the plot follows the first sentence.
  const first = [index.count ? story(report, index) : null, narrow ? plots?.element : null, sections.failing(report), history(report), audit(report), goals(report)];
  const scenes = [pictures, narrow ? null : plots?.element, fields?.element, index.count ? matrix(report, index, open) : null, dominance(report), sections.laws(report), sections.troubles(report, index)];
  const figures = [index.count ? sweep(index) : null, index.count ? sideBySide(report, index) : null, index.count ? statistics(report, index) : null, tables(report), rows, sections.gates(report), sections.bench(report)];
  const parts = [...first, ...scenes, ...figures, sections.engines(report), sections.scenarios(report), sections.definitions(report, index), sections.provenance(report)].filter((part) => part) as HTMLElement[];
  document.getElementById('app')!.replaceChildren(...parts);
  document.body.prepend(h('a', { class: 'skip', href: '#app' }, 'Skip to the report'));
  document.getElementById('top')!.after(navigation(parts));
  document.getElementById('tools')!.append(themeSwitch(() => plots?.restyle()), citeButton(report), h('button', { type: 'button', onclick: () => print() }, 'print'));
  equipTables(document.body);  // the table of the fluids stands before the rest
  preparePrinting(report, index, plottable(index), fields);
  let opening = true;
  watch((state) => following(() => {
    const opens = opening;
    opening = false;
    if (opens && !state.toString()) return;
    plots?.apply(state);
    table?.apply(state);
    applySelects(state);
    applySorts(state);
    applyFolds(state);
    show(document.getElementById(state.get('at') ?? '') ?? (state.has('scene') ? plots?.element ?? null : null));
  }));
  document.documentElement.dataset.drawn = performance.now().toFixed(1);
  document.documentElement.dataset.ready = 'true';
}

// The page's load event waits for the report to be drawn, so that what prints or photographs a page once it is loaded
// (chromium --print-to-pdf) gets all of it: a frame whose document is open delays the event.
function delayLoad(): () => void {
  const frame = h('iframe', { hidden: true });
  document.body.append(frame);
  frame.contentDocument?.open();
  return () => { frame.contentDocument?.close(); frame.remove(); };
}

const drawn = delayLoad();
start().finally(drawn).catch((error: unknown) => {
  document.getElementById('app')!.append(h('p', { class: 'broken' }, `The report's data cannot be read: ${String(error)}. A browser from 2023 or later is needed (DecompressionStream).`));
  throw error;
});
