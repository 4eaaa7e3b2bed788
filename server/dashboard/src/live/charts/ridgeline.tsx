// The posterior of each arm, one row per arm over a shared axis: density, mean, and 50 % and 95 % credible intervals.
import type { ComponentChildren } from 'preact';
import { useState } from 'preact/hooks';
import { colourOf } from '../../palette';
import { type Beta, mean, type Posterior, ridge, ridgeAxis } from '../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, rewardOfNs, rewardText } from '../numbers/log_cost';
import { linearTicks, logTicks } from '../numbers/ticks';
import { shapeOf } from '../parts/arm';
import { visible } from '../parts/name';
import { ChartFrame, type ChartTable } from './frame';
import { useWidth } from './width';

export type Measured = 'live' | 'lane' | 'never';

export interface RidgeRow {
  arm: string;
  label: string; // the arm, with its backend version if there are several
  posterior: Posterior;
  before?: Beta; // a prior, drawn behind the posterior
  measured: Measured;
  isPart?: true; // the row has only live or only lane evidence; another row may have the rest
}

/** Sentences that explain where an arm was measured; empty if it ran in a game. */
export const MEASURED_WORDS: Readonly<Record<Measured, string>> = {
  live: '', lane: 'The algorithm was measured only in the shadow lane, never in a game.', never: 'Without a measurement the posterior equals the prior.',
};

const ROW = 62;
const CREST = 34;
const TOP = 6;
/** The heights and margins of an axis below a chart, in pixels. */
export const AXIS = 34;
export const SIDE = 12;
const TICK_SIDE = 26; // pixels from the edge to the centre of a tick's text, so that the text is not cut off
const ROOM_FOR_INTERVAL = 380; // minimum width in pixels at which the interval is written beside the arm's name

// An axis of rewards or, if `tellsCosts`, of the costs that they stand for. Costs increase to the right, so rewards fall.
interface Axis { low: number; high: number; x: (reward: number) => number; reward: (x: number) => number; tellsCosts: boolean }

export const ridgeRange = (rows: readonly RidgeRow[]) =>
  ridgeAxis(rows.map(({ posterior, measured }) => ({ posterior, isMeasured: measured !== 'never' })));

function axisOf([low, high]: readonly [number, number], width: number, tellsCosts: boolean): Axis {
  const span = width - 2 * SIDE;
  const share = (reward: number) => (tellsCosts ? high - reward : reward - low) / (high - low);
  return {
    low, high, tellsCosts,
    x: (reward) => SIDE + span * Math.min(Math.max(share(reward), 0), 1),
    reward: (x) => (tellsCosts ? high - ((x - SIDE) / span) * (high - low) : low + ((x - SIDE) / span) * (high - low)),
  };
}

function outline(posterior: Beta, { low, high, x }: Axis, base: number, width: number): string {
  const points = ridge(posterior, low, high, Math.max(40, Math.floor(width / 3)));
  if (points.length === 0) return '';
  const line = points.map(({ reward, height }) => `${x(reward).toFixed(2)},${(base - CREST * height).toFixed(2)}`);
  return `M${x(points[0]!.reward).toFixed(2)},${base}L${line.join('L')}L${x(points.at(-1)!.reward).toFixed(2)},${base}Z`;
}

const PAINT: Readonly<Record<Measured, { fill: number; dash?: string }>> = {
  live: { fill: 0.35 }, lane: { fill: 0.12, dash: '6 3' }, never: { fill: 0, dash: '2 4' },
};

function Row({ row, base, axis, width }: { row: RidgeRow; base: number; axis: Axis; width: number }) {
  const { posterior, before, measured, arm, label, isPart } = row;
  const colour = colourOf(arm);
  const { fill, dash } = PAINT[measured];
  const text = (reward: number) => rewardText(reward, axis.tellsCosts);
  const told = (interval: string) => (measured === 'never' ? 'never measured' : `${text(mean(posterior))}${interval}${measured === 'lane' && !isPart ? ', lane only' : ''}`);
  const { low95, low50, high50, high95 } = posterior;
  const line = (low = 0, high = 0, thickness: number) =>
    <line x1={axis.x(low)} x2={axis.x(high)} y1={base + 5} y2={base + 5} stroke={colour} stroke-width={thickness} />;
  const [left, right] = axis.tellsCosts ? [high95, low95] : [low95, high95];
  const value = told(left === undefined || right === undefined ? '' : ` (${text(left)} to ${text(right)})`);
  return (
    <g>
      <title>{`${visible(label)}: ${value}. ${isPart ? '' : MEASURED_WORDS[measured]}`}</title>
      {before && <path d={outline(before, axis, base, width)} fill="none" stroke="var(--soft)" stroke-dasharray="3 3" />}
      <path d={outline(posterior, axis, base, width)} fill={colour} fill-opacity={fill} stroke={colour} stroke-width="1.5" stroke-dasharray={dash ?? 'none'} />
      {high95 !== undefined && <>{line(low95, high95, 1.5)}{line(low50, high50, 5)}</>}
      <path d={shapeOf(arm)} transform={`translate(${axis.x(mean(posterior)).toFixed(2)} ${base + 5})`} fill={measured === 'live' ? colour : 'var(--card)'}
        stroke={colour} stroke-width="1.5" />
      <text class="halo" x={SIDE} y={base - CREST - 4} font-size=".8rem" font-weight="600" fill="var(--text)">{shortened(label, width)}</text>
      <text class="halo" x={width - SIDE} y={base - CREST - 4} font-size=".73rem" fill="var(--soft)" text-anchor="end">{width < ROOM_FOR_INTERVAL ? told('') : value}</text>
    </g>
  );
}

