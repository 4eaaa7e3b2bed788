// The page of `sweepstake-lab replay`.
import { byValue, rangeChart } from '../charts/range_chart';
import { chip } from '../charts/figure';
import { reliabilityChart } from '../charts/reliability_chart';
import { stackedBars } from '../charts/stacked_bars';
import { headline, list, paragraph, small, verdict, type Child } from '../dom';
import { counted, grouped, mean, share, significant } from '../../../../../server/dashboard/src/format';
import { interval, percent, probability, signedMs, spread } from '../format';
import { VERDICTS } from '../model/experiment';
import { costsOf, fileName, isFixed, meanRegretOf, type ReplayDocument, type ReplayRow } from '../model/replay';
import { commandLine, type Page } from '../page';
import { colourOf } from '../../../../../server/dashboard/src/palette';
import { cell, columns, drawTable, noValue, text, textCell, type Cell } from '../table';
import { verdictKinds } from './experiment_cells';
import { REGRET_AXIS, REGRET_SCALE, regretRow, styleOf } from './regret';

const sceneOf = ({ scenes = [] }: ReplayDocument, costs: string) => scenes.find((scene) => scene.costs === costs);
const rowsOf = ({ rows }: ReplayDocument, costs: string) => rows.filter((row) => row.costs === costs);
const firstPolicy = ({ rows }: ReplayDocument) => rows.find(({ policy }) => !isFixed(policy))?.policy;
const ownOf = (document: ReplayDocument) => document.own_policy ?? 'default';

function results(document: ReplayDocument): Child[] {
  const policy = firstPolicy(document);
  const ours = policy && meanRegretOf(document, policy);
  const papers = policy === 'paper' ? undefined : meanRegretOf(document, 'paper');
  const traces = costsOf(document).length;
  return [
    typeof ours === 'number' && headline(percent(ours), `of frame time is the mean loss of the policy ${policy} against the best fixed algorithm over ` +
      `${counted(traces, 'trace', 'traces')} and ${counted(document.seeds, 'seed', 'seeds')}, including start and exploration. Below 0 it is faster than any ` +
      `single algorithm.${papers === undefined ? '' : ` The policy paper loses ${percent(papers)}.`}`)];
}

function goals({ goals = [] }: ReplayDocument): Child[] {
  if (goals.length === 0) return [];
  const rows = goals.map(({ goal, limit_text, reached, met, cells }) => [cell(goal), textCell(limit_text),
    reached === null ? noValue() : cell(significant(reached), reached),
    textCell(cells.length === 0 ? '–' : `${cells.filter((each) => each.met).length} of ${cells.length}, worst ${cells[0]!.cell}`),
    reached === null ? textCell('no data for this goal') : cell(verdict(met, met ? 'met' : 'missed'), Number(met), met ? 'met' : 'missed')]);
  return [drawTable({ id: 'goals', caption: 'The goals that this run can judge.', groups: [{ rows }],
    head: [columns('Goal', text('Limit'), 'Reached', text('Cells'), 'Result')] })];
}

function regretChart(document: ReplayDocument, costs: string, number: number): HTMLElement {
  const scene = sceneOf(document, costs);
  const first = rowsOf(document, costs)[0]!;
  const rows = rowsOf(document, costs).map(({ policy, regret_best_fixed: regret, ci95, regret_after_start }) => regretRow(policy,
    styleOf(policy, !isFixed(policy), ownOf(document)), regret, ci95, `${percent(regret)} (95 %: ${interval(ci95)})\nafter start-up ${percent(regret_after_start)}`));
  return rangeChart({ id: `regret-${number + 1}`, title: fileName(costs), rows: byValue(rows), xLabel: `${REGRET_AXIS}; bar: 95 % interval`, scale: 'symlog',
    note: `The best sequence of algorithms would gain ${percent(first.headroom)} including its switches, ${percent(first.headroom_frame)} without their cost` +
      (scene ? `; noise floor (one algorithm measured twice) ${percent(Math.abs(scene.control_regret))}` : '') });
}

