// The posteriors of a session over time: means, credible bands if the rows have intervals, and probabilities of being the best arm.
import { useMemo } from 'preact/hooks';
import { significant } from '../../format';
import { mean, type Posterior } from '../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, nsText } from '../numbers/log_cost';
import { thresholds } from '../state/account';
import { armStyle, hatched } from './colours';
import { type Band, fillOf, type Line, type Moment } from './plot';
import { TimeFigure } from './time_chart';
import { domainOf, range, type Range } from './view_state';

export interface SeriesRow {
  timeMs: number; // since 1970, by the daemon's clock
  beliefs: readonly (Posterior | undefined)[]; // in the order of the arms; undefined before an arm's first evidence
  best: readonly (number | undefined)[]; // P(best)
}

export interface PosteriorChartsProps {
  arms: readonly string[];
  rows: readonly SeriesRow[];
  rewardVersion: number;
  names: readonly string[]; // parts of file names
  moments?: readonly Moment[];
  domain?: Range; // range of time shared with other charts; absent: all times
  values?: readonly [number, number]; // range of values shared with other charts
  notYet?: string; // shown if there is nothing to draw
  csvHref?: string | undefined; // the URL of all posteriors as CSV
  assumed?: ReadonlySet<string>; // arms that were never measured; the range of the axis ignores them
}

const NOT_YET = 'Nothing has changed since the page was opened. Each change adds a point.';
const NONE: ReadonlySet<string> = new Set();
const PARTS = ['mean', 'low50', 'high50', 'low95', 'high95'] as const;
type Part = typeof PARTS[number];

// Costs fall as rewards rise, so the ends of an interval are exchanged.
const COST_PART: Readonly<Record<Part, Part>> = { mean: 'mean', low50: 'high50', high50: 'low50', low95: 'high95', high95: 'low95' };

function valueOf(posterior: Posterior | undefined, part: Part, tellsCosts: boolean): number | null {
  if (!posterior) return null;
  const own = tellsCosts ? COST_PART[part] : part;
  const reward = own === 'mean' ? mean(posterior) : posterior[own];
  return reward === undefined ? null : tellsCosts ? costNsOf(reward) : reward;
}

const hasIntervals = (rows: readonly SeriesRow[]) => rows.some(({ beliefs }) => beliefs.some((each) => each?.high95 !== undefined));

function bandLines(arms: readonly string[], rows: readonly SeriesRow[], tellsCosts: boolean, assumed: ReadonlySet<string>): { lines: Line[]; bands: Band[] } {
  const lines: Line[] = [];
  const bands: Band[] = [];
  const isBanded = hasIntervals(rows);
  arms.forEach((arm, i) => {
    const { colour, dash } = armStyle(arm, arms);
    const first = lines.length;
    for (const part of isBanded ? PARTS : PARTS.slice(0, 1)) {
      const values = rows.map(({ beliefs }) => valueOf(beliefs[i], part, tellsCosts));
      lines.push({ label: part === 'mean' ? arm : `${arm} ${part}`, values, colour, dash, arm, stepped: true, width: part === 'mean' ? 2 : 0, isAside: assumed.has(arm) });
    }
    if (isBanded) bands.push({ upper: first + 4, lower: first + 3, fill: fillOf(colour, 0.1) }, { upper: first + 2, lower: first + 1, fill: fillOf(colour, 0.2) });
  });
  return { lines, bands };
}

const noteOf = (rows: readonly unknown[], notYet = NOT_YET) => rows.length < 2 && notYet;

export function BandsChart({ arms, rows, rewardVersion, domain, notYet, assumed = NONE, ...rest }: PosteriorChartsProps) {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const drawn = useMemo(() => bandLines(arms, rows, tellsCosts, assumed), [arms, rows, tellsCosts, assumed]);
  return (
    <TimeFigure {...rest} {...drawn} id="bands" title={tellsCosts ? 'Estimated detection time of each algorithm' : 'Estimated reward of each algorithm'} timesMs={timesMs}
      note={hasIntervals(rows) ? 'Lines show means, and areas show 50 % and 95 % credible intervals.' : 'Lines show means.'} empty={noteOf(rows, notYet)} unit={tellsCosts ? 'ns' : ''} scale={tellsCosts ? 'log' : 'unit'}
      domain={range.value ?? domain ?? domainOf(timesMs, undefined)} format={tellsCosts ? nsText : (value) => significant(value)} height={260} />
  );
}

type BestRow = Pick<SeriesRow, 'timeMs' | 'best'>;

// Returns the index of the arm with the highest probability.
const leaderOf = ({ best }: BestRow) => best.reduce((most: number, p, i) => ((p ?? 0) > (best[most] ?? 0) ? i : most), 0);

// Stacks the arms from the bottom up. The current leader comes first, so that its height can be compared with the threshold. The
// other arms keep their order, because each order needs a new plot. Each period with one leader is a state.
function stackLines(arms: readonly string[], rows: readonly BestRow[]): { lines: Line[]; bands: Band[]; states: number[] } {
  const states = rows.map(leaderOf);
  const order = [states.at(-1) ?? 0, ...arms.keys()].filter((i, place, all) => all.indexOf(i) === place);
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
  return { lines, bands, states };
}

type StackProps = Pick<PosteriorChartsProps, 'arms' | 'names' | 'domain' | 'moments' | 'csvHref'> & Pick<Parameters<typeof TimeFigure>[0], 'id' | 'title' | 'note' | 'empty' | 'levels' | 'format' | 'height'> & { rows: readonly BestRow[] };

/** Shows shares of the arms over time as stacked areas. A short period with another leader stays visible. */
export function StackChart({ arms, rows, domain, ...rest }: StackProps) {
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const drawn = useMemo(() => stackLines(arms, rows), [arms, rows]);
  return <TimeFigure {...rest} {...drawn} timesMs={timesMs} scale="unit" domain={range.value ?? domain ?? domainOf(timesMs, undefined)} />;
}

/** Shows P(best) of each arm over time. */
export function BestChart({ notYet, rows, ...rest }: Omit<StackProps, 'id' | 'title' | 'note' | 'empty' | 'levels' | 'format' | 'height'> & { notYet?: string }) {
  const { stableProbability } = thresholds.value;
  return (
    <StackChart {...rest} rows={rows} id="best" title="Probability that each algorithm is the best" empty={noteOf(rows, notYet)}
      note={`The scene is stable if the probability of its leader is at least ${stableProbability}.`} levels={[{ value: stableProbability, label: 'stable' }]}
      format={(value) => value.toFixed(3)} height={200} />
  );
}
