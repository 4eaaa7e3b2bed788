// The choice of a table's columns. It is in the URL, and the browser remembers it for the next visit.
import { useId, useMemo, useState } from 'preact/hooks';
import { remember, remembered } from '../../remembered';
import { route, setQuery } from '../state/route';
import type { Column } from './table';

const EVERY = 'all';

/** Returns the columns to show. `chosen` is "all" or a list of ids with commas; empty: those that are shown at first. The first column and
 * the one that the table is sorted by are always shown. */
export function shownColumns<Row>(all: readonly Column<Row>[], chosen: string, sorted: string): readonly Column<Row>[] {
  const ids = new Set(chosen.split(','));
  return all.filter((column, i) => i === 0 || column.id === sorted || (chosen === '' ? !column.isDetail : chosen === EVERY || ids.has(column.id)));
}

/** Returns the shortest text with which shownColumns returns these columns. */
export function choiceOf<Row>(all: readonly Column<Row>[], shown: readonly Column<Row>[]): string {
  const isEach = (test: (column: Column<Row>) => boolean) => all.every((column, i) => i === 0 || shown.includes(column) === test(column));
  if (isEach(({ isDetail }) => !isDetail)) return '';
  return isEach(() => true) ? EVERY : shown.map(({ id }) => id).join();
}

interface ColumnChoiceProps<Row> { all: readonly Column<Row>[]; shown: readonly Column<Row>[]; sorted: string; choose(shown: readonly Column<Row>[]): void }

/** Returns the columns of a table to show, and a function that chooses others. `parameter` is the name of the choice in the URL. */
export function useColumns<Row>(all: readonly Column<Row>[], caption: string, parameter: string, sorted: string): ColumnChoiceProps<Row> {
  const name = `columns of ${route.value.name}: ${caption}`;
  const [, drawAgain] = useState(0);
  const chosen = route.value.query.get(parameter) ?? remembered(name) ?? '';
  const shown = useMemo(() => shownColumns(all, chosen, sorted), [all, chosen, sorted]);
  const choose = (next: readonly Column<Row>[]) => {
    const text = choiceOf(all, next) || undefined;
    remember(name, text);
    setQuery({ [parameter]: text });
    drawAgain((count) => count + 1); // the URL does not change if it had no choice
  };
  return { all, shown, sorted, choose };
}

/** A button that opens a list of all columns and their meanings, which also helps users who cannot point at a heading. */
export function ColumnChoice<Row>({ all, shown, sorted, choose }: ColumnChoiceProps<Row>) {
  const id = useId();
  const [isOpen, setOpen] = useState(false);
  const toggle = (column: Column<Row>) => choose(all.filter((each) => shown.includes(each) !== (each === column)));
  return (
    <>
      <button type="button" class="quiet" popovertarget={id}>Columns{shown.length < all.length && ` ${shown.length}/${all.length}`}</button>
      <div id={id} popover="auto" class="menu" onToggle={(event) => setOpen(event.newState === 'open')}>
        {isOpen && (
          <fieldset>
            <legend class="unseen">Shown columns</legend>
            {all.map((column, i) => (
              <label key={column.id}>
                <input type="checkbox" checked={shown.includes(column)} disabled={i === 0 || column.id === sorted} onChange={() => toggle(column)} />
                <span>{column.title}{column.hint && <small class="soft">{column.hint}</small>}</span>
              </label>
            ))}
            <button type="button" onClick={() => choose(shownColumns(all, '', sorted))}>Usual columns</button>
          </fieldset>
        )}
      </div>
    </>
  );
}
