// The timeline of each run: which algorithm was active when, and the posteriors. Times are minutes before the time scale is applied, as in
// the paper.
import { panels, type Panel } from '../charts/panels';
import { timelineChart, type Lane } from '../charts/timeline_chart';
import { share, significant } from '../../../../../server/dashboard/src/format';
import type { ExperimentDocument, Run } from '../model/experiment';
import { colourOf } from '../../../../../server/dashboard/src/palette';
import { armLegend } from './experiment_cells';
import type { Words } from './experiment_words';

const minutes = ({ time_scale }: Run, seconds: number) => (seconds * time_scale) / 60;
const minutesText = (run: Run, seconds: number) => `${minutes(run, seconds).toFixed(1)} min`;
const runName = (words: Words, { policy, run }: Run) => `${words.policyShort(policy)} ${run}`;

function laneOf(words: Words, run: Run): Lane {
  return {
    name: runName(words, run),
    stretches: run.periods.map(({ arm, from_s, to_s, reason }) => ({
      from: minutes(run, from_s), to: minutes(run, to_s), name: run.arms[arm]!, colour: colourOf(run.arms[arm]!), faint: from_s < run.exploration_s,
      text: `${run.arms[arm]}\nfrom ${minutesText(run, from_s)} to ${minutesText(run, to_s)}${reason ? ` (${reason})` : ''}`,
    })),
    strokes: run.held_back_s.map((time) => minutes(run, time)),
    crosses: run.bail_outs.map(({ time_s, arm }) => ({ at: minutes(run, time_s), text: `bail-out from ${run.arms[arm]} at ${minutesText(run, time_s)}` })),
  };
}

export function switchTimelines(document: ExperimentDocument, words: Words): HTMLElement[] {
  const charts = document.cells.map(({ cell }, number) => ({ number, cell, lanes: document.runs.filter((run) => run.cell === cell).map((run) => laneOf(words, run)) }));
  return [armLegend(document), ...charts.filter(({ lanes }) => lanes.length > 0).map(({ number, cell, lanes }) =>
    timelineChart({ id: `timeline-${number + 1}`, title: words.cellName(cell), xLabel: 'Minutes × time scale, as in the paper', lanes }))];
}

function panelOf(words: Words, run: Run): Panel {
  const dominantShare = run.active_shares[run.arms.indexOf(run.dominant)] ?? 0;
  return {
    title: runName(words, run), note: `${share(dominantShare)} active`,
    lines: run.arms.map((name, arm) => ({
      name, colour: colourOf(name), strong: name === run.dominant,
      points: run.posteriors.map(({ time_s, means }) => ({ x: minutes(run, time_s), y: means[arm]!,
        text: `${name} ${significant(means[arm], 3)}\n${minutesText(run, time_s)}` })),
    })),
  };
}

export function posteriorPanels(document: ExperimentDocument, words: Words): HTMLElement[] {
  const charts = document.cells.map(({ cell }, number) => ({ number, cell, runs: document.runs.filter((run) => run.cell === cell) }));
  return [armLegend(document), ...charts.filter(({ runs }) => runs.length > 0).map(({ number, cell, runs }) => panels({
    id: `posteriors-${number + 1}`, title: words.cellName(cell), note: 'Posterior mean over minutes × time scale, as in the paper.',
    panels: runs.map((run) => panelOf(words, run)) }))];
}
