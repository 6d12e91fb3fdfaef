// Queries of the rows: the metrics of a scenario, the ladder of a method, the figure of a cell.
import { Report, Rows, real } from './data';

export interface Cell { row: number; steps: number; h: number; value: number; bar: number }

export class RowIndex {
  private byScenario = new Map<number, number[]>();
  private ids = new Map<string, number>();
  readonly rows: Rows;
  readonly count: number;

  constructor(readonly report: Report) {
    this.rows = report.rows;
    this.count = this.rows.value.length;
    report.strings.forEach((text, i) => this.ids.set(text, i));
    for (let i = 0; i < this.count; i += 1) {
      const list = this.byScenario.get(this.rows.scenario[i]);
      if (list) list.push(i);
      else this.byScenario.set(this.rows.scenario[i], [i]);
    }
  }
  text(column: number): string { return this.report.strings[column]; }
  of(scenario: string): number[] { return this.byScenario.get(this.ids.get(scenario) ?? -1) ?? []; }

  // Names in the order of the rows.
  names(column: 'scenario' | 'method' | 'metric' | 'status' | 'body', within?: number[]): string[] {
    const seen = new Set<number>();
    if (within) for (const i of within) seen.add(this.rows[column][i]);
    else for (let i = 0; i < this.count; i += 1) seen.add(this.rows[column][i]);
    return [...seen].map((id) => this.report.strings[id]);
  }

  // Whole-run figures of one metric, method by method, by step count. `body` "" is the whole run; where a metric has
  // only figures of single bodies, the largest of them is that of the run unless a body is chosen.
  ladders(scenario: string, metric: string, body: string): Map<string, Cell[]> {
    const { rows } = this;
    const metricId = this.ids.get(metric) ?? -1;
    const whole = this.ids.get('') ?? -1;
    const bodyId = this.ids.get(body) ?? -1;
    const found = new Map<string, Map<number, Cell & { whole: boolean }>>();
    for (const i of this.of(scenario)) {
      if (rows.metric[i] !== metricId || rows.t_s[i] !== null || this.text(rows.status[i]) !== 'ok') continue;
      const isWhole = rows.body[i] === whole;
      if (body !== '' && rows.body[i] !== bodyId) continue;
      const method = this.text(rows.method[i]);
      if (!found.has(method)) found.set(method, new Map());
      const cells = found.get(method)!;
      const value = real(rows.value[i]);
      const before = cells.get(rows.steps[i]);
      const better = !before || (!before.whole && (isWhole || value > before.value));
      if (better) cells.set(rows.steps[i], { row: i, steps: rows.steps[i], h: real(rows.h_s[i]), value, bar: real(rows.truth_bar[i]), whole: isWhole });
    }
    const out = new Map<string, Cell[]>();
    for (const [method, cells] of found) out.set(method, [...cells.values()].sort((a, b) => a.steps - b.steps));
    return out;
  }

  // A scene with contacts is recognised by its metrics: penetration, impact times.
  hasContacts(scenario: string): boolean { return this.names('metric', this.of(scenario)).some((name) => /^(penetration-|impact-)/.test(name)); }

  // Why a cell has no figure: the first status that is not ok.
  trouble(scenario: string, method: string): { status: string; reason: string } | null {
    const methodId = this.ids.get(method) ?? -1;
    for (const i of this.of(scenario)) {
      if (this.rows.method[i] === methodId && this.text(this.rows.status[i]) !== 'ok') {
        return { status: this.text(this.rows.status[i]), reason: this.text(this.rows.reason[i]) };
      }
    }
    return null;
  }
}

// The scenario that most methods ran, which is shown first.
export function richest(index: RowIndex, ids: string[]): string {
  const methods = new Map(ids.map((id) => [id, index.names('method', index.of(id)).length]));
  return ids.reduce((best, id) => (methods.get(id)! > methods.get(best)! ? id : best), ids[0]);
}