// Shows for each policy the mean over the traces, and the range from the best trace to the worst.
function overview(document: ReplayDocument): HTMLElement | null {
  if (costsOf(document).length < 2) return null;
  const rows = [...new Set(document.rows.map(({ policy }) => policy))].map((policy) => {
    const regrets = document.rows.filter((row) => row.policy === policy).map((row) => row.regret_best_fixed);
    const [low, high] = [Math.min(...regrets), Math.max(...regrets)];
    return regretRow(policy, styleOf(policy, !isFixed(policy), ownOf(document)), mean(regrets), [low, high],
      `mean ${percent(mean(regrets))}, from ${percent(low)} to ${percent(high)}`);
  });
  return rangeChart({ id: 'regret-over-traces', title: 'All traces together', xLabel: REGRET_AXIS, scale: 'symlog', rows: byValue(rows),
    note: 'Mark: mean over the traces. Bar: from the best trace to the worst one.' });
}

const optional = (value: number | null, show: (value: number) => string) => (value === null ? noValue() : cell(show(value), value));

function rowCells(row: ReplayRow): Cell[] {
  const { against_paper: paper } = row;
  return [cell(row.policy), cell([percent(row.regret_best_fixed), small(interval(row.ci95))], row.regret_best_fixed),
    optional(row.regret_after_start, percent), cell(percent(row.regret_oracle), row.regret_oracle),
    optional(row.headroom_captured, (value) => `${grouped(100 * value)} %`), cell(spread(row.switches, 0, 1, 1), row.switches),
    cell(share(row.active_share), row.active_share), textCell(chip(row.dominant, colourOf(row.dominant))),
    optional(row.bail_outs, (value) => significant(value)), optional(row.first_best_s, (value) => `${significant(value)} s`),
    cell(share(row.shadow_share), row.shadow_share),
    paper ? cell([percent(paper.difference), small(`${interval(paper.ci95)}, p ${probability(paper.wilcoxon_p)}`)], paper.difference) : noValue()];
}

function rowTable(document: ReplayDocument): HTMLElement {
  return drawTable({ id: 'rows', caption: `Mean of ${counted(document.seeds, 'game', 'games')} of each policy on each trace, with the 95 % interval. Captured: share of the oracle’s gain that the policy reached.`,
    head: [columns('Policy', 'Regret', 'After start-up', 'Against the oracle', 'Captured', 'Switches', 'Active share', text('Dominant'), 'Bail-outs',
      'First on the best', 'Shadow lane', 'Against the paper')],
    groups: costsOf(document).map((costs) => ({ title: costs, rows: rowsOf(document, costs).map(rowCells) })) });
}

function verdicts(document: ReplayDocument): Child[] {
  const known = document.rows.filter((row) => Object.values(row.verdicts).some((value) => value > 0));
  return known.length === 0 ? [] : [stackedBars({ id: 'verdict-shares', title: 'Verdicts of the policies', note: 'Share of the decisions with each verdict.', kinds: verdictKinds,
    rows: known.map(({ costs, policy, verdicts: counts }) => ({ name: `${fileName(costs)} · ${policy}`, values: VERDICTS.map((name) => counts[name] ?? 0) })) })];
}

function msCells({ policy, ms_per_frame: ms, regret_detection: ofDetection, regret_60hz: of60Hz }: ReplayRow): Cell[] {
  if (!ms) return [];
  const against = (other: number | null) => optional(other === null ? null : ms.detection - other, signedMs);
  return [cell(policy), cell(significant(ms.detection), ms.detection), cell(signedMs(ms.regret), ms.regret), cell(percent(ofDetection ?? null), ofDetection),
    cell(percent(of60Hz ?? null), of60Hz), against(ms.worst), against(ms.median), against(ms.paper), cell(significant(ms.lane), ms.lane)];
}

function msTitle(document: ReplayDocument, costs: string, { best, median, worst }: NonNullable<ReplayRow['ms_per_frame']>): string {
  const objects = sceneOf(document, costs)?.objects;
  return `${fileName(costs)}: ${objects === undefined ? '' : `${grouped(objects)} objects, `}best fixed algorithm ${significant(best)} ms, ` +
    `median ${significant(median)} ms, worst ${significant(worst)} ms`;
}

function msTable(document: ReplayDocument): Child[] {
  const groups = costsOf(document).flatMap((costs) => {
    const rows = rowsOf(document, costs).filter((row) => row.ms_per_frame);
    return rows.length === 0 ? [] : [{ title: msTitle(document, costs, rows[0]!.ms_per_frame!), rows: rows.map(msCells) }];
  });
  return groups.length === 0 ? [] : [drawTable({ id: 'milliseconds', caption: 'Milliseconds of detection per frame, as recorded.', groups,
    head: [columns('Policy', 'Detection', 'Regret', 'Of detection', 'Of a 60 Hz frame', 'Against the worst', 'Against the median', 'Against the paper',
      'Shadow lane')] })];
}

