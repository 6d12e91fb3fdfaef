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

// What is chosen for one scene; another scene opens without it.
export const ofScene = ['metric', 'body', 'steps', 'shown', 'zoom', 't', 'without', 'magnify'];

// Selects whose choices stand in the address under their ids. The options of all others depend on the first.
const linked: { selects: HTMLSelectElement[]; initial: string }[] = [];
export function linkSelects(...selects: HTMLSelectElement[]): void {
  linked.push({ selects, initial: selects[0].value });
  const tell = () => put(Object.fromEntries(selects.map((select) => [select.id, select.value])));
  for (const select of selects) select.addEventListener('change', tell);
}
export function choose(select: HTMLSelectElement, value: string): void {
  select.value = value;
  select.dispatchEvent(new Event('change'));
}
// A choice that a link does not name, or that there is not, is the one in which the page opens, or to which the first
// choice leads, whatever was chosen before.
export function applySelects(state: URLSearchParams): void {
  for (const { selects, initial } of linked) {
    const asked = selects.map((select) => state.get(select.id));
    selects.forEach((select, i) => {
      const known = [...select.options].some((one) => one.value === asked[i]);
      const value = known ? asked[i]! : i === 0 ? initial : select.value;
      const others = i === 0 ? selects.slice(1) : [];
      others.forEach((other) => { other.selectedIndex = -1; });
      if (value !== select.value || others.length) choose(select, value);
    });
  }
}

// What is not as it opened, unfolded or folded, by section and place in it.
const openings = new WeakMap<HTMLDetailsElement, boolean>();
function opening(details: HTMLDetailsElement): boolean {
  if (!openings.has(details)) openings.set(details, details.open);
  return openings.get(details)!;
}
const foldable = () => [...document.querySelectorAll<HTMLDetailsElement>('#app details')];
function foldName(details: HTMLDetailsElement): string {
  const part = details.closest('section')!;
  return `${part.id}.${[...part.querySelectorAll('details')].indexOf(details)}`;
}
// `clicked` is about to change.
export function folds(clicked?: HTMLDetailsElement): string {
  return foldable().filter((details) => opening(details) !== (details === clicked ? !details.open : details.open)).map(foldName).join(' ');
}
export function applyFolds(state: URLSearchParams): void {
  const wanted = new Set(state.get('fold')?.split(' ') ?? []);
  for (const details of foldable()) details.open = opening(details) !== wanted.has(foldName(details));
}

// A link inside the page changes what it names and, where it opens a scene, what belonged to the scene before; the rest stays.
function linkedState(name: string): string {
  const state = current(), fold = state.get('fold')?.split(' ').filter((one) => !one.startsWith('plots.')).join(' ');
  for (const key of [...ofScene, 'at', 'fold']) state.delete(key);
  if (fold) state.set('fold', fold);
  for (const [key, value] of new URLSearchParams(name)) {
    if (value) state.set(key, value);
    else state.delete(key);
  }
  return state.toString();
}

export function watch(apply: (state: URLSearchParams) => void): void {
  document.addEventListener('click', (event) => {
    const fold = (event.target as Element).closest?.('#app summary')?.parentElement;
    if (fold instanceof HTMLDetailsElement) put({ fold: folds(fold) });
    const link = (event.target as Element).closest?.('a[href^="#"]');
    const name = link?.getAttribute('href')?.slice(1) ?? '';
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;  // another tab or window
    if (name.includes('=')) {
      event.preventDefault();
      history.pushState(null, '', `#${linkedState(name)}`);
      apply(current());
      return;
    }
    const target = name ? document.getElementById(name) : null;
    if (!target) return;
    event.preventDefault();
    show(target);
    put({ at: name, fold: folds() });
  });
  addEventListener('hashchange', () => apply(current()));
  foldable().forEach(opening);
  const plain = location.hash.slice(1);
  apply(current());
  if (plain && !plain.includes('=')) show(document.getElementById(plain));
}

export function show(target: HTMLElement | null): void {
  if (!target) return;
  const details = target.querySelector('details');
  if (details && target.querySelectorAll('details').length === 1) {
    opening(details);
    details.open = true;
  }
  target.scrollIntoView({ behavior: matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth' });
  if (!target.hasAttribute('tabindex')) target.tabIndex = -1;
  target.focus({ preventScroll: true });
}
