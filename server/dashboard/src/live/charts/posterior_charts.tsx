// The posteriors of a scene or session over time: means, credible bands if the rows have intervals, probabilities of being the best
// arm, and expected loss.
import { useMemo } from 'preact/hooks';
import { share, significant } from '../../format';
import { mean, type Posterior } from '../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, nsText } from '../numbers/log_cost';
import type { SeriesRow } from '../state/history';
import { thresholds } from '../state/account';
import { armStyle, hatched } from './colours';
import { type Band, fillOf, type Line, type Moment } from './plot';
import { TimeFigure } from './time_chart';
import { domainOf, range, type Range } from './view_state';

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

/** Returns the lowest and highest value of the bands, for an axis that several charts share. */
export function bandRange(rows: readonly SeriesRow[], rewardVersion: number): [number, number] {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const known = rows.flatMap(({ beliefs }) => beliefs).filter((posterior) => posterior !== undefined);
  return [
    Math.min(...known.map((posterior) => valueOf(posterior, 'low95', tellsCosts)!)),
    Math.max(...known.map((posterior) => valueOf(posterior, 'high95', tellsCosts)!)),
  ];
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

/** Shows P(best) of each arm over time as stacked areas. A short period with another leader stays visible. */
export function BestChart({ arms, rows, domain, notYet, names, csvHref, moments = [] }: Omit<PosteriorChartsProps, 'rows'> & { rows: readonly BestRow[] }) {
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const drawn = useMemo(() => stackLines(arms, rows), [arms, rows]);
  const { stableProbability } = thresholds.value;
  return (
    <TimeFigure {...drawn} id="best" title="Probability that each algorithm is the best" names={names} csvHref={csvHref} timesMs={timesMs} moments={moments}
      note={`The scene is stable if the probability of its leader is at least ${stableProbability}.`} empty={noteOf(rows, notYet)} scale="unit"
      levels={[{ value: stableProbability, label: 'stable' }]} domain={range.value ?? domain ?? domainOf(timesMs, undefined)}
      format={(value) => value.toFixed(3)} height={200} />
  );
}

export function LossChart({ rows, domain, notYet, names, moments = [] }: PosteriorChartsProps) {
  const timesMs = useMemo(() => rows.map(({ timeMs }) => timeMs), [rows]);
  const lines = useMemo((): Line[] => [{
    label: 'expected loss', values: rows.map(({ expectedLossRatio }) => expectedLossRatio ?? null), colour: 'var(--accent)', stepped: true,
  }], [rows]);
  const { tieLossRatio } = thresholds.value;
  return (
    <TimeFigure id="loss" title="Expected loss of choosing the leader" names={names} timesMs={timesMs} lines={lines} moments={moments}
      note={`A scene that is not stable is a tie if this loss is at most ${share(tieLossRatio)}. The choice of the algorithm then hardly matters.`} empty={noteOf(rows, notYet)} scale="zero"
      levels={[{ value: tieLossRatio, label: 'a tie' }]} domain={range.value ?? domain ?? domainOf(timesMs, undefined)} format={share} height={140} />
  );
}
