// Charts of a scene or session over time, from the daemon's history: the best algorithms, what ran, and frame and detection times.
import { useMemo } from 'preact/hooks';
import { significant } from '../../format';
import { HistoryKind, type HistoryPoint, type HistorySeries } from '../../gen/sweepstake/v1/history_pb';
import type { RegimePosterior, SceneActivity } from '../../gen/sweepstake/v1/posteriors_pb';
import { armStyle } from '../charts/colours';
import { type Band, fillOf, type Line, type Moment } from '../charts/plot';
import { BestChart, StackChart } from '../charts/posterior_charts';
import { TimeFigure } from '../charts/time_chart';
import { domainOf, period, range, type Range, timesOf } from '../charts/view_state';
import { NS_PER_MS } from '../numbers/log_cost';
import { percentiles } from '../numbers/histogram';
import { measuredIn } from '../numbers/use';
import { csvUrl } from '../parts/download';
import { Choice } from '../parts/filter';
import { Failure, Loading } from '../parts/states';
import { route } from '../state/route';
import { type HistorySelection, useHistory } from '../transport/history';
import { BUDGETS, PERCENTILES } from './session/cost_charts';

const MAX_POINTS = 300;
const NOT_YET = 'The history has no measurements in this period. Points appear about 20 seconds after they are measured.';
const us = (value: number) => `${significant(value)} µs`;

const armsOf = (points: readonly HistoryPoint[]) => [...new Set(points.flatMap(({ arms, activity }) => [...arms.map(({ arm }) => arm), ...(activity?.arms ?? [])]))].sort();

function regimeIn({ total, regimes }: SceneActivity, chosen: string): RegimePosterior | undefined {
  if (chosen === 'all' || regimes.length === 0) return total;
  return chosen === '' ? regimes.find(({ isPresent }) => isPresent) ?? total : regimes[Number(chosen) - 1];
}

interface Rows { timesMs: number[]; points: readonly HistoryPoint[]; arms: string[] }

function beliefsOf({ points, arms }: Rows, chosen: string): (RegimePosterior['arms'][number] | undefined)[][] {
  return points.map(({ activity }) => {
    const regime = activity && regimeIn(activity, chosen);
    return arms.map((arm) => regime?.arms[activity!.arms.indexOf(arm)]);
  });
}

function costLines({ arms }: Rows, beliefs: ReturnType<typeof beliefsOf>): { lines: Line[]; bands: Band[] } {
  const bands: Band[] = [];
  const lines = arms.flatMap((arm, i): Line[] => {
    const { colour, dash } = armStyle(arm, arms);
    bands.push({ upper: 3 * i + 2, lower: 3 * i + 1, fill: fillOf(colour, 0.12) });
    return (['costUs', 'lowUs', 'highUs'] as const).map((part) =>
      ({ label: part === 'costUs' ? arm : `${arm} ${part}`, values: beliefs.map((row) => row[i]?.[part] || null), colour, dash, arm, stepped: true, width: part === 'costUs' ? 2 : 0 }));
  });
  return { lines, bands };
}

const percentileLines = (points: readonly HistoryPoint[], part: 'frameTimeNs' | 'detectionTimeNs', unitNs: number): Line[] => {
  const values = points.map((point) => percentiles(point[part]));
  return PERCENTILES.map((line, i) => ({ ...line, values: values.map((each) => (each ? each[i]! / unitNs : null)), stepped: true }));
};

const SAVINGS = [['againstInitialUs', 'against the first algorithm', 'var(--arm-4)'], ['againstSingleUs', 'against the best single one', 'var(--arm-2)'], ['againstReferenceUs', 'against KDTree', 'var(--arm-3)']] as const;
const savingLines = (points: readonly HistoryPoint[]): Line[] => {
  const uses = points.map(measuredIn);
  return SAVINGS.map(([part, label, colour]) => ({ label, colour, stepped: true, values: uses.map((use) => (use?.[part] === undefined ? null : use[part] / use.frameCount)) }));
};

const shares = ({ points, arms }: Rows): (number | undefined)[][] => points.map((point) => {
  const counts = arms.map((arm) => Number(point.arms.find((each) => each.arm === arm)?.activeFrameCount ?? 0));
  const total = counts.reduce((sum, count) => sum + count, 0);
  return counts.map((count) => (total > 0 ? count / total : undefined));
});

