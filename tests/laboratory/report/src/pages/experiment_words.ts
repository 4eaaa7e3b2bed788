// Texts of the page of an experiment.
import { h, headline, list, paragraph, verdict, type Child } from '../dom';
import { compact, counted, grouped, percent, significant } from '../../../../../server/dashboard/src/format';
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

export function lead({ sittings, machine }: ExperimentDocument): Child[] {
  return [
    paragraph('A game must find, in every frame, all pairs of its objects whose boxes overlap. There are several algorithms for that, ' +
      'and which is the fastest depends on the scene. Sweepstake measures while the game runs and decides which one to use. This page ' +
      'shows how well it decided: it repeats the experiment of the paper that it is built on, and checks each decision against the truth.'),
    h('p', { class: 'soft small' }, `Measured ${sittings.at(-1)?.start_utc ?? ''} on ${machine.cpu} with Sweepstake ${machine.program}.`)];
}

function resultHeadline(document: ExperimentDocument, words: Words): Child {
  const ours = meanRegret(document, document.own_policy);
  const papers = meanRegret(document, 'paper');
  if (ours === undefined) return null;
  return headline(percent(ours), `of frame time is what ${words.policyTitle('default')} loses to the best fixed algorithm, on average over ` +
    `${document.truths.length} scenes, start and exploration included. Nobody knows beforehand which algorithm that is; below 0 means ` +
    `faster than any single one.${papers !== undefined && document.own_policy !== 'paper' ? ` The paper’s policy loses ${percent(papers)}.` : ''}`);
}

function trulyFastest(document: ExperimentDocument, words: Words, policy: string): Child {
  const { fastest, tied, all } = chosenWell(document, policy);
  return all > 0 && `With the policy ${words.policyTitle(policy)} the algorithm that was active longest is truly the fastest in ` +
    `${fastest} of ${all} scenes${tied > 0 ? `, and within 3 % of it in ${tied} more` : ''}.`;
}

function sameAsPaper({ rows, paper = [] }: ExperimentDocument): Child {
  const compared = rows.filter(({ policy }) => policy === 'paper').flatMap((row) =>
    paper.filter(({ scene, objects }) => scene === row.scene && objects === row.objects).map(({ dominant }) => dominant === row.dominant));
  return compared.length > 0 && `The same algorithm as in the paper’s Table 3 dominates in ${compared.filter(Boolean).length} of ` +
    `${compared.length} of its scenes. It need not: the seven algorithms here are other code than the paper’s, each faster or slower by ` +
    'another factor, and so is the machine.';
}

function agreed(document: ExperimentDocument): Child {
  const { regret, share, disturbed, all } = agreementCounts(document);
  return all > 0 && `Live against replay: the live regret lies in replay’s 95 % interval in ${regret} of ${all} comparisons, the active ` +
    `share in ${share} of ${all}.${disturbed > 0 ? ` In ${disturbed} of them the clock’s regret is more than 10 points off the one at the ` +
    'trace’s costs: something else used the machine while the game ran, which no replay knows of.' : ''}`;
}

function selectorCost({ runs }: ExperimentDocument): Child {
  const parts = timeParts(runs);
  const frames = frameTime(parts);
  return frames > 0 && `The selector itself took ${significant((100 * parts[7]!) / frames, 2)} % of the time (on a thread of its own), building ` +
    `structures anew after switches ${significant((100 * parts[2]!) / frames, 2)} %.`;
}

export function summary(document: ExperimentDocument, words: Words): Child[] {
  const { options, complete, finished_runs: finished, planned_runs: planned, time_scale: scale } = document;
  const noisy = noisyCells(document).map(words.cellName);
  return [
    !complete && paragraph(verdict(false, `Partial: ${finished} of ${planned} planned runs are in. `), 'All figures are of those alone.'),
    noisy.length > 0 && paragraph(verdict(false, 'The machine was disturbed. '),
      `One algorithm measured twice differs by more than 3 % in ${noisy.join(', ')}: what is said of the truth there is not to be trusted.`),
    resultHeadline(document, words),
    list([`${finished} of ${planned} planned live runs are in: ${counted(document.cells.length, 'cell', 'cells')} (a scene with a number of ` +
      `objects), ${counted(options.policies.length, 'policy', 'policies')}, ${counted(options.run_count, 'run', 'runs')} of each, ` +
      `${options.window} after the exploration${scale > 1 ? `, all intervals divided by ${compact(scale)}` : ''}.`,
    ...options.policies.map((policy) => trulyFastest(document, words, policy)),
    sameAsPaper(document), agreed(document), selectorCost(document)])];
}

export function method({ options, time_scale: scale }: ExperimentDocument): HTMLElement {
  return list([
    'Each live run is a real game without pictures: the scene moves, the active algorithm finds all pairs, the frame’s cost goes to the ' +
    'decider, which switches as it sees fit. It starts knowing nothing. A policy that explores, as the paper’s, first tries every algorithm ' +
    'once, unobserved; that of AI Decides learns from its shadow lane instead.',
    'The runs of one cell have the same scene and differ in the decider’s seed and in the algorithm they begin with; those of two policies ' +
    'with the same number share both.',
    'Right after a run every algorithm ran alone on the same scene in turn: the clock’s regret compares with those.',
    `The truth comes from a trace: every algorithm was timed on each of ${grouped(options.trace_frame_count)} frames of the same scene, in ` +
    'turn. “Same twice” is one algorithm measured a second time: what noise alone makes of a ratio.',
    `Replay plays each policy ${options.replay_seed_count} times on the trace in virtual time, at 10 ms a frame, where the paper’s intervals ` +
    'mean what they say. Regret is frame time ÷ that of the best fixed algorithm, minus 1. Intervals are bootstrapped over the seeds.',
    'To compare live and replay, replay also ran under the live runs’ own conditions: their frame times, their other work, their time scale. ' +
    'It expects the mean of as many runs within 1.96 standard deviations of its games × √(1/runs + 1/games).',
    scale > 1 && 'With the time scale all of the decider’s intervals and the window are shorter by the same factor: as many decisions and ' +
    'switches as in full length, from shorter measurements.']);
}
