// What every chart has around it: its title, what it means, its values as a table, and both as files.
import type { ComponentChildren } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { csvOf, type CsvValue } from '../numbers/csv';
import { download } from '../parts/download';
import { toast } from '../parts/toast';
import { fileName, visible } from '../parts/visible';
import './charts.css';
import { savePng } from './png';

const MAX_TABLE_ROWS = 200;

/** What a chart shows, in words and numbers. */
export interface ChartTable { header: readonly string[]; rows: readonly (readonly CsvValue[])[] }

interface FrameProps {
  id: string;
  title: string;
  note?: ComponentChildren;
  /** Of the exported files, before the chart's own. */
  names: readonly string[];
  /** Called only when somebody wants it. */
  table: () => ChartTable;
  /** Shown in place of the chart where there is nothing to draw. */
  empty?: ComponentChildren;
  children: ComponentChildren;
}

function ValueTable({ title, table: { header, rows } }: { title: string; table: ChartTable }) {
  const shown = rows.slice(-MAX_TABLE_ROWS);
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={`${title}, as a table`}>
      {shown.length < rows.length && <p class="soft">The last {shown.length} of {rows.length} rows; the CSV file has all of them.</p>}
      <table>
        <caption class="unseen">{title}</caption>
        <thead><tr>{header.map((name) => <th key={name} scope="col"><bdi>{visible(name)}</bdi></th>)}</tr></thead>
        <tbody>
          {shown.map((row, i) => (
            <tr key={i}>
              {row.map((value, column) => <td key={column} class={typeof value === 'string' ? 'text' : ''}>
                {value === null || value === undefined ? '–' : <bdi>{visible(String(value))}</bdi>}
              </td>)}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function ChartFrame({ id, title, note, names, table, empty, children }: FrameProps) {
  const figure = useRef<HTMLElement>(null);
  const [open, setOpen] = useState(false);
  const file = fileName('sweepstake', ...names, id);
  const saveTable = () => {
    const { header, rows } = table();
    download(`${file}.csv`, csvOf(header, rows), 'text/csv');
  };
  return (
    <figure class="chart" data-chart={id} ref={figure}>
      <figcaption>
        <h3>{title}</h3>
        {!empty && <span class="tools">
          <button type="button" aria-expanded={open} onClick={() => setOpen(!open)}>Table</button>
          <button type="button" aria-label={`${title} as CSV`} onClick={saveTable}>CSV</button>
          <button type="button" aria-label={`${title} as PNG`} onClick={() => void savePng(`${file}.png`, figure.current!).catch(() => toast('This browser cannot draw the picture', { isBad: true }))}>PNG</button>
        </span>}
        {note && <p class="soft">{note}</p>}
      </figcaption>
      {empty ? <p class="empty-chart">{empty}</p> : children}
      {open && !empty && <ValueTable title={title} table={table()} />}
    </figure>
  );
}