function Beliefs({ rows, common }: { rows: Rows; common: Common & { empty: string | false } }) {
  const chosen = route.value.query.get('regime') ?? '';
  const beliefs = useMemo(() => beliefsOf(rows, chosen), [rows, chosen]);
  const best = useMemo(() => rows.timesMs.map((timeMs, i) => ({ timeMs, best: beliefs[i]!.map((belief) => belief?.bestProbability) })), [beliefs]);
  const costs = useMemo(() => costLines(rows, beliefs), [beliefs]);
  const count = Math.max(0, ...rows.points.map(({ activity }) => activity?.regimes.length ?? 0));
  const numbers = Array.from({ length: count }, (_, i) => [String(i + 1), `${i + 1}`] as const);
  return (
    <>
      {count > 0 && <div class="tools"><Choice label="Regime" parameter="regime" options={[['', 'the present one'], ['all', 'all together'], ...numbers]} /></div>}
      <BestChart {...common} arms={rows.arms} rows={best} notYet={NOT_YET} />
      <TimeFigure {...common} {...costs} id="costs" title="Estimated cost of each algorithm" timesMs={rows.timesMs} unit="(µs)" scale="log" format={us} height={260}
        note="Detection time per frame: estimate and 95 % credible interval, as the session that was connected the longest believed." />
    </>
  );
}

interface Common { csvHref: string; names: readonly string[]; domain: Range; moments: readonly Moment[] }

function Charts({ series, ...rest }: Common & { series: HistorySeries | undefined }) {
  const rows = useMemo((): Rows => {
    const points = series?.points ?? [];
    return { points, arms: armsOf(points), timesMs: points.map(({ unixMs }) => Number(unixMs)) };
  }, [series]);
  const drawn = useMemo(() => ({ frame: percentileLines(rows.points, 'frameTimeNs', NS_PER_MS), detection: percentileLines(rows.points, 'detectionTimeNs', 1000), saved: savingLines(rows.points), shares: shares(rows) }), [rows]);
  const ran = useMemo(() => rows.timesMs.map((timeMs, i) => ({ timeMs, best: drawn.shares[i]! })), [drawn]);
  const common = { ...rest, empty: rows.points.length === 0 && NOT_YET };
  const hasBeliefs = rows.points.some(({ activity }) => activity);
  return (
    <>
      {hasBeliefs && <Beliefs rows={rows} common={common} />}
      <StackChart {...common} id="ran" title="What ran" arms={rows.arms} rows={ran} format={(value) => `${significant(100 * value)} %`} height={140}
        note="Share of the frames in which each algorithm ran." />
      <div class="beside">
        <TimeFigure {...common} id="frame-history" title="Frame time" timesMs={rows.timesMs} lines={drawn.frame} levels={BUDGETS} unit="(ms)" scale="zero" format={(value) => `${significant(value)} ms`} height={160} />
        <TimeFigure {...common} id="detection-history" title="Detection time" timesMs={rows.timesMs} lines={drawn.detection} unit="(µs)" scale="log" format={us} height={160} />
      </div>
      <TimeFigure {...common} id="saved" title="Saved per frame" timesMs={rows.timesMs} lines={drawn.saved} unit="(µs)" scale="signed" format={us} height={140}
        note="Detection time per frame that the choice of algorithms saved, with the cost of switches. Below zero: lost." />
    </>
  );
}

/** The history of one scene or session. */
export function OverTime({ selection, names, moments = [] }: { selection: HistorySelection; names: readonly string[]; moments?: readonly Moment[] }) {
  const { series, wasRead, error } = useHistory(selection, { maxPoints: MAX_POINTS });
  const own = series[0];
  const times = timesOf(period.value, range.value, Date.now());
  const firstMs = Number(own?.points[0]?.unixMs ?? 0);
  const domain = range.value ?? domainOf([Math.max(times.fromUnixMs, firstMs), Date.now()], undefined);
  if (error && !own) return <Failure what="The history" error={error} onRetry={() => location.reload()} />;
  if (!wasRead && !own) return <Loading what="the history" />;
  const csvHref = csvUrl('history', { ...selection, kind: `HISTORY_KIND_${HistoryKind[selection.kind]}`, fromUnixMs: String(times.fromUnixMs), untilUnixMs: String(times.untilUnixMs), maxPoints: 10_000 }); // no points are added up
  return <Charts series={own} csvHref={csvHref} names={names} domain={domain} moments={moments} />;
}
