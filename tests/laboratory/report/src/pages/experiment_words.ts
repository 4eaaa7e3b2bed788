// Texts of the page of an experiment.
import { h, headline, list, paragraph, verdict, type Child } from '../dom';
import { compact, counted, grouped, significant } from '../../../../../server/dashboard/src/format';
import { percent } from '../format';
import { agreementCounts, chosenWell, frameTime, meanRegret, noisyCells, timeParts, type ExperimentDocument } from '../model/experiment';

const SCENES: Record<string, string> = { brownian: 'Brownian', 'rotating-gravity': 'Rotating Grav', hurricane: 'Hurricane' };
export const sceneName = (scene: string) => SCENES[scene] ?? scene;

export interface Words {
  cellName(cell: string): string;
  policyTitle(policy: string): string;
  policyShort(policy: string): string;
}

// `own` is the policy that "default" stands for.
export function wordsOf({ cells, own_policy: own }: Pick<ExperimentDocument, 'cells' | 'own_policy'>): Words {
  const isOwn = (policy: string) => policy === 'default' || policy === own;
  return {
    cellName: (name) => {
      const found = cells.find(({ cell }) => cell === name);
      return found ? `${sceneName(found.scene)} ${grouped(found.objects)}` : name;
    },
    policyTitle: (policy) => (isOwn(policy) ? `AI Decides (${own})` : policy),
    policyShort: (policy) => (isOwn(policy) ? 'AI Decides' : policy),
  };
}

export function lead({ sittings, machine, worth_text, options }: ExperimentDocument): Child[] {
  const what = options.grid === 'crossovers' ? 'plays scenes in which different algorithms are the fastest' :
    'repeats the experiment of the paper that Sweepstake follows';
  return [
    worth_text ? paragraph(worth_text) : null,
    paragraph('A game must find, in every frame, all pairs of its objects whose boxes overlap. There are several algorithms for that, ' +
      'and the scene determines which is the fastest. Sweepstake measures them while the game runs and chooses one. This page ' +
      `${what}, and compares its choices with separate measurements of all algorithms.`),
    h('p', { class: 'soft small' }, `Measured ${sittings.at(-1)?.start_utc ?? ''} on ${machine.cpu} with Sweepstake ${machine.program}.`)];
}

function resultHeadline(document: ExperimentDocument, words: Words): Child {
  const ours = meanRegret(document, document.own_policy);
  const papers = meanRegret(document, 'paper');
  if (ours === undefined) return null;
  return headline(percent(ours), `of frame time is the mean loss of ${words.policyTitle('default')} against the best fixed algorithm over ` +
    `${counted(document.truths.length, 'cell', 'cells')}, including start and exploration. The best algorithm is not known beforehand. Below 0 the policy is ` +
    `faster than any single algorithm.${papers !== undefined && document.own_policy !== 'paper' ? ` The policy paper loses ${percent(papers)}${hasPapersRules(document) ? '' : ', with the settings of this run'}.` : ''}`);
}

export function trulyFastest(document: ExperimentDocument, words: Words, policy: string): Child {
  const { fastest, tied, all } = chosenWell(document, policy);
  return all > 0 && `With the policy ${words.policyTitle(policy)}, the algorithm that was active longest is also the fastest by measurement in ` +
    `${fastest} of ${counted(all, 'cell', 'cells')}${tied > 0 ? `, and at most 3 % slower than the fastest in ${tied} more` : ''}.`;
}

// Whether the decider's rules are those of the paper.
function hasPapersRules({ options }: ExperimentDocument): boolean {
  const rules = options.decision;
  return !rules || (rules.decision_interval_ns === 2e9 && rules.cooldown_ns === 40e9 && rules.settling_ns === 2e9 &&
    rules.weights.fps === 0.55 && rules.weights.detection === 0.25 && rules.weights.memory === 0.12);
}

export function sameAsPaper(document: ExperimentDocument): Child {
  const { rows, paper = [] } = document;
  const compared = rows.filter(({ policy }) => policy === 'paper').flatMap((row) =>
    paper.filter(({ scene, objects }) => scene === row.scene && objects === row.objects).map(({ dominant }) => dominant === row.dominant));
  return compared.length > 0 && `The same algorithm as in the paper’s Table 3 dominates in ${compared.filter(Boolean).length} of ` +
    `${counted(compared.length, 'cell', 'cells')} that both have. A difference is not an error: machine and code of the seven algorithms differ from the paper’s, so ` +
    `their relative speeds differ, too.${hasPapersRules(document) ? '' : ' Interval, cooldown, settling or weights of this run also differ from the paper’s.'}`;
}

