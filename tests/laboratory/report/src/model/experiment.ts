// The document of `sweepstake-lab experiment --json`, and the page's summaries of it. Times of a run are seconds since its start. Ratios
// are plain numbers, 0.1 for 10 %.
import { mean } from '../../../../../server/dashboard/src/format';
import { type Interval } from '../format';
import type { Machine } from '../page';
import type { FrameMs } from './replay';

export interface ExperimentRow {
  policy: string; own_policy: string; cell: string; scene: string; objects: number; runs: number;
  dominance: string; dominant: string; dominant_runs: { arm: string; runs: number }[]; interpretation: string; verdict: string;
  switches: number; switches_sd: number; active_percent: number; active_percent_sd: number;
  mu: number; mu_sd: number; n: number; n_sd: number; truly_fastest?: string;
}
export interface Run {
  cell: string; policy: string; run: number; arms: string[]; exploration_s: number; end_s: number; time_scale: number;
  dominant: string; active_shares: number[];
  periods: { arm: number; from_s: number; to_s: number; reason: string }[];
  held_back_s: number[]; bail_outs: { time_s: number; arm: number }[];
  posteriors: { time_s: number; means: number[] }[];
  verdicts: Record<string, number>; time: Record<TimePart | 'longest_decision_ns', number>;
  decisions: number; dropped_frames: number;
}
export type TimePart = 'scene_step_ns' | 'detection_ns' | 'rebuild_ns' | 'copying_ns' | 'around_ns' | 'frame_end_ns' | 'intake_ns' | 'decision_ns' | 'lane_ns';
export interface Player {
  name: string; is_policy: boolean; regret: number; ci95: Interval; after_start_up: number | null; switches: number; active_share: number;
  regret_60hz?: number; ms_per_frame?: FrameMs;
}
export interface Comparison {
  policy: string; baseline: string; pairs: number; difference: number; ci95: Interval; p: number; p_corrected: number; effect: number;
  p_smallest: number; // the smallest p that this number of pairs can have
}
export interface Agreement {
  policy: string; runs: number; regret: number; replayed_regret: Interval; regret_agrees: boolean;
  active_share: number; replayed_active_share: Interval; share_agrees: boolean; measured_regret: number;
}
// Milliseconds of detection per frame: the best single algorithm, always KDTree, the best sequence of algorithms, and AI Decides.
export interface Worth { best_arm: string; best_ms: number; always_ms: number; oracle_ms: number; decided_ms: number; nothing: boolean }
export interface Truth {
  worth?: Worth | null;
  cell: string; scenes: number; ranking: { arm: string; mean_ns: number; ratio: number }[]; control_ratio: number; headroom: number;
  players: Player[]; comparisons: Comparison[]; agreements: Agreement[];
}
// The paper's printed values of a cell.
export interface PaperCell {
  scene: string; objects: number; dominant: string; dominant_runs: number; runs: number; dominance: string; interpretation: string;
  switches: number; switches_sd: number; active_percent: number; active_percent_sd: number; mu: number; mu_sd: number; n: number; n_sd: number;
}
export interface ExperimentDocument {
  command: 'experiment'; folder: string; complete: boolean; finished_runs: number; planned_runs: number; time_scale: number;
  own_policy: string; machine: Machine; arms: string[];
  options: { grid?: string; policies: string[]; run_count: number; window: string; seed: number; trace_frame_count: number; replay_seed_count: number;
    decision?: { decision_interval_ns: number; cooldown_ns: number; settling_ns: number; weights: Record<'fps' | 'detection' | 'memory' | 'checks', number> } };
  sittings: { command_line: string; start_utc: string; end_utc: string }[];
  cells: { cell: string; scene: string; objects: number }[];
  rows: ExperimentRow[]; runs: Run[]; truths: Truth[]; over_cells: Comparison[];
  paper?: PaperCell[]; // Tables 3 and 4 as printed
  worth_text?: string; // says what choosing is worth; empty if nothing was replayed
}

export const VERDICTS = ['unknown', 'stable', 'tie', 'ambiguous', 'degraded'];
export const TIME_PARTS: [TimePart, string][] = [
  ['scene_step_ns', 'Scene step'], ['detection_ns', 'Steady detection'], ['rebuild_ns', 'Rebuilds'], ['copying_ns', 'Copying in'],
  ['around_ns', 'Descriptors, switching'], ['frame_end_ns', 'Frame end'],
  ['intake_ns', 'Intake'], ['decision_ns', 'Selector'], ['lane_ns', 'Shadow lane']];
