// The sections of the report with texts and small tables.
import { Engine, Law, Method, RanMethod, Report, Setting, Verdict, family, figure, isAdaptive, real, rerunCommand, unitWord } from './data';
import { Child, copyButton, h, section } from './dom';
import { RowIndex } from './rows';
import { Column, smallTable } from './table';

function badge(judgement: string): HTMLElement {
  const sign: Record<string, string> = { pass: '\u2713', fail: '\u2717', unverifiable: '?', 'not run': '\u2013', not_run: '\u2013' };
  return h('span', { class: `badge ${judgement.replace(/[ _]/g, '-')}` }, `${sign[judgement] ?? ''} ${judgement.replace('_', ' ')}`);
}
function command(text: string): HTMLElement { return h('div', { class: 'command' }, h('code', {}, text), copyButton(text)); }
function measured(verdict: Verdict): string {
  if (/^not.run$/.test(verdict.judgement)) return '\u2013';
  const value = real(verdict.value), bar = real(verdict.bar);
  return `${figure(value)}${Math.abs(value) < 1000 * bar ? ` \u00b1 ${figure(bar, 2)}` : ''} ${unitWord(verdict.unit)}`;
}

// Gates with the same verdict on the rungs of one ladder share a card: same scenario, method, metric, bound and verdict.
function alike(verdicts: Verdict[]): Verdict[][] {
  const groups = new Map<string, Verdict[]>();
  for (const v of verdicts) {
    const key = [v.judgement, v.scenario, v.method, v.metric, v.allowed, v.reason].join('\n');
    groups.set(key, [...(groups.get(key) ?? []), v]);
  }
  return [...groups.values()].map((group) => group.sort((a, b) => a.steps - b.steps));
}

export function failing(report: Report): HTMLElement | null {
  const rank = ['fail', 'unverifiable'];
  const bad = report.verdicts.filter((v) => v.judgement !== 'pass')
    .sort((a, b) => (rank.indexOf(a.judgement) >>> 0) - (rank.indexOf(b.judgement) >>> 0));
  if (!bad.length) return null;
  const card = (group: Verdict[]) => {
    const one = group[0];
    const steps = group.length > 1 ? `, ${group.length} rungs` : one.steps ? `, ${one.steps} steps` : '';
    const rerun = group.length > 1 && one.steps ? rerunCommand(one.scenario, one.method, 0) : one.rerun;
    const facts = group.flatMap((v) => [h('dt', {}, group.length > 1 && v.steps ? `${v.steps} steps` : v.metric), h('dd', {}, measured(v))]);
    return h('li', { class: `card ${one.judgement.replace(/[ _]/g, '-')}` },
      h('h3', {}, badge(one.judgement), ` ${one.scenario} `, h('span', { class: 'soft' }, `${one.method}${steps}`)),
      group.length > 1 ? h('p', {}, one.metric) : null,
      h('dl', { class: 'facts' }, ...facts, h('dt', {}, 'allowed'), h('dd', {}, `${one.allowed} ${unitWord(one.unit)}`)),
      group.length > 1 ? null : h('p', {}, one.text),
      h('p', { class: 'soft' }, `${one.reason}${one.origin ? ` (${one.origin})` : ''}`),
      rerun ? command(rerun) : null);
  };
  const cards = alike(bad);
  const rest = cards.slice(24);
  return section('failing', 'What did not pass', h('ul', { class: 'cards' }, ...cards.slice(0, 24).map(card)),
    rest.length ? h('details', {}, h('summary', {}, `${rest.length} more`), h('ul', { class: 'cards' }, ...rest.map(card))) : null);
}

