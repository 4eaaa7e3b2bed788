// The frame of a report: title, switch of the theme, sections with their list of links.
import { append, details, h, terms, type Child } from './dom';
import { chooseTheme, keptTheme, THEMES } from '../../../../server/dashboard/src/theme';

export interface Section { id: string; heading: string; body: Child[] }
export interface Page { title: string; lead: Child[]; sections: Section[] }
export interface Machine {
  date: string; program: string; cpu: string; cores: number; system: string; compiler: string; simd: string;
  libraries: Record<string, string>; absent_peers?: string[];
}

export function themeSwitch(): HTMLElement {
  const kept = keptTheme();
  const choices = THEMES.map((theme) => {
    const input = h('input', { type: 'radio', name: 'theme', value: theme });
    input.checked = theme === kept;
    input.addEventListener('change', () => chooseTheme(theme));
    return h('label', {}, input, h('span', {}, theme[0]!.toUpperCase() + theme.slice(1)));
  });
  return h('fieldset', { class: 'theme' }, h('legend', {}, 'Theme'), ...choices);
}

// Sections without a body are left out. `prefix` keeps the ids of several documents apart.
export function drawPage({ title, lead, sections }: Page, prefix: string, aside: Child): HTMLElement {
  const filled = sections.filter(({ body }) => body.flat(9).some(Boolean));
  const links = filled.map(({ id, heading }) => h('li', {}, h('a', { href: `#${prefix}${id}` }, heading)));
  const article = h('article', {},
    h('header', {}, h('div', { class: 'title' }, h('h1', {}, title), aside), ...lead,
      h('nav', { 'aria-label': 'Sections' }, h('ol', {}, ...links))));
  for (const { id, heading, body } of filled) {
    const section = h('section', { id }, h('h2', {}, heading));
    append(section, body);
    article.append(section);
  }
  for (const element of article.querySelectorAll('[id]')) element.id = prefix + element.id;
  return article;
}

export function machineList(machine: Machine, more: [string, string][] = []): HTMLElement {
  return terms([['Processor', machine.cpu], ['Hardware threads', String(machine.cores)], ['System', machine.system],
    ['Compiler', machine.compiler], ['Vector instructions', machine.simd], ['Sweepstake', machine.program],
    ...Object.entries(machine.libraries), ...more]);
}

export const commandLine = (line: string) => h('pre', {}, h('code', {}, line));

function csvOf(rows: object[]): string {
  const names = [...new Set(rows.flatMap(Object.keys))];
  const field = (value: unknown) => {
    const content = value === undefined || value === null ? ''
      : typeof value === 'object' ? JSON.stringify(value) : String(value);
    return /[",\r\n]/.test(content) ? `"${content.replaceAll('"', '""')}"` : content;
  };
  const lines = [names, ...rows.map((row) => names.map((name) => (row as Record<string, unknown>)[name]))];
  return lines.map((line) => line.map(field).join(',')).join('\r\n') + '\r\n';
}

// Without clipboard permission, copies through a text selection.
async function copy(content: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(content);
    return true;
  } catch {
    const box = h('textarea');
    box.value = content;
    document.body.append(box);
    box.select();
    const done = document.execCommand('copy');
    box.remove();
    return done;
  }
}

// Buttons that copy the whole document as JSON and its rows as CSV, then the rows themselves.
export function rawRows(document: { rows: object[] }, table: Child): Child[] {
  const said = h('span', { class: 'soft', role: 'status' });
  const button = (name: string, content: () => string) => {
    const element = h('button', { type: 'button' }, name);
    element.addEventListener('click', async () => {
      said.textContent = (await copy(content())) ? 'Copied.' : 'This browser refuses to copy.';
    });
    return element;
  };
  return [
    h('p', {}, button('Copy all as JSON', () => JSON.stringify(document, null, 2)), button('Copy rows as CSV', () => csvOf(document.rows)), said),
    table && details('Show all rows', table)];
}