export function shortened(name: string, width: number): string {
  const shown = visible(name);
  const most = Math.max(8, Math.floor(width / 22));
  return [...shown].length <= most ? shown : `${[...shown].slice(0, most - 1).join('')}…`;
}

/** The axis of a chart with lines at round values. The text of a tick is moved inwards if it would be cut off. */
export function Ticks({ ticks, width, y, unit }: { ticks: readonly { x: number; text: string }[]; width: number; y: number; unit: string }) {
  return (
    <g font-size=".73rem" fill="var(--soft)" text-anchor="middle">
      {ticks.map(({ x, text }) => (
        <g key={text}>
          <line x1={x} x2={x} y1={0} y2={y} stroke="var(--rule)" />
          <text x={Math.min(Math.max(x, TICK_SIDE), width - TICK_SIDE)} y={y + 14}>{text}</text>
        </g>
      ))}
      <text x={width / 2} y={y + 29}>{unit}</text>
    </g>
  );
}

export const tickCount = (width: number) => Math.max(2, Math.floor(width / 90));

function ticksOf({ low, high, x, tellsCosts }: Axis, width: number): { x: number; text: string }[] {
  const rewards = tellsCosts ? logTicks(costNsOf(high), costNsOf(low), tickCount(width)).map(rewardOfNs) : linearTicks(low, high, tickCount(width));
  return rewards.map((reward) => ({ x: x(reward), text: rewardText(reward, tellsCosts) }));
}

interface RidgelineProps {
  title: string;
  rows: readonly RidgeRow[];
  rewardVersion: number;
  rewards?: readonly [number, number]; // range of an axis shared with other charts; absent: the range of these rows
}

function Ridgeline({ title, rows, rewardVersion, rewards = ridgeRange(rows) }: RidgelineProps) {
  const { element, width } = useWidth<HTMLDivElement>();
  const [pointer, setPointer] = useState<number | undefined>(undefined);
  const height = TOP + rows.length * ROW + AXIS;
  const axis = axisOf(rewards, Math.max(width, 160), rewardVersion === LOG_COST_REWARD_VERSION);
  const onPointerMove = (event: PointerEvent) => {
    const x = event.clientX - (event.currentTarget as Element).getBoundingClientRect().left;
    setPointer(x < SIDE || x > width - SIDE ? undefined : x);
  };
  return (
    <div ref={element} class="ridgeline">
      {width > 0 && (
        <svg class="picture" width={width} height={height} viewBox={`0 0 ${width} ${height}`} role="img"
          aria-label={`${title}; the table has the values`} onPointerMove={onPointerMove} onPointerLeave={() => setPointer(undefined)}>
          <Ticks ticks={ticksOf(axis, width)} width={width} y={height - AXIS}
            unit={axis.tellsCosts ? 'detection time per frame (less is better)' : 'reward (more is better)'} />
          {rows.map((row, i) => <Row key={row.label} row={row} base={TOP + (i + 1) * ROW - 12} axis={axis} width={width} />)}
          {pointer !== undefined && (
            <g pointer-events="none">
              <line x1={pointer} x2={pointer} y1={0} y2={height - AXIS} stroke="var(--text)" stroke-dasharray="3 3" />
              <text class="halo" x={pointer} y={height - AXIS - 2} font-size=".73rem" fill="var(--text)" text-anchor={pointer > width / 2 ? 'end' : 'start'}>
                {` ${rewardText(axis.reward(pointer), axis.tellsCosts)} `}
              </text>
            </g>
          )}
        </svg>
      )}
    </div>
  );
}

interface RidgeFigureProps extends RidgelineProps {
  id: string;
  names: readonly string[]; // parts of the names of exported files
  note?: ComponentChildren;
  notYet: string; // shown if there are no rows
  table?: () => ChartTable; // absent: the values of the rows
  csvHref?: string | undefined;
  children?: ComponentChildren; // above the chart
}

export function RidgeFigure({ id, names, note, notYet, table, csvHref, children, ...chart }: RidgeFigureProps) {
  const { title, rows } = chart;
  const values = () => ({
    header: ['algorithm', 'measured', 'alpha', 'beta', 'mean reward', '95 % from', 'to', 'prior alpha', 'prior beta'],
    rows: rows.map(({ label, measured, posterior, before }) =>
      [label, measured, posterior.alpha, posterior.beta, mean(posterior), posterior.low95, posterior.high95, before?.alpha, before?.beta]),
  });
  return (
    <ChartFrame id={id} title={title} names={names} note={note} table={table ?? values} csvHref={csvHref} empty={rows.length === 0 && notYet}>
      {children}
      <Ridgeline {...chart} />
    </ChartFrame>
  );
}
