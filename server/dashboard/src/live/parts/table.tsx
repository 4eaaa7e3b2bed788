// A table of any number of rows. Its sorting and its columns are in the URL. It draws only visible rows, and a row again only if the row
// has changed. It keeps the order of rows while the user is in the table, and can have a link to its values as CSV.
import type { ComponentChildren, VNode } from 'preact';
import { useLayoutEffect, useMemo, useRef, useState } from 'preact/hooks';
import { ColumnChoice, useColumns } from './column_choice';
import { CsvLink } from './download';
import { route, setQuery } from '../state/route';
import { grouped } from '../../format';
import { fileName, Name } from './name';
import { RowOrder, sortedBy, type PlacedRow, type SortValue } from './row_order';

const ROW_PX = 33;  // height of a row; equal to --row in style.css
const ALL_UP_TO = 80;  // tables up to this number of rows are drawn whole
const OVERSCAN = 10;  // rows drawn above and below the visible ones

export interface Column<Row> {
  id: string;
  title: string;
  cell?(row: Row): ComponentChildren;  // absent: the value of `sort`, as a name or a count
  sort?(row: Row): SortValue;  // absent: the table cannot be sorted by this column
  isText?: boolean;  // aligned to the left, as the first column always is
  hint?: string;  // explains the column
  isDetail?: boolean;  // hidden until the user chooses it
  width?: string;  // minimum width of a column whose values change often, so that other columns do not move
}

export interface TableProps<Row> {
  caption: string;  // names the rows, such as "Scenes"
  columns: readonly Column<Row>[];  // the first column identifies the row; another array draws all rows again
  rows: readonly Row[];
  keyOf(row: Row): string;
  sort: string;  // the column that the table is sorted by at first; "-" before it for descending, as in the URL
  sortParameter?: string;  // name of the sorting in the URL, if a view has several tables
  tools?: ComponentChildren;
  csvHref?: string | undefined;  // the URL of the whole table as CSV; absent: the daemon has no such table
  isBare?: boolean;  // without the line of tools
}

function Heading<Row>({ column, sorting, onSort }: { column: Column<Row>; sorting: string; onSort(sorting: string): void }) {
  const order = sorting === column.id ? 'ascending' : sorting === `-${column.id}` ? 'descending' : undefined;
  const next = order === 'ascending' ? `-${column.id}` : column.id;
  return (
    <th scope="col" class={column.isText ? 'text' : undefined} style={column.width && { minWidth: column.width }} title={column.hint} aria-sort={order}>
      {column.sort ? <button type="button" class="sort" onClick={() => onSort(next)}>{column.title}</button> : column.title}
    </th>
  );
}

function cellOf<Row>({ cell, sort }: Column<Row>, row: Row): ComponentChildren {
  if (cell) return cell(row);
  const value = sort?.(row);
  return typeof value === 'string' ? <Name text={value} /> : value === undefined ? '–' : grouped(value);
}

interface LineProps<Row> { id: string; row: Row; isGone: boolean; columns: readonly Column<Row>[]; index: number }

function Line<Row>({ id, row, isGone, columns, index }: LineProps<Row>) {
  const [first, ...others] = columns;
  return (
    <tr aria-rowindex={index + 2} class={isGone ? 'gone' : undefined} data-key={id} tabIndex={-1}>
      <th scope="row">{cellOf(first!, row)}</th>
      {others.map((column) => <td key={column.id} class={column.isText ? 'text' : undefined}>{cellOf(column, row)}</td>)}
    </tr>
  );
}

const isSameLine = <Row,>({ props: a }: VNode<LineProps<Row>>, { props: b }: VNode<LineProps<Row>>) =>
  a.row === b.row && a.isGone === b.isGone && a.columns === b.columns && a.index === b.index;

// Returns the lines of the rows, of which the first is number `from`. An unchanged row keeps its line, which Preact then skips. Signals that
// a cell reads still redraw its row.
function useLines<Row>(placed: readonly PlacedRow<Row>[], from: number, columns: readonly Column<Row>[]): VNode<LineProps<Row>>[] {
  const before = useRef(new Map<string, VNode<LineProps<Row>>>());
  const lines = placed.map(({ key, row, isGone }, i) => {
    const line = <Line<Row> key={key} id={key} row={row} isGone={isGone} columns={columns} index={from + i} /> as VNode<LineProps<Row>>;
    const kept = before.current.get(key);
    return kept && isSameLine(kept, line) ? kept : line;
  });
  before.current = new Map(lines.map((line) => [line.props.id, line]));
  return lines;
}

const Gap = ({ rows, columns }: { rows: number; columns: number }) =>
  (rows > 0 ? <tr class="gap" aria-hidden="true"><td colSpan={columns} style={{ height: rows * ROW_PX }} /></tr> : null);

