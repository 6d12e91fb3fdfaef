// The state of the page in the fragment of its address: scene, metric, methods, zoom, filters, sortings, what is unfolded. A
// link shows the same page.
export type Changes = Record<string, string | null | undefined>;

export function current(): URLSearchParams {
  const fragment = location.hash.slice(1);
  return new URLSearchParams(fragment.includes('=') ? fragment : '');
}

let silent = true;  // while the page is built or follows a link, it writes no address of its own
export function following(apply: () => void): void {
  silent = true;
  try { apply(); } finally { silent = false; }
}

export function put(changes: Changes): void {
  if (silent) return;
  const state = current();
  for (const [key, value] of Object.entries(changes)) {
    if (value === null || value === undefined || value === '') state.delete(key);
    else state.set(key, value);
  }
  const words = state.toString();
  history.replaceState(null, '', words ? `#${words}` : location.pathname + location.search);
}

// Selects whose choices stand in the address under their ids. Those whose options depend on others come after them.
const linked: { selects: HTMLSelectElement[]; initial: string[] }[] = [];
export function linkSelects(...selects: HTMLSelectElement[]): void {
  linked.push({ selects, initial: selects.map((select) => select.value) });
  const tell = () => put(Object.fromEntries(selects.map((select) => [select.id, select.value])));
  for (const select of selects) select.addEventListener('change', tell);
}
export function choose(select: HTMLSelectElement, value: string): void {
  select.value = value;
  select.dispatchEvent(new Event('change'));
}
// A choice that a link does not name, or that there is not, is the one in which the page opens, or to which the choice
// before it leads.
export function applySelects(state: URLSearchParams): void {
  for (const { selects, initial } of linked) {
    const asked = selects.map((select) => state.get(select.id));
    selects.forEach((select, i) => {
      const known = [...select.options].some((one) => one.value === asked[i]);
      const value = known ? asked[i]! : i === 0 ? initial[0] : select.value;
      if (value !== select.value || asked.slice(i + 1).includes(null)) choose(select, value);
    });
  }
}

// What a reader has unfolded or folded, by section and place in it.
const flipped = new WeakSet<HTMLDetailsElement>();
const foldable = () => [...document.querySelectorAll<HTMLDetailsElement>('#app details')];
function foldName(details: HTMLDetailsElement): string {
  const part = details.closest('section')!;
  return `${part.id}.${[...part.querySelectorAll('details')].indexOf(details)}`;
}
export const folds = (): string => foldable().filter((details) => flipped.has(details)).map(foldName).join(' ');
function flip(details: HTMLDetailsElement): void {
  if (flipped.has(details)) flipped.delete(details);
  else flipped.add(details);
}
export function applyFolds(state: URLSearchParams): void {
  const wanted = new Set(state.get('fold')?.split(' ') ?? []);
  for (const details of foldable()) {
    if (wanted.has(foldName(details)) === flipped.has(details)) continue;
    flip(details);
    details.open = !details.open;
  }
}

// Links to a section keep the rest of the state.
export function watch(apply: (state: URLSearchParams) => void): void {
  document.addEventListener('click', (event) => {
    const fold = (event.target as Element).closest?.('#app summary')?.parentElement;
    if (fold instanceof HTMLDetailsElement) {
      flip(fold);
      put({ fold: folds() });
    }
    const link = (event.target as Element).closest?.('a[href^="#"]');
    const name = link?.getAttribute('href')?.slice(1) ?? '';
    const target = name && !name.includes('=') ? document.getElementById(name) : null;
    if (!target) return;
    event.preventDefault();
    put({ at: name });
    show(target);
  });
  addEventListener('hashchange', () => apply(current()));
  const plain = location.hash.slice(1);
  apply(current());
  if (plain && !plain.includes('=')) show(document.getElementById(plain));
}

export function show(target: HTMLElement | null): void {
  if (!target) return;
  const details = target.querySelector('details');
  if (details && target.querySelectorAll('details').length === 1) details.open = true;
  target.scrollIntoView({ behavior: matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth' });
  if (!target.hasAttribute('tabindex')) target.tabIndex = -1;
  target.focus({ preventScroll: true });
}
