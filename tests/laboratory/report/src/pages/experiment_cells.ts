// The results of live runs per cell and policy: dominant algorithms, the paper's tables, shares of time, verdicts.
import { chip } from '../charts/figure';
import { stackedBars } from '../charts/stacked_bars';
import { h, small, type Child } from '../dom';
import { grouped, share, significant } from '../../../../../server/dashboard/src/format';
import { microseconds, spread } from '../format';
import { activeShares, FRAME_PARTS, frameTime, runsOf, TIME_PARTS, timeParts, truthOf, VERDICTS, verdictCounts, type ExperimentDocument, type ExperimentRow, type PaperCell } from '../model/experiment';
import { colourOf } from '../../../../../server/dashboard/src/palette';
import { kindColour } from '../palette';
import { cell, columns, drawTable, text, textCell, type Cell, type Group } from '../table';
import { sceneName, type Words } from './experiment_words';

export const armChip = (arm: string, content = arm) => chip(content, colourOf(arm));

const policiesOf = ({ options, rows }: ExperimentDocument) =>
  options.policies.filter((policy) => rows.some((row) => row.policy === policy));

function dominanceCell(document: ExperimentDocument, row: ExperimentRow): Cell {
  const fastest = truthOf(document, row.cell)?.ranking[0]?.arm;
  const truth = fastest === undefined ? '' : fastest === row.dominant ? '; truly the fastest' : `; truly fastest: ${fastest}`;
  return textCell([...row.dominant_runs.map(({ arm, runs }) => [armChip(arm, `${arm} ${runs}/${row.runs}`), ' ']),
    small(`active ${share(row.active_percent / 100)}${truth}`)]);
}

export function dominanceGrid(document: ExperimentDocument, words: Words): HTMLElement[] {
  const sizes = [...new Set(document.rows.map(({ objects }) => objects))].sort((a, b) => a - b);
  return policiesOf(document).map((policy, number) => {
    const rows = document.rows.filter((row) => row.policy === policy);
    const body = [...new Set(rows.map(({ scene }) => scene))].map((scene) => [cell(sceneName(scene)), ...sizes.map((size) => {
      const row = rows.find((each) => each.scene === scene && each.objects === size);
      return row ? dominanceCell(document, row) : textCell('–');
    })]);
    return drawTable({ id: `dominance-${number + 1}`, groups: [{ rows: body }],
      caption: `${words.policyTitle(policy)}: the algorithm that was active longest, and in how many runs`,
      head: [columns('Scenario', ...sizes.map((size) => text(`${grouped(size)} objects`)))] });
  });
}

const paperOf = ({ paper = [] }: ExperimentDocument, row: ExperimentRow) =>
  paper.find(({ scene, objects }) => scene === row.scene && objects === row.objects);

function table3Row(row: ExperimentRow, paper?: PaperCell): Cell[] {
  return [cell(sceneName(row.scene)), cell(grouped(row.objects), row.objects), textCell(row.dominance, 'text wrap'),
    textCell(row.interpretation, 'text wrap'), textCell(paper?.dominance ?? '–', 'text wrap'), textCell(paper?.interpretation ?? '–', 'text wrap')];
}

// Returns the paper's figure as text, or a dash if the paper has none of the same quantity: μ* and n* of other policies are posteriors of
// another reward.
export function paperFigure(row: ExperimentRow, paper: PaperCell | undefined, key: 'switches' | 'active_percent' | 'mu' | 'n', decimals: number): string {
  const compares = row.policy === 'paper' || (key !== 'mu' && key !== 'n');
  return paper && compares ? spread(paper[key], paper[`${key}_sd`], 2, decimals) : '–';
}

function table4Row(row: ExperimentRow, paper?: PaperCell): Cell[] {
  const dominantRuns = row.dominant_runs[0]!.runs;
  const figure = (key: 'switches' | 'active_percent' | 'mu' | 'n', count: number, decimals: number) => cell(
    [spread(row[key], row[`${key}_sd`], count, decimals), small(paperFigure(row, paper, key, decimals))], row[key]);
  return [cell(sceneName(row.scene)), cell(grouped(row.objects), row.objects),
    textCell([armChip(row.dominant), small(paper?.dominant ?? '–')]),
    cell([`${dominantRuns} / ${row.runs}`, small(paper ? `${paper.dominant_runs} / ${paper.runs}` : '–')]),
    figure('switches', row.runs, 1), figure('active_percent', dominantRuns, 1), figure('mu', dominantRuns, 3), figure('n', dominantRuns, 1)];
}