function calibration(document: ReplayDocument): Child[] {
  const known = document.calibration ?? [];
  if (known.length === 0) return [];
  return [reliabilityChart({ id: 'reliability', title: 'How often the leader was the fastest', xLabel: 'Probability that the policy gave its leader',
    yLabel: 'Share of decisions in which it was the fastest', note: 'The fastest on the frames since the previous decision. The area of a mark grows with the ' +
      'number of decisions. On the dashed line the stated probabilities are right; below it, they are too high.',
    lines: known.map(({ policy, bins }) => ({ name: policy, colour: styleOf(policy, true, ownOf(document)).colour, points: bins.map((bin) => ({
      predicted: bin.predicted, observed: bin.best, weight: bin.decisions, text: `stated ${share(bin.predicted)}, was the fastest in ${share(bin.best)}, and at most ` +
        `0.5 % slower in ${share(bin.best_or_tie)} of ${grouped(bin.decisions)} decisions` })) })) }),
  drawTable({ id: 'calibration', caption: 'The figures of the chart above.', head: [columns('Probability', 'Decisions', 'Stated on average', 'Was the fastest', 'At most 0.5 % slower')],
    groups: known.map(({ policy, error, bins }) => ({ title: `${policy}: mean error ${share(error)}`, rows: bins.map((bin) => [
      cell(`${significant(100 * bin.low, 2)} to ${significant(100 * bin.high, 2)} %`, bin.low), cell(grouped(bin.decisions), bin.decisions),
      cell(share(bin.predicted), bin.predicted), cell(share(bin.best), bin.best), cell(share(bin.best_or_tie), bin.best_or_tie)]) })) })];
}

function sceneTable({ scenes = [] }: ReplayDocument): Child {
  const seconds = (ns: number) => cell(`${significant(ns * 1e-9)} s`, ns);
  return scenes.length > 0 && drawTable({ id: 'scenes', caption: 'The traces as the games played them. Noise floor: difference of two measurements of the same algorithm.',
    head: [columns('Trace', 'Algorithms', 'Frames of the trace', 'Frames of a game', 'Mean frame', 'Run', 'Pass', 'Noise floor')],
    groups: [{ rows: scenes.map((scene) => [cell(scene.costs), cell(String(scene.arms.length)), cell(grouped(scene.trace_frames)), cell(grouped(scene.frames)),
      cell(`${significant(scene.frame_ns * 1e-6)} ms`, scene.frame_ns), seconds(scene.run_ns), seconds(scene.pass_ns), cell(percent(Math.abs(scene.control_regret)))]) }] });
}

export function replayPage(document: ReplayDocument): Page {
  const traces = costsOf(document);
  return {
    title: 'Sweepstake replay',
    lead: [paragraph('Policies played recorded cost traces in virtual time. A trace has the cost of every algorithm on every frame, so each decision can be ' +
      'compared with the cost of the other algorithms.')],
    sections: [
      { id: 'results', heading: 'Results', body: results(document) },
      { id: 'judged', heading: 'Goals', body: goals(document) },
      { id: 'regret', heading: 'What each policy loses', body: [
        paragraph(REGRET_SCALE),
        overview(document), ...traces.map((costs, i) => regretChart(document, costs, i))] },
      { id: 'policies', heading: 'Policies', body: [rowTable(document)] },
      { id: 'ms', heading: 'In milliseconds', body: msTable(document) },
      { id: 'sure', heading: 'How reliable P(best) is', body: calibration(document) },
      { id: 'verdicts', heading: 'Verdicts', body: verdicts(document) },
      { id: 'traces', heading: 'Traces', body: [sceneTable(document), document.command_line && commandLine(document.command_line)] },
      { id: 'method', heading: 'How it was measured', body: [list(['All policies played the same frames with the same seeds. Intervals are bootstrapped over ' +
        'the seeds; p is from Wilcoxon’s signed-rank test.', 'Recorded times are multiplied by one factor, so that the mean frame of the best fixed ' +
        'algorithm has the length in the column “Mean frame” of the table of traces.'])] },
    ],
  };
}
