// The frame of a chart: title, note, a table of the values, and buttons that save table and picture as files.
import type { ComponentChildren } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { CsvLink } from '../parts/download';
import { type Column, Table } from '../parts/table';
import { toast } from '../parts/toast';
import { fileName, visible } from '../parts/name';
import './charts.css';
import { savePng } from './png';

/** The values of a chart; null and undefined: unknown. */
export interface ChartTable { header: readonly string[]; rows: readonly (readonly (string | number | bigint | boolean | null | undefined)[])[] }

interface FrameProps {
  id: string;
  title: string;
  note?: ComponentChildren;
  /** Parts of the names of exported files, before the chart's id. */
  names: readonly string[];
  table: () => ChartTable;
  /** The URL of all values at full resolution; absent: the daemon has no such table. */
  csvHref?: string | undefined;
  /** Shown instead of the chart if there is nothing to draw. */
  empty?: ComponentChildren;
  children: ComponentChildren;
}

function ValueTable({ id, title, table: { header, rows } }: { id: string; title: string; table: ChartTable }) {
  const columns = header.map((name, i): Column<number> => {
    const valueOf = (row: number) => rows[row]?.[i];
    const sort = (row: number) => { const value = valueOf(row); return typeof value === 'string' ? value : value === null || value === undefined ? undefined : Number(value); };
    return { id: String(i), title: visible(name), sort, isText: typeof valueOf(0) === 'string', cell: (row) => <bdi>{visible(String(valueOf(row) ?? '–'))}</bdi> };
  });
  return <Table isBare caption={`${title}, as a table`} columns={columns} rows={[...rows.keys()]} keyOf={String} sort="" sortParameter={`${id}-table`} />;
}

export function ChartFrame({ id, title, note, names, table, csvHref, empty, children }: FrameProps) {
  const figure = useRef<HTMLElement>(null);
  const [open, setOpen] = useState(false);
  const file = fileName('sweepstake', ...names, id);
  return (
    <figure class="chart" data-chart={id} ref={figure}>
      <figcaption>
        <h3>{title}</h3>
        {!empty && <span class="tools">
          <button type="button" aria-expanded={open} onClick={() => setOpen(!open)}>Table</button>
          {csvHref && <CsvLink href={csvHref} of={title} name={file} />}
          <button type="button" aria-label={`${title} as PNG`} onClick={() => void savePng(`${file}.png`, figure.current!).catch(() => toast('This browser cannot save the chart as a picture', { isBad: true }))}>PNG</button>
        </span>}
        {note && <p class="soft">{note}</p>}
      </figcaption>
      {empty ? <p class="empty-chart">{empty}</p> : children}
      {open && !empty && <ValueTable id={id} title={title} table={table()} />}
    </figure>
  );
}
