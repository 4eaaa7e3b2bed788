// The frame of a report: its title, its sections, and a list of links to them.
import { append, h, terms, type Child } from './dom';

export interface Section { id: string; heading: string; body: Child[] }
export interface Page { title: string; lead: Child[]; sections: Section[] }
export interface Machine {
  date: string; program: string; cpu: string; cores: number; system: string; compiler: string; simd: string;
  libraries: Record<string, string>; absent_peers?: string[];
}

// Sections without a body are left out. `prefix` keeps the ids of several documents apart.
export function drawPage({ title, lead, sections }: Page, prefix: string): HTMLElement {
  const filled = sections.filter(({ body }) => body.flat(9).some(Boolean));
  const links = filled.map(({ id, heading }) => h('li', {}, h('a', { href: `#${prefix}${id}` }, heading)));
  const article = h('article', {},
    h('header', {}, h('h1', {}, title), ...lead,
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