// Cells without figures, one line per scenario, method and reason.
export function troubles(report: Report, index: RowIndex): HTMLElement | null {
  interface Trouble { scenario: string; method: string; status: string; reason: string; steps: number[] }
  const found = new Map<string, Trouble>();
  const { rows } = index;
  for (let i = 0; i < index.count; i += 1) {
    const status = index.text(rows.status[i]);
    if (status === 'ok') continue;
    const key = [rows.scenario[i], rows.method[i], rows.status[i], rows.reason[i]].join(' ');
    const trouble = found.get(key) ?? { scenario: index.text(rows.scenario[i]), method: index.text(rows.method[i]), status, reason: index.text(rows.reason[i]), steps: [] };
    if (!trouble.steps.includes(rows.steps[i])) trouble.steps.push(rows.steps[i]);
    found.set(key, trouble);
  }
  if (!found.size) return null;
  const rank = ['crashed', 'timeout', 'not finite', 'diverged', 'not built', 'unsupported'];
  const list = [...found.values()].sort((a, b) => rank.indexOf(a.status) - rank.indexOf(b.status));
  const broken = list.some((t) => t.status === 'crashed' || t.status === 'timeout');
  const counts = rank.map((status) => [status, list.filter((t) => t.status === status).length] as const).filter(([, n]) => n).map(([status, n]) => `${n} ${status}`);
  return section('cells', 'Cells without figures', h('details', { open: broken || undefined }, h('summary', {}, `Scenario and method: ${counts.join(', ')}`), smallTable<Trouble>([
    { name: 'status', value: (t) => t.status, cell: (t) => h('span', { class: `badge ${t.status === 'crashed' || t.status === 'timeout' ? 'fail' : ''}` }, t.status) },
    { name: 'scenario', value: (t) => t.scenario }, { name: 'method', value: (t) => t.method },
    { name: 'steps', value: (t) => t.steps.join(', '), wide: true }, { name: 'reason', value: (t) => t.reason, wide: true },
    { name: 'rerun', value: () => '', cell: (t) => copyButton(rerunCommand(t.scenario, t.method, t.steps.length === 1 ? t.steps[0] : 0)) },
  ], list, `Cells without figures in ${report.title}`)));
}

export function gatesTable(verdicts: Verdict[], label: string): HTMLElement {
  return smallTable<Verdict>([
    { name: 'verdict', value: (v) => v.judgement, cell: (v) => badge(v.judgement) },
    { name: 'scenario', value: (v) => v.scenario }, { name: 'method', value: (v) => v.method },
    { name: 'steps', number: true, value: (v) => v.steps, cell: (v) => (v.steps ? String(v.steps) : 'ladder') },
    { name: 'metric', value: (v) => v.metric },
    { name: 'measured', number: true, value: (v) => real(v.value), cell: measured },
    { name: 'allowed', value: (v) => v.allowed }, { name: 'reason', value: (v) => v.reason, wide: true },
  ], verdicts, label);
}

export function gates(report: Report): HTMLElement | null {
  if (!report.verdicts.length) return null;
  return section('gates', 'All gates', h('details', {}, h('summary', {}, `${report.verdicts.length} gates`), gatesTable(report.verdicts, 'All gates')));
}

// Each law once per scenario and method, at the rung nearest to 60 steps per second; the other rungs are in a folded table.
export function laws(report: Report): HTMLElement | null {
  if (!report.laws.length) return null;
  const seconds = new Map(report.scenarios.map((s) => [s.id, real(s.t_end_s)]));
  const away = (law: Law) => Math.abs(Math.log(law.steps / (60 * (seconds.get(law.scenario) ?? 1))));
  const nearest = new Map<string, Law>();
  for (const law of report.laws) {
    const key = [law.scenario, law.method, law.metric, law.statement].join('\n');
    const held = nearest.get(key);
    if (!held || away(law) < away(held)) nearest.set(key, law);
  }
  const off = (law: Law) => Math.abs(real(law.measured) / real(law.predicted) - 1);
  const apart = (law: Law) => (!Number.isFinite(off(law)) ? '\u2013' : off(law) > 10 ? `\u00d7 ${figure(off(law) + 1, 2)}` : `${figure(off(law) * 100, 2)} %`);
  const table = (list: Law[], label: string) => smallTable<Law>([
    { name: 'scenario', value: (l) => l.scenario }, { name: 'method', value: (l) => l.method },
    { name: 'steps', number: true, value: (l) => l.steps, cell: (l) => (l.steps ? String(l.steps) : 'ladder') },
    { name: 'metric', value: (l) => l.metric }, { name: 'law', value: (l) => l.statement, wide: true },
    { name: 'predicted', number: true, value: (l) => real(l.predicted), cell: (l) => h('b', {}, `${figure(real(l.predicted))} ${unitWord(l.unit)}`) },
    { name: 'measured', number: true, value: (l) => real(l.measured), cell: (l) => h('b', {}, `${figure(real(l.measured))} ${unitWord(l.unit)}`) },
    { name: 'apart', number: true, value: off, cell: apart },
  ], list, label);
  const shown = [...nearest.values()];
  return section('laws', 'Laws: predicted and measured',
    h('p', { class: 'hint' }, 'Errors that a formula predicts, at the step nearest to a sixtieth of a second.'), table(shown, 'Laws'),
    shown.length < report.laws.length ? h('details', {}, h('summary', {}, `All steps: ${report.laws.length} lines`), table(report.laws, 'Laws at all steps')) : null);
}

