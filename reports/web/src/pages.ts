// The pages of the history (index.html, trends): the program writes tables and plots, this adds the buttons that save them.
import { h } from './dom';
import { equipTables, savePlotButtons } from './save';
import { standaloneSvg } from './standalone';

function equipPlot(figure: HTMLElement): void {
  const plot = figure.querySelector('svg'), title = figure.querySelector('figcaption')?.textContent ?? document.title;
  if (plot) figure.append(h('div', { class: 'save' }, ...savePlotButtons(title, () => title, () => standaloneSvg(plot, title))));
}

addEventListener('DOMContentLoaded', () => {
  equipTables(document.body);
  document.querySelectorAll<HTMLElement>('figure').forEach(equipPlot);
});
