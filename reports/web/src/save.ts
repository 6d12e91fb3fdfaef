// Files to save: tables as CSV, plots as SVG and PNG, and how to cite the report.
import { Report } from './data';
import { copyButton, h } from './dom';

export function download(name: string, content: Blob): void {
  const link = h('a', { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
export const fileName = (words: string) => words.toLowerCase().replace(/[^a-z0-9.]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 80) || 'atwood';

// RFC 4180. A text that a spreadsheet would take for a formula begins with an apostrophe.
export function csvField(text: string): string {
  const plain = /^[=@\t]|^[+-](?![\d.])/.test(text) ? `'${text}` : text;
  return /[",\r\n]/.test(plain) ? `"${plain.replace(/"/g, '""')}"` : plain;
}
export function csv(lines: string[][]): Blob { return new Blob([lines.map((line) => line.map(csvField).join(',')).join('\r\n'), '\r\n'], { type: 'text/csv' }); }

// What a cell shows, without its buttons for copying.
function cellText(cell: Element): string {
  const copy = cell.cloneNode(true) as Element;
  copy.querySelectorAll('button.copy').forEach((button) => button.remove());
  copy.querySelectorAll('br, .behind').forEach((part) => part.before(' '));
  return copy.textContent!.replace(/\s+/g, ' ').trim();
}
// Tables that hold only the rows in view have their own lines.
export const ownLines = new WeakMap<Element, () => string[][]>();

function equip(table: HTMLElement): void {
  const region = table.closest<HTMLElement>('.scroll') ?? table;
  if (region.dataset.saves) return;
  region.dataset.saves = 'true';
  const label = region.getAttribute('aria-label') ?? table.querySelector('caption')?.textContent ?? 'table';
  if (!table.querySelector('caption')) table.setAttribute('aria-label', label);
  region.before(h('div', { class: 'save' }, h('button', { type: 'button', 'aria-label': `Save as CSV: ${label}`, onclick: () => {
    const lines = ownLines.get(region)?.() ?? [...region.querySelectorAll('tr')].map((row) => [...row.children].map(cellText));
    download(`${fileName(table.dataset.file ?? label)}.csv`, csv(lines));
  } }, 'CSV')));
}
// Every table below `root`, also those that are drawn later.
export function equipTables(root: HTMLElement): void {
  const all = () => root.querySelectorAll<HTMLElement>('table').forEach(equip);
  all();
  new MutationObserver(all).observe(root, { childList: true, subtree: true });
}

export function saveSvg(name: string, element: SVGElement): void { download(`${fileName(name)}.svg`, new Blob([new XMLSerializer().serializeToString(element)], { type: 'image/svg+xml' })); }
export async function savePng(name: string, element: SVGElement, scale = 2): Promise<void> {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(element))}`;
  await image.decode();
  const canvas = h('canvas', { width: Number(element.getAttribute('width')) * scale, height: Number(element.getAttribute('height')) * scale });
  canvas.getContext('2d')!.drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => { if (blob) download(`${fileName(name)}.png`, blob); }, 'image/png');
}
// The two buttons of a plot. What is saved, an SVG document of its own, is drawn when one is pressed.
export function savePlotButtons(what: string, name: () => string, drawn: () => SVGElement): HTMLElement[] {
  return ['SVG', 'PNG'].map((kind) => h('button', { type: 'button', class: 'save-plot', 'data-save': kind, 'aria-label': `Save ${what} as ${kind}`, onclick: () => {
    if (kind === 'SVG') saveSvg(name(), drawn());
    else void savePng(name(), drawn());
  } }, kind));
}

const escaped = (text: string) => text.replace(/[\\{}$&#^_%~]/g, (c) => ({ '\\': '\\textbackslash{}', '^': '\\^{}', '~': '\\~{}' })[c] ?? `\\${c}`);
export function bibtex(report: Report): string {
  const { engine_version: version, commit, run_id: run } = report.provenance;
  const year = /(20\d\d)/.exec(run ?? '')?.[1];
  const lines = [['title', `{${escaped(report.title)}}`], ['howpublished', 'Report of Atwood, verification and benchmarks of the numerical accuracy of physics engines'],
    ...(year ? [['year', year]] : []), ['note', escaped([version && `version ${version}`, commit && `commit ${commit}`, run && `run ${run}`].filter(Boolean).join(', '))]];
  return `@misc{atwood-report,\n${lines.map(([key, value]) => `  ${key.padEnd(12)} = {${value}}`).join(',\n')}\n}`;
}
export function citeButton(report: Report): HTMLElement {
  const block = [report.title, ...Object.entries(report.provenance).filter(([, value]) => value).map(([name, value]) => `${name}: ${value}`), ...report.engines.map((e) => `${e.name}: ${e.version} ${e.scalar}`), `command: ${report.command}`].join('\n');
  const part = (title: string, text: string) => [h('h3', {}, title), h('pre', {}, text), copyButton(text)];
  const dialog = h('dialog', { id: 'cite', 'aria-label': 'Cite this report' }, ...part('BibTeX', bibtex(report)), ...part('Provenance', block), h('p', {}, h('button', { type: 'button', onclick: () => dialog.close() }, 'close')));
  document.body.append(dialog);
  return h('button', { type: 'button', id: 'cite-button', onclick: () => dialog.showModal() }, 'cite');
}