function agreed(document: ExperimentDocument): Child {
  const { regret, share, disturbed, all } = agreementCounts(document);
  return all > 0 && `Live against replay: the live regret is in the replay’s 95 % interval in ${regret} of ${counted(all, 'comparison', 'comparisons')}, the active ` +
    `share in ${share} of ${all}.${disturbed > 0 ? ` In ${disturbed} of them the measured regret differs by more than 10 percentage points from the regret ` +
    'at the trace’s costs. Other work probably used the machine during these games, which a replay does not contain.' : ''}`;
}

function selectorCost({ runs }: ExperimentDocument): Child {
  const parts = timeParts(runs);
  const frames = frameTime(parts);
  return frames > 0 && `The decider took ${significant((100 * parts[7]!) / frames, 2)} % of the frames’ time, on a thread of its own. Building ` +
    `data structures after switches took ${significant((100 * parts[2]!) / frames, 2)} % on the frame thread.`;
}

export function summary(document: ExperimentDocument, words: Words): Child[] {
  const { options, complete, finished_runs: finished, planned_runs: planned, time_scale: scale } = document;
  const noisy = noisyCells(document).map(words.cellName);
  return [
    !complete && paragraph(verdict(false, `Partial: ${finished} of ${planned} planned runs are in. `), 'All figures come from these runs only.'),
    noisy.length > 0 && paragraph(verdict(false, 'The machine was disturbed. '),
      `Two measurements of the same algorithm differ by more than 3 % in ${noisy.join(', ')}. The measured ranking there is not reliable.`),
    resultHeadline(document, words),
    list([`${finished} of ${planned} planned live runs are in: ${counted(document.cells.length, 'cell', 'cells')} (a cell is a scene with an object ` +
      `count), ${counted(options.policies.length, 'policy', 'policies')}, and ${counted(options.run_count, 'run', 'runs')} of each. A run lasts ` +
      `${options.window} after the exploration${scale > 1 ? `, with all intervals divided by ${compact(scale)}` : ''}.`,
    ...options.policies.map((policy) => trulyFastest(document, words, policy)),
    sameAsPaper(document), agreed(document), selectorCost(document)])];
}

export function method({ options, time_scale: scale }: ExperimentDocument): HTMLElement {
  return list([
    'Each live run is a game without graphics. The scene moves, the active algorithm finds all pairs, and the decider receives the frame’s ' +
    'cost and commands switches. It starts without priors. A policy with exploration, such as the paper’s, first tries every algorithm ' +
    'once, before the observation window. The policy of AI Decides learns from its shadow lane instead.',
    'The runs of one cell have different scenes (the same kind and object count, another seed), different seeds of the decider and ' +
    'different first algorithms. Runs of two policies with the same number have the same scene, seed and first algorithm. A recording, or a ' +
    'scene without random parts, is the same in every run.',
    'Right after a run, every algorithm ran alone on the same scene. The regret as the clock measured it is relative to the best of these.',
    `The ranking comes from a trace per scene: every algorithm was timed on each of ${grouped(options.trace_frame_count)} frames of the same scene, in ` +
    'turn. “Same twice” is the ratio of two measurements of one algorithm, which differ only by noise.',
    `Replay plays each policy at least ${counted(options.replay_seed_count, 'time', 'times')} per cell on the traces in virtual time, at 10 ms per frame ` +
    'and with unscaled intervals. Regret is frame time ÷ that of the best fixed algorithm, minus 1. Games on the same scene are averaged ' +
    'first: intervals and tests have one value per scene, or per cell. An interval from fewer than ten values is too narrow.',
    'To compare live runs with replay, replay also ran with the frame times, the other work and the time scale of the live runs. ' +
    'The predicted interval is the mean of its games ± 1.96 of their standard deviations × √(1/runs + 1/games).',
    scale > 1 && 'The time scale divides all intervals of the decider and the observation window. So a run has as many decisions and ' +
    'switches as at full length, but from shorter measurements.']);
}
