// How the posteriors of a scene or session came to be: means with bands, probabilities to be the best, and the loss that remains.
import { useMemo } from 'preact/hooks';
import { share, significant } from '../../format';
import type { CsvValue } from '../numbers/csv';
import { costNsOf, LOG_COST_REWARD_VERSION, nsText } from '../numbers/log_cost';
import type { Belief, SeriesRow } from '../numbers/series';
import { thresholds } from '../state/account';
import { armStyle } from './arm_style';
import { hatched } from './colours';
import { ChartFrame, type ChartTable } from './frame';
import { type Band, fillOf, type Line, type Moment } from './plot';
import { TimeChart } from './time_chart';
import { domainOf, range, type Range } from './view_state';

export interface PosteriorChartsProps {
  arms: readonly string[];
  rows: readonly SeriesRow[];
  rewardVersion: number;
  names: readonly string[]; // of files
  moments?: readonly Moment[];
  domain?: Range; // of charts beside others; else all there is
  values?: readonly [number, number]; // of charts beside others: the axis of values
  notYet?: string; // why there is nothing to draw
  assumed?: ReadonlySet<string>; // arms that were never measured: the axis need not show all that they may be
}

const NOT_YET = 'Nothing has changed since the page was opened. Each change that the daemon tells adds a point.';
const NONE: ReadonlySet<string> = new Set();
const PARTS = ['mean', 'low50', 'high50', 'low95', 'high95'] as const;

// Costs fall as rewards rise.
const COST_PART: Readonly<Record<keyof Belief, keyof Belief>> = { mean: 'mean', low50: 'high50', high50: 'low50', low95: 'high95', high95: 'low95' };

const isoTime = (ms: number) => new Date(ms).toISOString();

function valueOf(belief: Belief | undefined, part: keyof Belief, tellsCosts: boolean): number | null {
  if (!belief) return null;
  return tellsCosts ? costNsOf(belief[COST_PART[part]]) : belief[part];
}

function bandLines(arms: readonly string[], rows: readonly SeriesRow[], tellsCosts: boolean, assumed: ReadonlySet<string>): { lines: Line[]; bands: Band[] } {
  const lines: Line[] = [];
  const bands: Band[] = [];
  arms.forEach((arm, i) => {
    const { colour, dash } = armStyle(arm, arms);
    const first = lines.length;
    for (const part of PARTS) {
      const values = rows.map(({ beliefs }) => valueOf(beliefs[i], part, tellsCosts));
      lines.push({ label: part === 'mean' ? arm : `${arm} ${part}`, values, colour, dash, arm, stepped: true, width: part === 'mean' ? 2 : 0, isAside: assumed.has(arm) });
    }
    bands.push({ upper: first + 4, lower: first + 3, fill: fillOf(colour, 0.1) }, { upper: first + 2, lower: first + 1, fill: fillOf(colour, 0.2) });
  });
  return { lines, bands };
}

function table(arms: readonly string[], rows: readonly SeriesRow[], columns: readonly string[], cells: (row: SeriesRow, arm: number) => CsvValue[]): ChartTable {
  return {
    header: ['time', ...arms.flatMap((arm) => columns.map((column) => (column ? `${arm} ${column}` : arm)))],
    rows: rows.map((row) => [isoTime(row.timeMs), ...arms.flatMap((_, i) => cells(row, i))]),
  };
}

export function BandsChart({ arms, rows, rewardVersion, names, moments, domain, values, notYet = NOT_YET, assumed = NONE }: PosteriorChartsProps) {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const { lines, bands } = useMemo(() => bandLines(arms, rows, tellsCosts, assumed), [arms, rows, tellsCosts, assumed]);
  const title = tellsCosts ? 'Detection time that each arm is believed to take' : 'Reward that each arm is believed to have';
  const cells = (row: SeriesRow, arm: number) => PARTS.map((part) => valueOf(row.beliefs[arm], part, tellsCosts));
  return (
    <ChartFrame id="bands" title={title} names={names} note="Mean, and the bands where it is with 50 and 95 %." empty={rows.length < 2 && notYet}
      table={() => table(arms, rows, PARTS.map((part) => (tellsCosts ? `${part} ns` : part)), cells)}>
      <TimeChart title={title} timesMs={timesMs} lines={lines} bands={bands} {...(moments && { moments })} {...(values && { values })} scale={tellsCosts ? 'log' : 'unit'}
        domain={range.value ?? domain ?? domainOf(timesMs, undefined)} format={tellsCosts ? nsText : (value) => significant(value)} height={260} />
    </ChartFrame>
  );
}

