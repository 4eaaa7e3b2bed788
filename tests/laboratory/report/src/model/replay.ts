// The document of `sweepstake-lab replay --json`. Ratios are plain numbers, 0.1 for 10 %.
import { mean } from '../../../../../server/dashboard/src/format';
import { type Interval } from '../format';

// The decisions in which P(best) of the leader was between `low` and `high`. `predicted` is the mean of P(best). `best` is the share of
// decisions in which the leader was the fastest algorithm. `best_or_tie` also counts leaders that took at most 0.5 % longer.
export interface ReliabilityBin { low: number; high: number; decisions: number; predicted: number; best: number; best_or_tie: number }
// The reliability of a policy over all traces. `error` is the mean distance between a stated probability and the observed frequency.
export interface Calibration { policy: string; error: number; bins: ReliabilityBin[] }
// Milliseconds per frame as recorded, without other work. `lane` is the time of the shadow lane on another core.
export interface FrameMs { detection: number; best: number; median: number; worst: number; paper: number | null; regret: number; lane: number }
export interface ReplayRow {
  costs: string; policy: string; regret_best_fixed: number; regret_oracle: number; ci95: Interval; switches: number; active_share: number;
  bail_outs: number | null; regret_after_start: number | null; headroom: number; headroom_frame: number; headroom_captured: number | null;
  dominant: string; seeds: number; first_best_s: number | null; shadow_share: number; verdicts: Record<string, number>;
  regret_detection?: number; regret_60hz?: number; ms_per_frame?: FrameMs;
  against_paper?: { difference: number; ci95: Interval; wilcoxon_p: number };
}
export interface ReplayScene {
  costs: string; arms: string[]; trace_frames: number; frames: number; frame_ns: number; run_ns: number; pass_ns: number; control_regret: number;
  objects?: number;
}
// Added by tests/bench: a goal and the measured value.
export interface ReplayGoal { goal: string; limit_text: string; reached: number | null; met: boolean; cells: { cell: string; value: number; met: boolean }[] }
export interface ReplayDocument {
  command: 'replay'; command_line?: string; seeds: number; own_policy?: string; scenes?: ReplayScene[]; rows: ReplayRow[]; goals?: ReplayGoal[];
  calibration?: Calibration[];
}

export const isFixed = (policy: string) => policy.startsWith('fixed:') || policy === 'oracle';
export const costsOf = ({ rows }: ReplayDocument) => [...new Set(rows.map(({ costs }) => costs))];
export const fileName = (path: string) => path.split(/[\\/]/).at(-1)!.replace(/\.costs$/, '');

// Returns the policy's mean regret over the traces.
export function meanRegretOf({ rows }: ReplayDocument, policy: string): number | undefined {
  const regrets = rows.filter((row) => row.policy === policy).map((row) => row.regret_best_fixed);
  return regrets.length > 0 ? mean(regrets) : undefined;
}
