// Charts of a session's costs over time: frame time and detection time with the budgets of 60 and 30 frames per second, memory,
// AABB checks and objects.
import { useMemo } from 'preact/hooks';
import { bytes, compact, significant } from '../../../format';
import { FRAME_MS } from '../../numbers/log_cost';
import type { Level, Line, Moment } from '../../charts/plot';
import { TimeFigure } from '../../charts/time_chart';
import type { Range } from '../../charts/view_state';
import type { CostColumns } from './model';

export const BUDGETS: readonly Level[] = [{ value: FRAME_MS, label: '60 fps' }, { value: 2 * FRAME_MS, label: '30 fps' }];
// Detection takes a small part of a frame. Its axis therefore ignores the budgets, which are drawn only if values come near them.
const BUDGETS_ASIDE: readonly Level[] = BUDGETS.map((level) => ({ ...level, value: 1000 * level.value, isAside: true })); // µs

export const PERCENTILES = [
  { label: 'p50', colour: 'var(--arm-4)', dash: [] }, { label: 'p95', colour: 'var(--arm-2)', dash: [8, 3] }, { label: 'p99', colour: 'var(--arm-3)', dash: [4, 2] },
] as const;

const percentileLines = (columns: readonly (number | null)[][], first: string): Line[] =>
  [{ label: first, colour: 'var(--soft)', dash: [2, 2] }, ...PERCENTILES].map((line, i) => ({ ...line, values: columns[i] ?? [] }));

const single = (label: string, values: (number | null)[]): Line[] => [{ label, values, colour: 'var(--accent)' }];
const ms = (value: number) => `${significant(value)} ms`;
const us = (value: number) => `${significant(value)} µs`;

export interface Ends { frameMs: readonly [number, number]; detectionUs: readonly [number, number] }

export interface CostChartsProps {
  columns: CostColumns;
  moments: readonly Moment[];
  domain: Range;
  names: readonly string[];
  ends?: Ends; // ranges of axes that two sessions share
  laterMs?: number; // real time minus drawn time; the tables show real times
  csvHref: string; // the URL of all windows as CSV
}

export function CostCharts({ columns, moments, domain, names, ends, laterMs = 0, csvHref }: CostChartsProps) {
  const { timesMs } = columns;
  const lines = useMemo(() => ({
    frame: percentileLines(columns.frame, 'window mean'), detection: percentileLines(columns.detection, 'window mean'),
    bytes: percentileLines(columns.bytes, 'window peak'), checks: single('checks', columns.checks), objects: single('objects', columns.objects),
  }), [columns]);
  const common = { timesMs, moments, domain, names, laterMs, csvHref, scale: 'zero' } as const;
  const figure = (drawn: readonly Line[]) => ({ ...common, lines: drawn,
    empty: !drawn.some((line) => line.values.some((value) => value !== null)) && 'Nothing was measured yet.' });
  return (
    <>
      <TimeFigure {...figure(lines.frame)} id="frame-time" title="Frame time" levels={BUDGETS} unit="(ms)" format={ms} height={180} {...(ends && { values: ends.frameMs })}
        note="Percentiles cover the frames since the page was opened. The mean of each window is from the audit log. The lines 60 fps and 30 fps mark 16.7 and 33.3 ms per frame." />
      <TimeFigure {...figure(lines.detection)} id="detection" title="Detection time" levels={BUDGETS_ASIDE} unit="(µs)" format={us} height={180} scale="log"
        {...(ends && { values: ends.detectionUs })} note="Time of the broad phase per frame, on a logarithmic axis. The lines 60 fps and 30 fps appear only if values come near them." />
      <div class="beside">
        <TimeFigure {...figure(lines.bytes)} id="memory" title="Memory" unit="(bytes)" format={bytes} height={140} />
        <TimeFigure {...figure(lines.checks)} id="checks" title="AABB checks per frame" format={compact} height={140} />
        <TimeFigure {...figure(lines.objects)} id="objects" title="Objects" format={compact} height={140} />
      </div>
    </>
  );
}
