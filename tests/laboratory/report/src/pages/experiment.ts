// The page of `sweepstake-lab experiment`.
import { h, paragraph, type Child } from '../dom';
import { compact, percent } from '../../../../../server/dashboard/src/format';
import type { ExperimentDocument } from '../model/experiment';
import { commandLine, machineList, type Page, type Section } from '../page';
import { activeShareChart, dominanceGrid, paperTables, timeSection, verdictChart } from './experiment_cells';
import { posteriorPanels, switchTimelines } from './experiment_runs';
import { comparisonTables, liveAgainstReplay, regretCharts, trueRanking } from './experiment_truth';
import { lead, method, summary, wordsOf } from './experiment_words';

function manifest({ machine, time_scale, options, sittings }: ExperimentDocument): Child[] {
  return [
    machineList(machine, [['Time scale', compact(time_scale)], ['Window', options.window], ['Seed', String(options.seed)]]),
    h('h3', {}, 'Command lines'),
    sittings.map(({ command_line, start_utc, end_utc }) => [commandLine(command_line),
      h('p', { class: 'soft small' }, `From ${start_utc} to ${end_utc || 'an unknown end'}`)]),
    paragraph('All seeds and every parameter of the decider are in ', h('code', {}, 'manifest.json'), ' beside this page, the raw rows in its CSV files.')];
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
      explained('dominant', 'Who won where', 'Each cell names the algorithm that was active longest, and in how many of the runs. The small line ' +
        'compares it with the truth.', some(rows, () => dominanceGrid(document, words))),
      explained('tables', 'Tables 3 and 4 of the paper', 'The paper’s tables with this experiment’s figures; the paper’s own stand beside or below. ' +
        'Many switches and an active share below half mean that the policy could not make up its mind, or that it did not matter.',
      some(rows, () => paperTables(document, words))),
      { id: 'ranking-section', heading: 'How fast each algorithm truly is', body: [trueRanking(document, words)] },
      explained('regret', 'What each policy loses', `Left is better; the axis is logarithmic, and what loses ${percent(0.0001).slice(1)} or less, or ` +
        'wins, stands at its left edge. “fixed:…” is an algorithm that always stays; the oracle knows everything and still pays for its switches.',
      regretCharts(document, words)),
      { id: 'tests', heading: 'Is the difference real?', body: comparisonTables(document, words) },
      explained('live-replay', 'Live against replay', 'Replay can only be trusted where it says what live runs show.', liveAgainstReplay(document, words)),
      explained('switches', 'Who was active when', 'A lane per run. Faint: the exploration. Strokes below a lane: candidates that were held back by ' +
        'the cooldown or a safeguard. Crosses: bail-outs.', some(runs, () => switchTimelines(document, words))),
      { id: 'shares', heading: 'Active shares', body: [some(runs, () => activeShareChart(document, words))] },
      explained('posteriors', 'Posteriors over time', 'What the decider believed of each algorithm’s reward, a panel per run; the dominant one is thick ' +
        'and named.', some(runs, () => posteriorPanels(document, words))),
      { id: 'verdicts', heading: 'Verdicts', body: [some(runs, () => verdictChart(document, words))] },
      explained('time', 'Where the time went', 'The paper left open what its selector costs. Copying in hands boxes to the shadow lane, which measures ' +
        'the other algorithms on a thread of its own; rebuilds are what switches cost the frame thread.', some(runs, () => timeSection(document, words))),
      { id: 'method', heading: 'How it was measured', body: [method(document)] },
      { id: 'manifest', heading: 'Machine, versions, commands', body: manifest(document) },
    ],
  };
}
