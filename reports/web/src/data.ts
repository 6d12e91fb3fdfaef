// The embedded data: base64 of raw deflate of JSON, in columns with a string table.
import type { DrawnScene } from './scene_picture';

type Strings = string[];

export interface Verdict {
  judgement: string; scenario: string; method: string; steps: number; metric: string; unit: string;
  value: Loose; bar: Loose; kind: string; allowed: string; margin: Loose; text: string; reason: string; origin: string;
  rerun: string;
}
export interface Law {
  scenario: string; method: string; steps: number; metric: string; statement: string; predicted: Loose; measured: Loose;
  unit: string;
}
export interface Scenario {
  id: string; title: string; claim: string; source: string; truth: string; t_end_s: Loose; samples: number;
  steps: number[]; tags: string[]; invariants: string[]; metric?: string;  // that the scene is about, where its file names it
}
export interface Method {
  id: string; doc: string; source: string; claimed_order: Record<string, number>; adaptive: boolean;
  settings: Record<string, Setting>;
}
export interface Engine { name: string; version: string; scalar: string; methods: Method[]; responses?: Method[] }
export interface RanMethod { id: string; engine: string; settings: Record<string, Setting>; response?: string; response_settings?: Record<string, Setting> }
export interface Bench {
  name: string; scenario: string; method: string; steps: number; ns_per_step_median: Loose; ns_per_step_p95: Loose;
}
export interface GoalEntrant { method: string; steps: number; error: Loose; bar: Loose; seconds: Loose; evaluations: Loose; ns_per_step: Loose; accurate: boolean; last_quarter?: Loose; floor?: Loose }
export interface Goal {
  id: string; title: string; scenario: string; metric: string; unit: string; wanted_error: Loose; budget_kind: string; budget: Loose; reached: boolean;
  ours: GoalEntrant | null; rival: GoalEntrant | null; uncounted: GoalEntrant | null; ratio: Loose; ratio_low: Loose; ratio_high: Loose; why: string; wanted_ratio?: number; low?: Loose; high?: Loose;
  close?: GoalEntrant[]; machine?: { timings: number; interrupted: number; repeated: number; ghz_low: Loose; ghz_high: Loose; again?: number; busy: boolean }; left_out?: string[];
}
export interface Reached { family: string; method: string; steps: number; error: Loose; cost: Loose; at_bar?: boolean; coarsest?: boolean; spacing_m?: Loose; sound_speed_m_per_s?: Loose }
export interface Contest { asked: Loose; contenders: number; ranked: Reached[]; to_next?: { value: Loose; low: Loose; high: Loose; pairs: number } }
export interface Dominance {
  scenario: string; metric: string; unit: string; cost: 'seconds' | 'evaluations'; by_error: Contest[]; by_budget: Contest[];
  by_spacing?: { spacing_m: Loose; sound_speed_m_per_s: Loose; ranked: Reached[] }[];
  stable: { family: string; stable: boolean; method?: string; steps?: number; h_s?: Loose; error?: Loose; failed: { method: string; steps: number; status: string; reason: string }[] }[];
}
export interface Run {
  s: number; m: number; n: number; t: number;
  position?: Loose[]; velocity?: Loose[]; attitude?: Loose[]; 'body-rate'?: Loose[]; energy?: Loose[];
}
// A list of whole numbers between the least and the largest value of a field.
export interface Levels { low: Loose; high: Loose; at: number[] }
export interface Picture {
  s: number; m: number; n: number; dx: Loose; c: Loose; t: Loose; particles: number; side: Loose; error_of: string;
  x: Levels; y: Levels; speed?: Levels; pressure?: Levels; temperature?: Levels; error?: Levels;
}
export type Setting = string | number | boolean;
export type Loose = number | string;  // non-finite numbers come as "nan", "inf", "-inf"

export interface Rows {
  scenario: number[]; method: number[]; steps: number[]; h_s: Loose[]; body: number[]; t_s: (Loose | null)[];
  metric: number[]; unit: number[]; value: Loose[]; truth_bar: Loose[]; status: number[]; reason: number[];
  settings_hash: number[]; engine_version: number[];
}
export interface AuditProblem { scenario: string; verdict: string; order: Loose; half_width_95: Loose; quantity: string; reason: string }
export interface AuditFinding { method: string; claim: string; claimed: Loose; verdict: string; problems: AuditProblem[] }
export interface FigureTable { id: string; title: string; columns: string[]; rows: (string | number | null)[][]; notes: string[] }
export interface Change {
  kind: 'regression' | 'improvement' | 'missing' | 'added'; scenario: string; method: string; metric: string; steps: number;
  before: Loose; now: Loose; bar: Loose; allowed: Loose; ratio: Loose; unit: string; text: string; rerun: string;
}
export interface Report {
  changes_against?: string; changes?: Change[];  // against an earlier run or a baseline: the first ones
  first_run?: boolean;  // no earlier run of this study and selection is known
  change_counts?: Record<Change['kind'], number>;  // of all changes
  title: string; command: string; program: string; left_out: string; provenance: Record<string, string>;
  verdicts: Verdict[]; laws: Law[]; scenarios: Scenario[]; engines: Engine[]; ran: RanMethod[];
  missing_engines: { name: string; reason: string }[];
  metrics: { name: string; unit: string; definition: string }[];
  bench: Bench[]; dominance: Dominance[]; goals: Goal[]; tables?: FigureTable[]; audit?: AuditFinding[]; notes: string[]; own_files: Record<string, string>; rows: Rows; series: { instants: Loose[][]; runs: Run[] }; pictures?: Picture[]; scenes?: DrawnScene[]; strings: Strings;
}

