// The library audit: claimed and executed order of each method of a library, problem by problem.
import { AuditFinding, AuditProblem, Report, commandLine, figure, real, shellWord } from './data';
import { Child, copyButton, h, section } from './dom';
import { Column, smallTable } from './table';

const words: Record<string, string> = { 'as claimed': 'pass', lower: 'fail', higher: 'higher', inconclusive: 'inconclusive', unsupported: 'unsupported' };
const rank = ['lower', 'higher', 'inconclusive', 'as claimed', 'unsupported'];

function executed(problem: AuditProblem | undefined): Child {
  if (!problem) return '';
  if (problem.verdict === 'unsupported') return h('span', { class: 'soft', title: problem.reason }, 'unsupported');
  const order = real(problem.order);
  if (!Number.isFinite(order)) return h('span', { class: 'soft', title: problem.reason }, 'inconclusive');
  const half = real(problem.half_width_95);
  const text = `${(Math.abs(order) < 0.005 ? 0 : order).toFixed(2)}${half > 0 ? ` \u00b1 ${figure(half, 2)}` : ''}${problem.quantity === 'velocity' ? ' (velocity)' : ''}`;
  return h('span', { title: problem.reason }, problem.verdict === 'lower' || problem.verdict === 'higher' ? h('b', {}, text) : text);
}

function findingsTable(report: Report, findings: AuditFinding[], label: string): HTMLElement {
  const scenarios = [...new Set(report.audit!.flatMap((f) => f.problems.map((p) => p.scenario)))].sort();
  const of = (finding: AuditFinding, scenario: string) => finding.problems.find((p) => p.scenario === scenario);
  const columns: Column<AuditFinding>[] = [
    { name: 'verdict', value: (f) => rank.indexOf(f.verdict), cell: (f) => h('span', { class: `badge ${words[f.verdict] ?? ''}` }, f.verdict) },
    { name: 'method', value: (f) => f.method },
    { name: 'claimed', number: true, value: (f) => real(f.claimed), cell: (f) => h('span', { title: f.claim }, String(f.claimed)) },
    ...scenarios.map((scenario): Column<AuditFinding> => ({ name: scenario, number: true, value: (f) => real(of(f, scenario)?.order), cell: (f) => executed(of(f, scenario)) })),
    { name: 'evidence', value: () => '', cell: (f) => copyButton(commandLine(`describe ${shellWord(f.method.replace(':tol', ':1e-8'))} --program`)) },
  ];
  return smallTable(columns, findings, label);
}

export function audit(report: Report): HTMLElement | null {
  const all = report.audit ?? [];
  if (!all.length) return null;
  const sorted = [...all].sort((a, b) => rank.indexOf(a.verdict) - rank.indexOf(b.verdict));
  const found = sorted.filter((f) => f.verdict !== 'as claimed'), rest = sorted.filter((f) => f.verdict === 'as claimed');
  const count = (verdict: string) => all.filter((f) => f.verdict === verdict).length;
  return section('audit', `Library audit: ${count('lower')} of ${all.length} methods below their claim`,
    h('p', { class: 'hint' }, 'The order that the library claims, and the order executed on the reference\u2019s equations with its 95 % interval; a tooltip shows the window and the rungs left out. An order within 0.25 of a whole number counts as that number; it is the order of positions, or of velocities where positions are inconclusive. Methods that end in :tol choose their steps: an exponent of the largest position error over the tolerance, below 0.5, or a ratio of error to tolerance that varies a thousandfold, counts as lower where the error exceeds a hundred times the tolerance. Evidence: a command that prints a program without Atwood.'),
    found.length ? findingsTable(report, found, 'Methods whose executed order is not the claimed one') : null,
    h('details', {}, h('summary', {}, `${rest.length} methods as claimed`), findingsTable(report, rest, 'Methods as claimed')));
}