// Moves the focus with the arrow keys from row to row, to the row's link or button.
function moveFocus(event: KeyboardEvent, box: HTMLElement, count: number): void {
  const row = (event.target as Element).closest('tbody tr[data-key]');
  if (!row || event.ctrlKey || event.metaKey || event.altKey) return;
  const at = Number(row.getAttribute('aria-rowindex'));
  const page = Math.max(1, Math.floor(box.clientHeight / ROW_PX) - 1);
  const step = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -count, End: count }[event.key];
  if (step === undefined) return;
  event.preventDefault();
  const to = Math.min(Math.max(at + step, 2), count + 1);
  const top = (to - 2) * ROW_PX;
  if (box.scrollHeight > box.clientHeight) {
    if (top < box.scrollTop) box.scrollTop = top;
    else if (top + 3 * ROW_PX > box.scrollTop + box.clientHeight) box.scrollTop = top + 3 * ROW_PX - box.clientHeight;
  }
  const focus = () => {
    const line = box.querySelector<HTMLElement>(`tbody tr[aria-rowindex="${to}"]`);
    (line?.querySelector<HTMLElement>('a, button') ?? line)?.focus();
  };
  focus();
  requestAnimationFrame(() => requestAnimationFrame(focus));
}

function useView() {
  const box = useRef<HTMLDivElement>(null);
  const [view, setView] = useState({ top: 0, height: 800 });
  const look = () => {
    const element = box.current;
    if (element) setView({ top: element.scrollTop, height: element.clientHeight });
  };
  useLayoutEffect(() => {
    look();
    window.addEventListener('resize', look);
    return () => window.removeEventListener('resize', look);
  }, []);
  return { box, view, look };
}

function windowOf({ top, height }: { top: number; height: number }, count: number): [number, number] {
  if (count <= ALL_UP_TO) return [0, count];
  const to = Math.min(count, Math.ceil((top + height) / ROW_PX) + OVERSCAN);
  return [Math.min(Math.max(0, Math.floor(top / ROW_PX) - OVERSCAN), to), to];
}

export function Table<Row>({ caption, columns: all, rows, keyOf, sort, sortParameter = 'sort', tools, csvHref, isBare = false }: TableProps<Row>) {
  const sorting = route.value.query.get(sortParameter) ?? sort;
  const sortColumn = sorting.replace(/^-/, '');
  const { isEntered, handlers } = useEntered();
  const choice = useColumns(all, caption, sortParameter === 'sort' ? 'columns' : `${sortParameter}-columns`, sortColumn);
  const columns = choice.shown;
  const [turn, setTurn] = useState(0);
  // The order is kept until the query of the URL changes. A changed filter or sorting changes the query.
  const order = useMemo(() => new RowOrder<Row>(), [route.value.query.toString(), turn]);
  const valueOf = all.find(({ id }) => id === sortColumn)?.sort;
  const sorted = useMemo(() => (valueOf ? sortedBy(rows, valueOf, sorting.startsWith('-')) : [...rows]), [rows, sorting]);
  const { box, view, look } = useView();
  const { placed, isOutdated } = order.place(sorted, keyOf, isEntered || view.top > 0);
  const [from, to] = windowOf(view, placed.length);
  const lines = useLines(placed.slice(from, to), from, columns);

  const sortAgain = (next: string) => {
    setQuery({ [sortParameter]: next === sort ? undefined : next });
    setTurn((count) => count + 1);
  };
  return (
    <div class="table">
      {!isBare && <div class="tools">
        {tools}
        <div class="side">
          <button type="button" class={isOutdated ? 'quiet' : 'quiet hidden'} disabled={!isOutdated} onClick={() => sortAgain(sorting)}
            title="Rows keep their places while you are in the table">Sort again</button>
          <span class="soft count">{caption}: {grouped(rows.length)}</span>
          <ColumnChoice {...choice} />
          {csvHref && <CsvLink href={csvHref} of={caption} name={fileName('sweepstake', caption)} />}
        </div>
      </div>}
      <div class="scroll" ref={box} role="region" aria-label={caption} tabIndex={0} onScroll={look} {...handlers}
        onKeyDown={(event) => moveFocus(event, box.current!, placed.length)}>
        <table aria-rowcount={placed.length + 1}>
          <caption class="unseen">{caption}</caption>
          <thead><tr aria-rowindex={1}>{columns.map((column) => <Heading key={column.id} column={column} sorting={sorting} onSort={sortAgain} />)}</tr></thead>
          <tbody>
            <Gap rows={from} columns={columns.length} />
            {lines}
            <Gap rows={placed.length - to} columns={columns.length} />
          </tbody>
        </table>
      </div>
    </div>
  );
}

export function useEntered() {
  const [entered, setEntered] = useState({ pointer: false, focus: false });
  const handlers = {
    onPointerEnter: () => setEntered((before) => ({ ...before, pointer: true })),
    onPointerLeave: () => setEntered((before) => ({ ...before, pointer: false })),
    onFocusIn: () => setEntered((before) => ({ ...before, focus: true })),
    onFocusOut: (event: FocusEvent) => {
      const isWithin = (event.currentTarget as Element).contains(event.relatedTarget as Node | null);
      if (!isWithin) setEntered((before) => ({ ...before, focus: false }));
    },
  };
  return { isEntered: entered.pointer || entered.focus, handlers };
}
