// Creates DOM elements. Text is never parsed as markup.
export type Child = Node | string | null | undefined | false | Child[];

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Record<string, string | undefined> = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== '') element.setAttribute(name, value);
  }
  append(element, children);
  return element;
}

export function append(parent: Node, children: Child[]): void {
  for (const child of children) {
    if (Array.isArray(child)) append(parent, child);
    else if (child) parent.appendChild(typeof child === 'string' ? document.createTextNode(child) : child);
  }
}

export const paragraph = (...children: Child[]) => h('p', {}, ...children);
export const small = (...children: Child[]) => h('small', {}, ...children);
export const bold = (...children: Child[]) => h('b', {}, ...children);
export const list = (items: Child[]) => h('ul', {}, ...items.filter(Boolean).map((item) => h('li', {}, item)));

export function terms(entries: [string, string][]): HTMLElement {
  return h('dl', {}, ...entries.map(([term, meaning]) => [h('dt', {}, term), h('dd', {}, meaning)]));
}

export function details(summary: string, ...children: Child[]): HTMLElement {
  return h('details', {}, h('summary', {}, summary), ...children);
}

export const headline = (figure: string, sentence: string) =>
  h('p', { class: 'headline' }, h('b', {}, figure), h('span', {}, sentence));

export const verdict = (good: boolean, text: string) =>
  h('span', { class: `verdict ${good ? 'met' : 'missed'}` }, `${good ? '✓' : '✗'} ${text}`);
