// Compares live runs with the traces: the ranking of the algorithms, regret by replay, significance tests, and live against replayed
// regret.
import { byValue, rangeChart, type RangeRow } from '../charts/range_chart';
import { details, paragraph, small, verdict, type Child } from '../dom';
import { counted, mean, share, significant } from '../../../../../server/dashboard/src/format';
import { interval, microseconds, percent, probability, shareInterval, signedMs, times } from '../format';
import { regretsByPlayer, replayed, smallestProbability, type Agreement, type Comparison, type ExperimentDocument, type Truth } from '../model/experiment';
import { cell, columns, drawTable, noValue, text, textCell, type Cell, type Group } from '../table';
import { armChip } from './experiment_cells';
import type { Words } from './experiment_words';
import { REGRET_AXIS, regretRow, styleOf, type PlayerStyle } from './regret';

export function trueRanking({ truths }: ExperimentDocument, words: Words): HTMLElement | undefined {
  const places = truths[0]?.ranking.map((_, i) => text(`${i + 1}.`));
  if (!places) return undefined;
  const rows = truths.map((truth) => [cell(words.cellName(truth.cell)),
    ...truth.ranking.map(({ arm, mean_ns, ratio }) => textCell([armChip(arm), small(ratio === 1 ? microseconds(mean_ns) : times(ratio))])),
    cell(percent(truth.control_ratio - 1)), truth.players.length === 0 ? noValue() : cell(share(Math.max(0, truth.headroom)))]);
  return drawTable({ id: 'ranking', groups: [{ rows }], head: [columns('Cell', ...places, 'Same twice', 'Headroom')],
    caption: 'Mean time of each algorithm to update and search a frame, on the same frames: the fastest one’s time, and the ratios of the others to it' });
}

export function worthTable({ truths }: ExperimentDocument, words: Words): HTMLElement | null {
  const known = truths.flatMap(({ cell: name, worth }) => (worth ? [{ name, worth }] : []));
  if (known.length === 0) return null;
  const saved = (ms: number, of: number) => cell([signedMs(ms), small(percent(ms / of))], ms);
  const rows = known.map(({ name, worth: { best_arm, best_ms, always_ms, oracle_ms, decided_ms, nothing } }) => [cell(words.cellName(name)),
    cell([significant(best_ms), small(best_arm)], best_ms), cell(significant(always_ms), always_ms), cell(significant(oracle_ms), oracle_ms),
    cell(significant(decided_ms), decided_ms), saved(best_ms - oracle_ms, best_ms), saved(always_ms - oracle_ms, always_ms),
    saved(always_ms - decided_ms, always_ms), textCell(nothing ? 'nothing' : 'something')]);
  return drawTable({ id: 'worth-table', groups: [{ rows }], caption: 'Detection per frame in milliseconds, and what is saved',
    head: [columns('Cell', 'Best single', 'Always KDTree', 'Best sequence', words.policyShort('default'), 'Sequence against best single',
      'Sequence against KDTree', `${words.policyShort('default')} against KDTree`, text('Choosing is worth'))] });
}

function overviewRows(document: ExperimentDocument, words: Words): RangeRow[] {
  return [...regretsByPlayer(document)].map(([name, { isPolicy, regrets }]) => {
    const [low, middle, high] = [Math.min(...regrets), mean(regrets), Math.max(...regrets)];
    return regretRow(isPolicy ? words.policyTitle(name) : name, styleOf(name, isPolicy, document.own_policy), middle, [low, high],
      `mean ${percent(middle)}, from ${percent(low)} to ${percent(high)}`);
  });
}

function regretTable(truths: Truth[], words: Words): HTMLElement {
  const best = (truth: Truth) => Math.min(...truth.players.filter((each) => each.is_policy).map(({ regret }) => regret));
  const rows = truths[0]!.players.map(({ name, is_policy }, i) => [cell(is_policy ? words.policyTitle(name) : name),
    ...truths.map((truth) => {
      const { regret, ci95, after_start_up } = truth.players[i]!;
      return cell([percent(regret), small(interval(ci95)), small(percent(after_start_up))], regret, is_policy && regret === best(truth) ? 'best' : '');
    })]);
  return drawTable({ id: 'regret-table', groups: [{ rows }], head: [columns('Player', ...truths.map(({ cell: name }) => words.cellName(name)))],
    caption: 'Mean regret of each player over its games, including start and exploration; below it the 95 % interval over the scenes, and the mean after ' +
      'the start-up. The policy with the lowest regret in each cell is marked' });
}

export function regretCharts(document: ExperimentDocument, words: Words): Child[] {
  const truths = replayed(document);
  return truths.length === 0 ? [] : [
    rangeChart({ id: 'regret-over-cells', title: 'All cells together', xLabel: REGRET_AXIS, scale: 'symlog', rows: byValue(overviewRows(document, words)),
      note: 'Mark: mean over the cells. Bar: from the best cell to the worst one.' }),
    regretTable(truths, words)];
}

