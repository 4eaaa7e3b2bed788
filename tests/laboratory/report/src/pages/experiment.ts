// The page of `sweepstake-lab experiment`.
import { h, paragraph, type Child } from '../dom';
import { compact } from '../../../../../server/dashboard/src/format';
import type { ExperimentDocument } from '../model/experiment';
import { commandLine, machineList, type Page, type Section } from '../page';
import { activeShareChart, dominanceGrid, paperTables, timeSection, verdictChart } from './experiment_cells';
import { posteriorPanels, switchTimelines } from './experiment_runs';
import { comparisonTables, liveAgainstReplay, regretCharts, trueRanking, worthTable } from './experiment_truth';
import { lead, method, summary, wordsOf } from './experiment_words';
import { REGRET_SCALE } from './regret';

// Returns the decider's parameters as terms. An older document does not have them.
function deciderTerms({ decision }: ExperimentDocument['options']): [string, string][] {
  if (!decision) return [];
  const seconds = (ns: number) => `${compact(ns * 1e-9)} s`;
  const { fps, detection, memory, checks } = decision.weights;
  return [['Decision interval', seconds(decision.decision_interval_ns)], ['Cooldown', seconds(decision.cooldown_ns)], ['Settling', seconds(decision.settling_ns)],
    ['Reward weights', `frame rate ${fps}, detection ${detection}, memory ${memory}, checks ${checks}`]];
}

function manifest({ machine, time_scale, options, sittings }: ExperimentDocument): Child[] {
  return [
    machineList(machine, [['Time scale', compact(time_scale)], ['Window', options.window], ['Seed', String(options.seed)], ...deciderTerms(options)]),
    h('h3', {}, 'Command lines'),
    sittings.map(({ command_line, start_utc, end_utc }) => [commandLine(command_line),
      h('p', { class: 'soft small' }, `From ${start_utc} to ${end_utc || 'an unknown end'}`)]),
    paragraph('The folder of this page has all seeds and parameters of the decider in ', h('code', {}, 'manifest.json'), ', and the raw rows in CSV files.')];
}

// Returns a section with an explanation before its body. If the body is empty, so is the section.
function explained(id: string, heading: string, explanation: string, ...body: Child[]): Section {
  return { id, heading, body: body.flat(9).some(Boolean) ? [paragraph(explanation), body] : [] };
}

export function experimentPage(document: ExperimentDocument): Page {
  const words = wordsOf(document);
  const some = <T>(values: unknown[], draw: () => T) => (values.length > 0 ? draw() : null);
  const { rows, runs } = document;
  return {
    title: 'Sweepstake experiment',
    lead: lead(document),
    sections: [
      { id: 'summary', heading: 'Summary', body: [summary(document, words)] },
      explained('worth', 'What choosing is worth', 'Milliseconds of detection per frame. The best single algorithm is not known beforehand. “Best sequence” is ' +
        'the oracle, which knows all costs and pays for its switches: no policy can save more.', worthTable(document, words)),
      explained('dominant', 'Who won where', 'Each cell names the algorithms that were active longest in a run, and the number of such runs. The small line ' +
        'shows the active share, and the algorithm that was the fastest in a separate measurement.', some(rows, () => dominanceGrid(document, words))),
      explained('tables', 'Tables 3 and 4 of the paper', 'The paper’s tables with the figures of this experiment. The paper’s figures are beside or below them. ' +
        'μ* = α ÷ (α + β) is the mean of the dominant algorithm’s posterior, and n* = α + β. Many switches and an active share below half mean ' +
        'that the algorithms cost about the same, or that the policy did not find the best one.',
      some(rows, () => paperTables(document, words))),
      { id: 'ranking-section', heading: 'How fast each algorithm truly is', body: [trueRanking(document, words)] },
      explained('regret', 'What each policy loses', `${REGRET_SCALE} ` +
        '“fixed:…” is one algorithm without switches. The oracle is the best sequence of algorithms, including the cost of its switches.',
      regretCharts(document, words)),
      { id: 'tests', heading: 'Is the difference real?', body: comparisonTables(document, words) },
      explained('live-replay', 'Live against replay', 'This compares live runs with replays of the same conditions. If they differ, the replay’s ' +
        'figures for that cell are not reliable.', liveAgainstReplay(document, words)),
      explained('switches', 'Who was active when', 'Each row is a run. Faint: the exploration, in which every algorithm is tried. Strokes below a row: candidates that the ' +
        'cooldown or a safeguard held back. Crosses: bail-outs, which are frames over the time limit.', some(runs, () => switchTimelines(document, words))),
      { id: 'shares', heading: 'Active shares', body: [some(runs, () => activeShareChart(document, words))] },
      explained('posteriors', 'Posteriors over time', 'The mean of the decider’s posterior of each algorithm’s reward, in one panel per run. The line of the dominant algorithm is thick ' +
        'and has its name.', some(runs, () => posteriorPanels(document, words))),
      { id: 'verdicts', heading: 'Verdicts', body: [some(runs, () => verdictChart(document, words))] },
      explained('time', 'Where the time went', 'The paper does not report the cost of its selector. “Copying in” copies boxes for the shadow lane, which measures ' +
        'the other algorithms on a thread of its own. “Rebuilds” is the cost of switches on the frame thread.', some(runs, () => timeSection(document, words))),
      { id: 'method', heading: 'How it was measured', body: [method(document)] },
      { id: 'manifest', heading: 'Machine, versions, commands', body: manifest(document) },
    ],
  };
}
