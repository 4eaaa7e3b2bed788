// Tables whose columns can be sorted, within each group of rows, by a click or by the keyboard.
import { h, type Child } from './dom';

export interface Cell {
  content: Child;
  value?: number | string; // sort key of the cell; if absent, its text is the key
  className?: string;
}
export interface HeadCell { content: Child; className?: string; span?: number }
export interface Group { title?: string; rows: Cell[][] }
export interface TableSpec { id: string; caption: string; head: HeadCell[][]; groups: Group[] }

export const cell = (content: Child, value?: number | string, className?: string): Cell =>
  ({ content, ...(value !== undefined && { value }), ...(className && { className }) });
export const textCell = (content: Child, className = 'text'): Cell => ({ content, className });
export const noValue = (): Cell => ({ content: '–', value: Number.POSITIVE_INFINITY, className: 'none' });
export const columns = (...names: (string | HeadCell)[]): HeadCell[] =>
  names.map((name) => (typeof name === 'string' ? { content: name } : name));
export const text = (content: string): HeadCell => ({ content, className: 'text' });

function sortValue(row: HTMLTableRowElement, column: number): number | string {
  const { dataset, textContent } = row.cells[column]!;
  const value = dataset.value ?? textContent ?? '';
  const number = Number.parseFloat(value.replace(/^[+]|,/g, '').replace('−', '-'));
  return Number.isNaN(number) ? value : number;
}

function compare(a: number | string, b: number | string): number {
  if (typeof a === 'number' && typeof b === 'number') return a - b;
  return String(a).localeCompare(String(b), 'en', { numeric: true });
}

function sortBy(table: HTMLTableElement, column: number, header: HTMLElement): void {
  const ascending = header.getAttribute('aria-sort') !== 'ascending';
  for (const other of table.querySelectorAll('[aria-sort]')) other.removeAttribute('aria-sort');
  header.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
  for (const body of table.tBodies) {
    const rows = [...body.rows].filter((row) => !row.classList.contains('heading'));
    rows.sort((a, b) => (ascending ? 1 : -1) * compare(sortValue(a, column), sortValue(b, column)));
    body.append(...rows);
  }
}

function headRow(cells: HeadCell[], sortable: boolean): HTMLTableRowElement {
  return h('tr', {}, ...cells.map(({ content, className = '', span = 1 }) => h('th',
    { scope: span > 1 ? 'colgroup' : 'col', class: className, colspan: span > 1 ? String(span) : '' },
    sortable && content ? h('button', { type: 'button', class: 'sort' }, content) : content)));
}

function bodyRow(cells: Cell[]): HTMLTableRowElement {
  return h('tr', {}, ...cells.map(({ content, value, className = '' }, index) => {
    const attributes = { class: className, 'data-value': value === undefined ? '' : String(value) };
    return index === 0 ? h('th', { ...attributes, scope: 'row' }, content) : h('td', attributes, content);
  }));
}

export function drawTable({ id, caption, head, groups }: TableSpec): HTMLElement {
  const table = h('table', { id }, h('caption', {}, h('span', {}, caption)));
  const rows = head.map((cells, index) => headRow(cells, index === head.length - 1));
  table.append(h('thead', {}, ...rows));
  const width = head.at(-1)!.length;
  for (const { title, rows } of groups) {
    table.append(h('tbody', {},
      title && h('tr', { class: 'heading' }, h('th', { class: 'group', scope: 'rowgroup', colspan: String(width) }, h('span', {}, title))),
      ...rows.map(bodyRow)));
  }
  rows.at(-1)!.querySelectorAll('th').forEach((header, column) =>
    header.querySelector('button')?.addEventListener('click', () => sortBy(table, column, header)));
  return h('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption }, table);
}
