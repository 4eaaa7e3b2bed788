// Draws one interval per arm, or two, for instance of two builds, over a logarithmic axis of costs or cost ratios.
import { compact, significant } from '../../format';
import { colourOf } from '../../palette';
import type { Ratio } from '../numbers/log_cost';
import { logTicks } from '../numbers/ticks';
import { shapeOf } from '../parts/arm';
import { AXIS, shortened, SIDE, tickCount, Ticks } from './ridgeline';
import { useWidth } from './width';

/** An arm and its cost or cost ratio, before and after; undefined if it is not known. If all of `before` are undefined, one interval is drawn. */
export interface IntervalRow { arm: string; before: Ratio | undefined; after: Ratio | undefined }

const ROW = 44;
const SINGLE_ROW = 32; // with one interval
const TOP = 4;
const REACH = 10; // intervals are cut off at this multiple of the largest median, and at the smallest median ÷ this

/** Returns an axis of ratios that shows all medians, and their intervals up to a factor of REACH. REQUIRES: `ratios` is not empty. */
export function ratioAxis(ratios: readonly Ratio[]): [low: number, high: number] {
  const medians = ratios.map(({ median }) => median);
  const low = Math.max(Math.min(...ratios.map((each) => each.low)), Math.min(...medians) / REACH);
  const high = Math.min(Math.max(...ratios.map((each) => each.high)), Math.max(...medians) * REACH);
  const pad = Math.max((high / low) ** 0.05, 1.01);
  return [low / pad, high * pad];
}

type Place = (ratio: number) => number;

function Bar({ arm, ratio: { median, low, high }, y, x, isBefore }: { arm: string; ratio: Ratio; y: number; x: Place; isBefore: boolean }) {
  const colour = colourOf(arm);
  return (
    <g>
      <line x1={x(low)} x2={x(high)} y1={y} y2={y} stroke={colour} stroke-width={isBefore ? 1.5 : 3} stroke-dasharray={isBefore ? '4 3' : 'none'} />
      <path d={shapeOf(arm)} transform={`translate(${x(median).toFixed(2)} ${y})`} fill={isBefore ? 'var(--card)' : colour} stroke={colour} stroke-width="1.5" />
    </g>
  );
}

type Format = (value: number) => string;
const textOf = (ratio: Ratio | undefined, format: Format) => (ratio ? format(ratio.median) : 'not known');

interface RowProps { row: IntervalRow; top: number; x: Place; width: number; isPair: boolean; format: Format }

function Row({ row: { arm, before, after }, top, x, width, isPair, format }: RowProps) {
  const text = isPair ? `${textOf(before, format)} → ${textOf(after, format)}` : `${textOf(after, format)}${after ? ` (${significant(after.low)} to ${significant(after.high)})` : ''}`;
  return (
    <g>
      <text class="halo" x={SIDE} y={top + 12} font-size=".8rem" font-weight="600" fill="var(--text)">{shortened(arm, width)}</text>
      <text class="halo" x={width - SIDE} y={top + 12} font-size=".73rem" fill="var(--soft)" text-anchor="end">{text}</text>
      {before && <Bar arm={arm} ratio={before} y={top + 21} x={x} isBefore />}
      {after && <Bar arm={arm} ratio={after} y={top + (isPair ? 34 : 22)} x={x} isBefore={false} />}
    </g>
  );
}

export function Intervals({ title, rows, unit, format = significant }: { title: string; rows: readonly IntervalRow[]; unit: string; format?: Format }) {
  const { element, width } = useWidth<HTMLDivElement>();
  const axis = ratioAxis(rows.flatMap(({ before, after }) => [before, after]).filter((each): each is Ratio => each !== undefined));
  const span = Math.log(axis[1] / axis[0]);
  const x: Place = (ratio) => SIDE + (width - 2 * SIDE) * Math.min(Math.max(Math.log(ratio / axis[0]) / span, 0), 1);
  const ticks = logTicks(...axis, tickCount(width)).map((ratio) => ({ x: x(ratio), text: compact(ratio) }));
  const isPair = rows.some(({ before }) => before !== undefined);
  const rowHeight = isPair ? ROW : SINGLE_ROW;
  const height = TOP + rows.length * rowHeight + AXIS;
  return (
    <div ref={element} class="intervals">
      {width > 0 && (
        <svg class="picture" width={width} height={height} viewBox={`0 0 ${width} ${height}`} role="img" aria-label={`${title}; the table has the values`}>
          <Ticks ticks={ticks} width={width} y={height - AXIS} unit={unit} />
          {rows.map((row, i) => <Row key={row.arm} row={row} top={TOP + i * rowHeight} x={x} width={width} isPair={isPair} format={format} />)}
        </svg>
      )}
    </div>
  );
}
