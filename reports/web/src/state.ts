// The state of the page in the fragment of its address: scene, metric, methods, zoom, filters. A link shows the same page.
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

// Links to a section keep the rest of the state.
export function watch(apply: (state: URLSearchParams) => void): void {
  document.addEventListener('click', (event) => {
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