/** Returns the lowest and highest value that bands have, for an axis in common. */
export function bandRange(rows: readonly SeriesRow[], rewardVersion: number): [number, number] {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const known = rows.flatMap(({ beliefs }) => beliefs).filter((belief) => belief !== undefined);
  return [
    Math.min(...known.map((belief) => valueOf(belief, 'low95', tellsCosts)!)),
    Math.max(...known.map((belief) => valueOf(belief, 'high95', tellsCosts)!)),
  ];
}

// From the bottom up, the leader of now first, so that its own height is read against the threshold. The others keep their order: another
// one is another plot.
function stackLines(arms: readonly string[], rows: readonly SeriesRow[]): { lines: Line[]; bands: Band[] } {
  const latest = rows.at(-1)?.best ?? [];
  const leader = arms.reduce((best, _, i) => ((latest[i] ?? 0) > (latest[best] ?? 0) ? i : best), 0);
  const order = [leader, ...arms.keys()].filter((i, place, all) => all.indexOf(i) === place);
  const sums = rows.map(() => 0);
  const lines: Line[] = [{ label: '', values: rows.map(({ best }) => (best.some((p) => p !== undefined) ? 0 : null)), colour: 'var(--soft)', width: 0 }];
  const bands: Band[] = [];
  for (const i of order) {
    const { colour, dash, hatch } = armStyle(arms[i]!, arms);
    const told = rows.map(({ best }) => best[i] ?? null);
    const values = rows.map(({ best }, k) => (best.some((p) => p !== undefined) ? (sums[k]! += best[i] ?? 0) : null));
    lines.push({ label: arms[i]!, values, told, colour, dash, stepped: true, width: 1.5 });
    bands.push({ upper: lines.length - 1, lower: lines.length - 2, fill: (context) => hatched(context, colour, hatch) });
  }
  return { lines, bands };
}

export function BestChart({ arms, rows, names, moments, domain, notYet = NOT_YET }: PosteriorChartsProps) {
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const { lines, bands } = useMemo(() => stackLines(arms, rows), [arms, rows]);
  const title = 'Probability of each arm to be the best';
  return (
    <ChartFrame id="best" title={title} names={names} note={`From ${thresholds.value.stableProbability} on the scene is stable.`} empty={rows.length < 2 && notYet}
      table={() => table(arms, rows, [''], (row, arm) => [row.best[arm] ?? null])}>
      <TimeChart title={title} timesMs={timesMs} lines={lines} bands={bands} {...(moments && { moments })} scale="unit"
        levels={[{ value: thresholds.value.stableProbability, label: 'stable' }]} domain={range.value ?? domain ?? domainOf(timesMs, undefined)}
        format={(value) => value.toFixed(3)} height={200} />
    </ChartFrame>
  );
}

export function LossChart({ rows, names, moments, domain, notYet = NOT_YET }: PosteriorChartsProps) {
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const lines = useMemo((): Line[] => [{
    label: 'loss', values: rows.map(({ expectedLossRatio }) => expectedLossRatio ?? null), colour: 'var(--accent)', stepped: true,
  }], [rows]);
  const title = 'What choosing the leader may still lose';
  return (
    <ChartFrame id="loss" title={title} names={names} note={`Up to ${share(thresholds.value.tieLossRatio)} it does not matter which arm is chosen.`} empty={rows.length < 2 && notYet}
      table={() => ({ header: ['time', 'expected loss'], rows: rows.map((row) => [isoTime(row.timeMs), row.expectedLossRatio ?? null]) })}>
      <TimeChart title={title} timesMs={timesMs} lines={lines} {...(moments && { moments })} scale="zero" levels={[{ value: thresholds.value.tieLossRatio, label: 'a tie' }]}
        domain={range.value ?? domain ?? domainOf(timesMs, undefined)} format={share} height={140} />
    </ChartFrame>
  );
}
