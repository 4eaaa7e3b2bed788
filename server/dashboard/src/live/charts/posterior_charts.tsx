// The posteriors of a session or scene over time: means, and probabilities of being the best arm.
import { useMemo } from 'preact/hooks';
import { significant } from '../../format';
import { type Beta, mean } from '../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, nsText } from '../numbers/log_cost';
import { stableProbability } from '../state/account';
import { armStyle, hatched } from './colours';
import type { Band, Line } from './plot';
import { TimeFigure, type TimeFigureProps } from './time_chart';

export interface SeriesRow {
  timeMs: number; // since 1970, by the daemon's clock
  beliefs: readonly (Beta | undefined)[]; // in the order of the arms; undefined before an arm's first evidence
  best: readonly (number | undefined)[]; // P(best)
}

type BestRow = Pick<SeriesRow, 'timeMs' | 'best'>;

interface ChartProps<Row> extends Pick<TimeFigureProps, 'names' | 'domain' | 'moments' | 'csvHref'> {
  arms: readonly string[];
  rows: readonly Row[];
  notYet: string; // shown if there is nothing to draw
}

const timesOf = (rows: readonly BestRow[]) => rows.map(({ timeMs }) => timeMs);

// `assumed` are the arms that were never measured. The range of the axis ignores them.
const meanLines = (arms: readonly string[], rows: readonly SeriesRow[], valueOf: (reward: number) => number, assumed: ReadonlySet<string>) =>
  arms.map((arm, i): Line => {
    const { colour, dash } = armStyle(arm, arms);
    const values = rows.map(({ beliefs: { [i]: belief } }) => (belief ? valueOf(mean(belief)) : null));
    return { label: arm, values, colour, dash, arm, stepped: true, isAside: assumed.has(arm) };
  });

/** Shows the mean of each arm's posterior over time, as a detection time if rewards stand for costs. */
export function MeansChart({ arms, rows, rewardVersion, notYet, assumed, ...rest }: ChartProps<SeriesRow> & { rewardVersion: number; assumed: ReadonlySet<string> }) {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const timesMs = useMemo(() => timesOf(rows), [rows]);
  const lines = useMemo(() => meanLines(arms, rows, tellsCosts ? costNsOf : (reward) => reward, assumed), [arms, rows, tellsCosts, assumed]);
  return (
    <TimeFigure {...rest} id="bands" title={tellsCosts ? 'Estimated detection time of each algorithm' : 'Estimated reward of each algorithm'} timesMs={timesMs} lines={lines}
      note="Lines show means." empty={rows.length < 2 && notYet} unit={tellsCosts ? 'ns' : ''} scale={tellsCosts ? 'log' : 'unit'}
      format={tellsCosts ? (ns) => nsText(ns) : (value) => significant(value)} height={260} />
  );
}

const leaderOf = ({ best }: BestRow) => best.reduce((most: number, p, i) => ((p ?? 0) > (best[most] ?? 0) ? i : most), 0);

// Stacks the arms from the bottom up. The current leader comes first, so that its height can be compared with the threshold. The
// other arms keep their order, because each order needs a new plot. Each period with one leader is a state.
function stackLines(arms: readonly string[], rows: readonly BestRow[]): { lines: Line[]; bands: Band[]; states: number[] } {
  const states = rows.map(leaderOf);
  const order = [...new Set([states.at(-1) ?? 0, ...arms.keys()])];
  const sums = rows.map(({ best }) => (best.some((p) => p !== undefined) ? 0 : null));
  const lines: Line[] = [{ label: '', values: [...sums], colour: 'var(--soft)', width: 0 }];
  const bands: Band[] = [];
  for (const i of order) {
    const { colour, dash, hatch } = armStyle(arms[i]!, arms);
    rows.forEach(({ best }, k) => { if (sums[k] !== null) sums[k]! += best[i] ?? 0; });
    bands.push({ upper: lines.length, lower: lines.length - 1, fill: (context) => hatched(context, colour, hatch) });
    lines.push({ label: arms[i]!, values: [...sums], told: rows.map(({ best }) => best[i] ?? null), colour, dash, stepped: true, width: 1.5 });
  }
  return { lines, bands, states };
}

type StackProps = Omit<ChartProps<BestRow>, 'notYet'> & Pick<TimeFigureProps, 'id' | 'title' | 'note' | 'empty' | 'levels' | 'format' | 'height'>;

/** Shows shares of the arms over time as stacked areas. A short period with another leader stays visible. */
export function StackChart({ arms, rows, ...rest }: StackProps) {
  const timesMs = useMemo(() => timesOf(rows), [rows]);
  const drawn = useMemo(() => stackLines(arms, rows), [arms, rows]);
  return <TimeFigure {...rest} {...drawn} timesMs={timesMs} scale="unit" />;
}

export function BestChart({ notYet, ...rest }: ChartProps<BestRow>) {
  const least = stableProbability.value;
  return (
    <StackChart {...rest} id="best" title="Probability that each algorithm is the best" empty={rest.rows.length < 2 && notYet}
      note={`The scene is stable if the probability of its leader is at least ${least}.`} levels={[{ value: least, label: 'stable' }]}
      format={(value) => value.toFixed(3)} height={200} />
  );
}