function word(value: Setting): string { return typeof value === 'number' ? figure(value, 6) : String(value); }

// Groups the methods that ran by equal settings (a ladder of tolerances is one group).
interface Alike { ids: string[]; parts: [string, Record<string, Setting>][] }
function alikeSet(ran: RanMethod[]): Alike[] {
  const groups = new Map<string, Alike>();
  for (const method of ran) {
    const own = isAdaptive(method.id) && 'rtol' in method.settings ? { ...method.settings, rtol: 'tol' } : method.settings;
    const parts: Alike['parts'] = [['', own], ...(method.response ? [[method.response, method.response_settings ?? {}] as Alike['parts'][number]] : [])];
    const key = JSON.stringify([method.response ?? '', parts]);
    const group = groups.get(key) ?? { ids: [], parts };
    const id = family(method.id);
    if (!group.ids.includes(id)) group.ids.push(id);
    groups.set(key, group);
  }
  return [...groups.values()];
}

// A line `key = value` for each setting, in as many columns as fit.
function settingsList(groups: Alike[]): Child {
  const values = new Map<string, Set<string>>();
  for (const { parts } of groups) for (const [of, settings] of parts) for (const [name, value] of Object.entries(settings)) values.set(of + name, (values.get(of + name) ?? new Set()).add(word(value)));
  const pairs = ([of, settings]: Alike['parts'][number]) => h('ul', { class: 'settings' }, ...Object.entries(settings).map(([name, value]) =>
    h('li', { class: values.get(of + name)!.size > 1 ? 'differs' : undefined }, `${name} = `, h('span', { class: typeof value === 'string' ? undefined : 'value' }, word(value)))));
  return h('dl', { class: 'set' }, ...groups.flatMap(({ ids, parts }) => [h('dt', {}, ids.join(', ')),
    ...parts.filter(([of, settings]) => of || Object.keys(settings).length).map((part) => h('dd', {}, part[0] ? h('span', { class: 'soft' }, `${part[0]}: `) : null, pairs(part))),
    parts.every(([, settings]) => !Object.keys(settings).length) ? h('dd', { class: 'soft' }, 'no settings') : null]));
}

export function engines(report: Report): HTMLElement | null {
  if (!report.engines.length && !report.missing_engines.length) return null;
  const docs = (methods: Method[]) => methods.flatMap((m) => {
    const claims = Object.entries(m.claimed_order).map(([motion, order]) => `${motion} ${order}`).join(', ');
    return [h('dt', {}, m.id), h('dd', {}, m.doc, h('span', { class: 'soft' }, ` ${claims ? `Claimed order: ${claims}. ` : ''}${m.source}`))];
  });
  const one = (engine: Engine) => {
    const told = [...engine.methods, ...(engine.responses ?? [])];
    return h('article', { class: 'engine' },
      h('h3', {}, engine.name, h('span', { class: 'soft' }, ` ${engine.version} \u00b7 ${engine.scalar}`)),
      settingsList(alikeSet(report.ran.filter((m) => m.engine === engine.name))),
      told.length ? h('details', {}, h('summary', {}, `What ${told.map((m) => m.id).slice(0, 3).join(', ')}${told.length > 3 ? ` and ${told.length - 3} more` : ''} ${told.length === 1 ? 'is and claims' : 'are and claim'}`),
        h('dl', { class: 'docs' }, ...docs(told))) : null);
  };
  const missing = report.missing_engines.length
    ? h('ul', { class: 'missing' }, ...report.missing_engines.map((m) => h('li', {}, h('b', {}, m.name), ` is missing: ${m.reason}`))) : null;
  return section('engines', 'Engines and their settings', h('p', { class: 'hint' }, 'Settings of the methods that ran. Shaded settings differ between methods of an engine; contact responses (+impulse, +event, +penalty) have their own settings.'), missing, ...report.engines.map(one));
}