function comparisonGroup(title: string, comparisons: Comparison[], words: Words): Group {
  return { title, rows: comparisons.map((each) => [cell(words.policyTitle(each.baseline)), cell(String(each.pairs), each.pairs),
    cell(percent(each.difference), each.difference), cell(interval(each.ci95), each.ci95[0]), cell(probability(each.p), each.p),
    cell(probability(each.p_corrected), each.p_corrected), cell(significant(each.effect, 2), each.effect)]) };
}

const SIGNIFICANT = 0.05;

// Says how small p can be, because a few pairs cannot show a difference, however large it is.
export function smallestText(unit: string, family: Comparison[]): string {
  const { p, corrected, pairs } = smallestProbability(family);
  const limit = `With ${counted(pairs, 'pair', 'pairs')} (${unit}), p is at least ${probability(p)}, and at least ${probability(corrected)} after ` +
    `Holm’s correction for ${counted(family.length, 'comparison', 'comparisons')}.`;
  return corrected > SIGNIFICANT ? `${limit} So no corrected p can be small here: a large p does not show that two policies are equal.` : limit;
}

export function comparisonTables(document: ExperimentDocument, words: Words): Child[] {
  const { over_cells } = document;
  if (over_cells.length === 0) return [];
  const draw = (id: string, groups: Group[]) => drawTable({ id, groups,
    head: [columns('Baseline', 'Pairs', 'Difference', '95 % interval', 'p', 'p, corrected', 'Effect')],
    caption: `${words.policyTitle('default')} against each baseline, paired: the difference of regret (negative: AI Decides loses less), its 95 % bootstrap ` +
      'interval, p of Wilcoxon’s signed-rank test, the same with Holm’s correction, and the rank-biserial effect size' });
  const truths = replayed(document);
  const longest = truths.reduce((a, b) => (b.scenes > a.scenes ? b : a));
  return [draw('comparisons', [comparisonGroup('All cells; a pair per cell', over_cells, words)]), paragraph(smallestText('cells', over_cells)),
    details('Each cell', draw('comparisons-by-cell', truths.map((truth) =>
      comparisonGroup(`${words.cellName(truth.cell)}; a pair per scene`, truth.comparisons, words))),
    paragraph(smallestText('scenes of a cell', longest.comparisons)))];
}

const agreementStyle = (agrees: boolean): PlayerStyle =>
  (agrees ? { colour: 'var(--own)', symbol: 'circle', solid: true } : { colour: 'var(--paper)', symbol: 'triangle', solid: false });

function agreeCell(agrees: boolean, live: string, value: number, expected: string): Cell {
  return cell([live, small(verdict(agrees, `${agrees ? 'in' : 'outside'} ${expected}`))], value, agrees ? 'met' : 'missed');
}

function agreementRows(name: string, each: Agreement): { regret: RangeRow; share: RangeRow; row: Cell[] } {
  const [low, high] = each.replayed_active_share;
  return {
    regret: regretRow(name, agreementStyle(each.regret_agrees), each.regret, each.replayed_regret,
      `live ${percent(each.regret)}, replay ${interval(each.replayed_regret)}`),
    share: { name, ...agreementStyle(each.share_agrees), low: Math.max(100 * low, 0), value: 100 * each.active_share, high: Math.min(100 * high, 100),
      label: share(each.active_share), text: `live ${share(each.active_share)}, replay ${shareInterval(each.replayed_active_share)}` },
    row: [cell(name), cell(String(each.runs), each.runs),
      agreeCell(each.regret_agrees, percent(each.regret), each.regret, interval(each.replayed_regret)),
      agreeCell(each.share_agrees, share(each.active_share), each.active_share, shareInterval(each.replayed_active_share)),
      cell(percent(each.measured_regret), each.measured_regret)],
  };
}

export function liveAgainstReplay({ truths }: ExperimentDocument, words: Words): Child[] {
  const rows = truths.flatMap((truth) => truth.agreements.map((each) =>
    agreementRows(`${words.cellName(truth.cell)} · ${words.policyShort(each.policy)}`, each)));
  if (rows.length === 0) return [];
  const note = 'Mark: live runs. Bar: the 95 % interval that the replay predicts.';
  return [
    rangeChart({ id: 'agreement-regret', title: 'Regret', note, xLabel: REGRET_AXIS, scale: 'symlog', rows: rows.map((each) => each.regret) }),
    rangeChart({ id: 'agreement-share', title: 'Active share of the dominant algorithm', note, xLabel: 'Percent of the observation window', scale: 'linear',
      rows: rows.map((each) => each.share) }),
    drawTable({ id: 'agreement', caption: 'Live runs against replay under the same conditions', groups: [{ rows: rows.map(({ row }) => row) }],
      head: [columns('Cell and policy', 'Live runs', 'Regret at the trace’s costs', 'Active share', 'Regret as the clock measured it')] })];
}
