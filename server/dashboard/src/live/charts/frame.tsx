// The frame of a chart: title, note, a table of the values, and buttons that save table and picture as files.
import type { ComponentChildren } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { csvOf, type CsvValue } from '../numbers/csv';
import { download } from '../parts/download';
import { toast } from '../parts/toast';
import { fileName, visible } from '../parts/visible';
import './charts.css';
import { savePng } from './png';

const MAX_TABLE_ROWS = 200;

/** The values of a chart. */
export interface ChartTable { header: readonly string[]; rows: readonly (readonly CsvValue[])[] }

interface FrameProps {
  id: string;
  title: string;
  note?: ComponentChildren;
  /** Parts of the names of exported files, before the chart's id. */
  names: readonly string[];
  /** Called when the table is opened or saved. */
  table: () => ChartTable;
  /** Shown instead of the chart if there is nothing to draw. */
  empty?: ComponentChildren;
  children: ComponentChildren;
}

function ValueTable({ title, table: { header, rows } }: { title: string; table: ChartTable }) {
  const shown = rows.slice(-MAX_TABLE_ROWS);
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={`${title}, as a table`}>
      {shown.length < rows.length && <p class="soft">The last {shown.length} of {rows.length} rows. The CSV file has all rows.</p>}
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
          <button type="button" aria-label={`${title} as PNG`} onClick={() => void savePng(`${file}.png`, figure.current!).catch(() => toast('This browser cannot save the chart as a picture', { isBad: true }))}>PNG</button>
        </span>}
        {note && <p class="soft">{note}</p>}
      </figcaption>
      {empty ? <p class="empty-chart">{empty}</p> : children}
      {open && !empty && <ValueTable title={title} table={table()} />}
    </figure>
  );
}