export function bench(report: Report): HTMLElement | null {
  if (!report.bench.length) return null;
  const table = (list: Report['bench'], label: string, what: Column<Report['bench'][number]>[]) => smallTable([...what,
    { name: 'median [ns]', number: true, value: (b) => real(b.ns_per_step_median), cell: (b) => figure(real(b.ns_per_step_median), 4) },
    { name: 'p95 [ns]', number: true, value: (b) => real(b.ns_per_step_p95), cell: (b) => figure(real(b.ns_per_step_p95), 4) }], list, label);
  const steps = report.bench.filter((b) => b.scenario), others = report.bench.filter((b) => !b.scenario);
  return section('bench', 'Benchmarks',
    h('p', { class: 'hint' }, 'Measured by atwood bench. The section Side by side shows them with the errors at the same steps.'),
    others.length ? table(others, 'Benchmarks of kernels', [{ name: 'one call of', value: (b) => b.name }]) : null,
    steps.length ? h('details', {}, h('summary', {}, `Time of a step: ${steps.length} figures`), table(steps, 'Time of a step', [
      { name: 'scenario', value: (b) => b.scenario }, { name: 'method', value: (b) => b.method }, { name: 'steps', number: true, value: (b) => b.steps }])) : null);
}

// Definitions of the metrics in this report.
export function definitions(report: Report, index: RowIndex): HTMLElement | null {
  const measured = new Set([...index.names('metric'), ...report.verdicts.map((v) => v.metric)]);
  const shown = report.metrics.filter((m) => measured.has(m.name));
  if (!shown.length) return null;
  return section('metrics', 'What each metric means', h('details', {}, h('summary', {}, `${shown.length} metrics`),
    h('dl', { class: 'docs' }, ...shown.flatMap((m) => [h('dt', {}, m.name, h('span', { class: 'soft' }, m.unit ? ` [${m.unit}]` : '')), h('dd', {}, m.definition)]))));
}

export function scenarios(report: Report): HTMLElement | null {
  if (!report.scenarios.length) return null;
  return section('scenarios', 'Scenarios and their claims', h('details', {}, h('summary', {}, `${report.scenarios.length} scenarios`), smallTable([
    { name: 'id', value: (s) => s.id }, { name: 'title', value: (s) => s.title, wide: true }, { name: 'claim', value: (s) => s.claim, wide: true },
    { name: 'truth', value: (s) => s.truth }, { name: 't_end [s]', number: true, value: (s) => real(s.t_end_s), cell: (s) => figure(real(s.t_end_s)) },
    { name: 'steps', value: (s) => s.steps.length, cell: (s) => s.steps.join(', '), wide: true }, { name: 'source', value: (s) => s.source, wide: true },
  ], report.scenarios, 'Scenarios')));
}

export function provenance(report: Report): HTMLElement {
  const names: Record<string, string> = { engine_version: 'version', commit: 'commit', compiler: 'compiler', flags: 'flags', cpu: 'CPU', run_id: 'run' };
  return section('provenance', 'Where these figures come from',
    h('dl', { class: 'facts tall' }, ...Object.entries(report.provenance).filter(([, value]) => value).flatMap(([name, value]) => [h('dt', {}, names[name] ?? name), h('dd', {}, h('code', {}, value))]),
      ...report.engines.flatMap((e) => [h('dt', {}, e.name), h('dd', {}, h('code', {}, `${e.version} ${e.scalar}`))])),
    report.command ? command(report.command) : null, h('p', { class: 'hint' }, report.left_out));
}