export async function readReport(): Promise<Report> {
  const coded = document.getElementById('data')!.textContent!;
  const bytes = Uint8Array.from(atob(coded), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const report = JSON.parse(await new Response(stream).text()) as Report;
  for (const [scenario, file] of Object.entries(report.own_files)) ownFiles.set(scenario, file);
  program = report.program;
  return report;
}

export function real(value: Loose | null | undefined): number {
  if (typeof value === 'number') return value;
  return value === 'inf' ? Infinity : value === '-inf' ? -Infinity : NaN;
}

// 4 or 5 digits: plain near 1, powers of ten elsewhere.
export function figure(value: number, digits = 5): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? '\u2013' : value > 0 ? 'inf' : '-inf';  // NaN: no figure
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e6) return String(value);
  const text = size >= 1e-3 && size < 1e6 ? value.toPrecision(digits) : value.toExponential(digits - 1);
  return text.includes('e') ? text.replace(/\.?0+e/, 'e').replace('e+', 'e') : text.replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
}

// A figure below three bars is only an upper bound.
export function withBar(value: number, bar: number): string {
  if (bar > 0 && value >= 0 && value < 3 * bar) return `\u2264 ${figure(value + bar, 3)}`;
  return figure(value);
}

// Why there is no figure, in a word or two; the row's reason has the full text.
export function absence(reason: string): string {
  const found = /^(\d+) of (\d+) impacts reported/.exec(reason);
  if (found) return `${Number(found[2]) - Number(found[1])} of ${found[2]} missed`;
  return reason.split(':')[0].slice(0, 24);
}

// A fitted order or exponent: its bar is the half-width of its 95 % interval.
export function isFit(metric: string): boolean { return /^(order|growth|richardson)|-exponent/.test(metric); }
export function fitted(metric: string, value: number, halfWidth: number): string {
  return noOrder(metric, value, halfWidth) || `${figure(value, 4)} \u00b1 ${figure(halfWidth, 2)}`;
}
// Why a fit gives no order: an interval wider than +- 0.2 does not distinguish neighbouring orders, and an error that does
// not change has none. An error that grows as h decreases has a negative order, which is shown. Empty: the fit is valid.
export function noOrder(metric: string, value: number, halfWidth: number): string {
  if (Number.isNaN(value)) return 'inconclusive';
  if (!/^(order|richardson-order)/.test(metric)) return '';
  if (halfWidth > 0.2) return `inconclusive (\u00b1 ${figure(halfWidth, 2)})`;
  return Math.abs(value) < 0.25 ? 'inconclusive (no convergence)' : '';
}

// The ladder of an adaptive method is its tolerance: one family, many ids.
export function family(method: string): string { return method.replace(/:[^+@{]*/, ':tol'); }
export function rungWords(method: string, steps: number): string {
  const found = /:([^+@{]*)/.exec(method);
  return found ? `tol ${found[1]}` : `${steps} steps`;
}
// "640 steps, dx 0.02, c 10" of fluids.
export function placeWords(reached: Reached): string {
  const at = (name: string, value?: Loose) => (value === undefined ? '' : `, ${name} ${figure(real(value), 4)}`);
  return rungWords(reached.method, reached.steps) + at('dx', reached.spacing_m) + at('c', reached.sound_speed_m_per_s);
}
export function seconds(value: number): string {
  if (!Number.isFinite(value)) return '\u2013';
  const [scale, unit] = value < 1e-6 ? [1e9, 'ns'] : value < 1e-3 ? [1e6, '\u00b5s'] : value < 1 ? [1e3, 'ms'] : [1, 's'];
  return `${figure(Number((value * scale).toPrecision(3)), 3)} ${unit}`;
}
export function unitWord(unit: string): string { return unit === '1' ? '' : unit; }
// After a heading: ' [m]'; nothing where there is no unit.
export function inBrackets(unit: string): string { return unitWord(unit) ? ` [${unitWord(unit)}]` : ''; }
export function isAdaptive(method: string): boolean { return /:[^+@{]/.test(method); }
export function engineOf(method: string): string { return method.split('/')[0]; }

export function shellWord(text: string): string {
  return /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replace(/'/g, `'\\''`)}'`;
}
const ownFiles = new Map<string, string>();  // scenes that are not in the catalogue are rerun by their file
let program = 'atwood';                      // as it was called, quoted
export function commandLine(words: string): string { return `${program} ${words}`; }
export function rerunCommand(scenario: string, method: string, steps: number): string {
  const at = steps > 0 ? ` --steps ${steps}` : '';
  return commandLine(`run --scenario ${shellWord(ownFiles.get(scenario) ?? scenario)} --method ${shellWord(method)}${at}`);
}