export function paperTables(document: ExperimentDocument, words: Words): HTMLElement[] {
  const groups = (toRow: (row: ExperimentRow, paper?: PaperCell) => Cell[]): Group[] => policiesOf(document).map((policy) => ({
    title: `Policy ${words.policyTitle(policy)}`,
    rows: document.rows.filter((row) => row.policy === policy).map((row) => toRow(row, paperOf(document, row))),
  }));
  return [
    drawTable({ id: 'table-3', caption: 'Table 3. Dominant algorithms across the runs of each scenario and size', groups: groups(table3Row),
      head: [columns('Scenario', 'Objects', text('Dominance frequency'), text('Interpretation'), text('Paper: frequency'), text('Paper: interpretation'))] }),
    drawTable({ id: 'table-4', groups: groups(table4Row), caption: 'Table 4. Switches over all runs; active time, μ* and n* over the runs in which ' +
      'the arm dominated; mean ± sample standard deviation. The paper’s figure is below each figure; μ* and n* only with its own policy, because other ' +
      'policies measure other quantities',
      head: [columns('Scenario', 'Obj.', text('Dominant'), 'Freq.', 'Switches', 'Active (%)', 'μ*', 'n*')] })];
}

const rowName = (words: Words, row: ExperimentRow) => `${words.cellName(row.cell)} · ${words.policyShort(row.policy)}`;

export function activeShareChart(document: ExperimentDocument, words: Words): HTMLElement {
  return stackedBars({ id: 'active-shares', title: 'Active share of each algorithm', note: 'Share of the observation window; mean over the runs.',
    kinds: document.arms.map((name) => ({ name, colour: colourOf(name) })),
    rows: document.rows.map((row) => ({ name: rowName(words, row), values: activeShares(document, runsOf(document, row)) })) });
}

const VERDICT_TITLES = ['Nothing learnt', 'Stable', 'Tie', 'Ambiguous', 'Degraded'];
export const verdictKinds = VERDICT_TITLES.map((name, index) => ({ name, colour: kindColour(index) }));

export function verdictChart(document: ExperimentDocument, words: Words): HTMLElement {
  return stackedBars({ id: 'verdict-shares', title: 'Verdicts of the decider', note: 'Share of the decisions in the observation window.',
    kinds: VERDICTS.map((_, index) => verdictKinds[index]!),
    rows: document.rows.map((row) => ({ name: rowName(words, row), values: verdictCounts(runsOf(document, row)) })) });
}

function timeRow(document: ExperimentDocument, words: Words, row: ExperimentRow): Cell[] {
  const runs = runsOf(document, row);
  const parts = timeParts(runs);
  const frames = frameTime(parts);
  const sum = (value: (run: (typeof runs)[number]) => number) => runs.reduce((total, run) => total + value(run), 0);
  const decisionNs = parts[7]! / Math.max(sum(({ decisions }) => decisions), 1);
  const longestNs = Math.max(...runs.map((run) => run.time.longest_decision_ns));
  return [cell(words.cellName(row.cell)),
    ...parts.map((ns, i) => cell(`${significant((100 * ns) / frames)} %`, ns / frames, i === FRAME_PARTS ? 'first' : '')),
    cell(microseconds(decisionNs), decisionNs, 'first'), cell(microseconds(longestNs), longestNs), cell(grouped(sum((run) => run.dropped_frames)))];
}

export function timeSection(document: ExperimentDocument, words: Words): Child[] {
  const kinds = TIME_PARTS.map(([, name], index) => ({ name, colour: kindColour(index) }));
  return [
    stackedBars({ id: 'time-shares', title: 'The frame thread’s time', note: 'Means over the runs. The table has all parts, including those that are too narrow here.',
      kinds: kinds.slice(0, FRAME_PARTS),
      rows: document.rows.map((row) => ({ name: rowName(words, row), values: timeParts(runsOf(document, row)).slice(0, FRAME_PARTS) })) }),
    drawTable({ id: 'time-table', caption: 'Percent of the frames’ time. Intake, selector and shadow lane run on other threads at the same time, and ' +
      'do not lengthen the frame',
      head: [columns('', { content: 'Frame thread', className: 'first', span: FRAME_PARTS }, { content: 'Other threads', className: 'first', span: 3 },
        { content: 'Selector', className: 'first', span: 2 }, ''),
      columns('Cell', ...TIME_PARTS.map(([, content], i) => ({ content, className: i === FRAME_PARTS ? 'first' : '' })),
        { content: 'a decision', className: 'first' }, 'longest', 'Samples lost')],
      groups: policiesOf(document).map((policy) => ({ title: `Policy ${words.policyTitle(policy)}`,
        rows: document.rows.filter((row) => row.policy === policy).map((row) => timeRow(document, words, row)) })) })];
}

export const armLegend = ({ arms }: ExperimentDocument) => h('p', { class: 'chips' }, ...arms.map((arm) => armChip(arm)));
