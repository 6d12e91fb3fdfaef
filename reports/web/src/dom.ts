// Creates elements. Children are nodes or strings, and strings become text nodes: nothing is parsed as HTML.
export type Child = Node | string | null | undefined | false;
type Properties = Record<string, unknown>;

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, properties: Properties = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value as EventListener);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  for (const child of children) if (child) element.append(child);
  return element;
}

export function svg(tag: string, attributes: Record<string, string | number>, ...children: Node[]): SVGElement {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

export function option(value: string, label: string, selected = false): HTMLOptionElement {
  return h('option', { value, selected }, label);
}

// A select with its label. `changed` gets the chosen value.
export function labelledSelect(label: string, id: string, changed: (value: string) => void): {
  box: HTMLElement; select: HTMLSelectElement } {
  const select = h('select', { id });
  select.addEventListener('change', () => changed(select.value));
  return { box: h('label', { class: 'field', for: id }, h('span', {}, label), select), select };
}

export function copyButton(command: string): HTMLElement {
  const button = h('button', { type: 'button', class: 'copy', title: `Copy: ${command}`, 'aria-label': `Copy: ${command}` }, 'copy');
  button.addEventListener('click', async (event) => {
    event.stopPropagation();
    const done = await copyText(command);
    button.textContent = done ? 'copied' : 'press Ctrl+C';
    setTimeout(() => { button.textContent = 'copy'; }, 1500);
  });
  return button;
}

// A page opened from disk may have no clipboard API; then the text is copied from a text area.
async function copyText(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = h('textarea', { style: 'position:fixed;opacity:0', readonly: true });
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand('copy');
    area.remove();
    return done;
  }
}

export function section(id: string, title: string, ...children: Child[]): HTMLElement {
  return h('section', { id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), ...children);
}
