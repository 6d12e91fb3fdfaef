// On paper every scene has a page of its own: claim, picture, the plot of the metric that it is about, gates, winners.
import { Report, figure, real } from './data';
import { chartSvg } from './chart_svg';
import { Child, h } from './dom';
import { arrange } from './drawing';
import { ladderPlots, openingMethods } from './ladder_plots';
import { RowIndex } from './rows';
import { sceneMetric, titleOf } from './scene_metric';
import { still, winners } from './scenes';
import { gatesTable } from './sections';
import { metricWords } from './story';
import { look } from './style';

const mostGates = 8, mostBesideWinners = 3;  // rows of the table of those that did not pass

function plot(index: RowIndex, id: string, metric: string, height: number): Child {
  const looks = new Map(openingMethods(index, id, metric).map((name, i) => [name, look(i)]));
  const { time, step, evaluations } = ladderPlots(index, id, metric, '', looks);
  const spec = [time, step, evaluations].find((one) => one.curves.length);
  return spec ? chartSvg(arrange(spec, new Set()), 720, height) : h('p', { class: 'nothing' }, step.empty);
}

function gates(report: Report, id: string, most: number): Child {
  const all = report.verdicts.filter((v) => v.scenario === id), bad = all.filter((v) => v.judgement !== 'pass');
  if (!all.length) return null;
  return h('div', {}, h('p', {}, h('b', {}, 'Gates'), `: ${all.length - bad.length} of ${all.length} pass.${bad.length > most ? ` The first ${most} of the others:` : ''}`),
    bad.length ? gatesTable(bad.slice(0, most), `Gates of ${id} that did not pass`) : null);
}

function sheet(report: Report, index: RowIndex, id: string): HTMLElement {
  const scenario = report.scenarios.find((s) => s.id === id), metric = sceneMetric(report, index, id), cheapest = winners(report, id);
  return h('article', { class: 'sheet', 'aria-label': id }, h('h3', {}, titleOf(report, id), h('span', { class: 'soft' }, ` ${id}`)),
    h('div', { class: 'sheet-head' }, still(report, id, 300, 190), h('div', {}, scenario ? h('p', {}, scenario.claim) : null,
      h('p', { class: 'soft' }, `Shown: ${metricWords(metric)}. `, scenario ? `Truth: ${scenario.truth}; ${figure(real(scenario.t_end_s))} s, ${scenario.samples} samples. Source: ${scenario.source}` : null))),
    plot(index, id, metric, cheapest && report.verdicts.some((v) => v.scenario === id && v.judgement !== 'pass') ? 240 : 330), gates(report, id, cheapest ? mostBesideWinners : mostGates), cheapest);
}

export function sheets(report: Report, index: RowIndex, ids: string[]): HTMLElement {
  return h('section', { id: 'sheets', 'aria-labelledby': 'sheets-title' }, h('h2', { id: 'sheets-title' }, 'Scene by scene'), ...ids.map((id) => sheet(report, index, id)));
}