export const FRAME_PARTS = 6; // the first six TIME_PARTS belong to the frame thread

const TIE_RATIO = 1.03; // an algorithm this much slower than the fastest counts as equal
const DISTURBED = 0.1; // in an undisturbed run, measured regret and regret by the trace differ by less

export const runsOf = ({ runs }: ExperimentDocument, row: { cell: string; policy: string }) =>
  runs.filter(({ cell, policy }) => cell === row.cell && policy === row.policy);
export const truthOf = ({ truths }: ExperimentDocument, cell: string) => truths.find((truth) => truth.cell === cell);
export const replayed = ({ truths }: ExperimentDocument) => truths.filter(({ players }) => players.length > 0);

// Returns the regrets of each player in the replayed cells.
export function regretsByPlayer(document: ExperimentDocument): Map<string, { isPolicy: boolean; regrets: number[] }> {
  const players = new Map<string, { isPolicy: boolean; regrets: number[] }>();
  for (const { name, is_policy: isPolicy, regret } of replayed(document).flatMap((truth) => truth.players)) {
    players.set(name, { isPolicy, regrets: [...(players.get(name)?.regrets ?? []), regret] });
  }
  return players;
}

export function meanRegret(document: ExperimentDocument, policy: string): number | undefined {
  const regrets = regretsByPlayer(document).get(policy)?.regrets;
  return regrets && mean(regrets);
}

// Counts the cells in which the policy's dominant algorithm was the fastest by the trace, or within 3 % of the fastest.
export function chosenWell(document: ExperimentDocument, policy: string): { fastest: number; tied: number; all: number } {
  const ratios = document.rows.filter((row) => row.policy === policy).flatMap((row) =>
    truthOf(document, row.cell)?.ranking.filter(({ arm }) => arm === row.dominant).map(({ ratio }) => ratio) ?? []);
  return {
    all: ratios.length, fastest: ratios.filter((ratio) => ratio === 1).length,
    tied: ratios.filter((ratio) => ratio > 1 && ratio <= TIE_RATIO).length,
  };
}

export function agreementCounts({ truths }: ExperimentDocument): { regret: number; share: number; disturbed: number; all: number } {
  const all = truths.flatMap(({ agreements }) => agreements);
  return {
    all: all.length, regret: all.filter((each) => each.regret_agrees).length, share: all.filter((each) => each.share_agrees).length,
    disturbed: all.filter((each) => Math.abs(each.measured_regret - each.regret) > DISTURBED).length,
  };
}

// Returns the smallest p that the comparisons of a family can have, and the same after Holm's correction. If all of them have the
// smallest p, the correction multiplies it by the number of comparisons.
export function smallestProbability(family: Comparison[]): { p: number; corrected: number; pairs: number } {
  const p = Math.min(1, ...family.map((each) => each.p_smallest));
  return { p, corrected: Math.min(1, p * family.length), pairs: Math.max(0, ...family.map((each) => each.pairs)) };
}

export const noisyCells = ({ truths }: ExperimentDocument) =>
  truths.filter(({ control_ratio }) => Math.abs(control_ratio - 1) > TIE_RATIO - 1).map(({ cell }) => cell);

// Returns the sums over the runs, in the order of TIME_PARTS.
export function timeParts(runs: Run[]): number[] {
  return TIME_PARTS.map(([part]) => runs.reduce((sum, { time }) => sum + time[part], 0));
}

export const frameTime = (parts: number[]) => parts.slice(0, FRAME_PARTS).reduce((a, b) => a + b, 0);

// Returns the mean active share of each algorithm over the runs.
export function activeShares({ arms }: ExperimentDocument, runs: Run[]): number[] {
  return arms.map((arm) => runs.reduce((sum, run) => sum + (run.active_shares[run.arms.indexOf(arm)] ?? 0), 0));
}

export const verdictCounts = (runs: Run[]) => VERDICTS.map((verdict) => runs.reduce((sum, { verdicts }) => sum + (verdicts[verdict] ?? 0), 0));
