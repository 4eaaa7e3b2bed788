// Explains a decision in sentences. The view "Why this arm?" (../views/session/why.tsx) shows them.
import { type AuditDecision, type AuditGate, AuditKind, type AuditRow, type AuditSetup } from '../../gen/sweepstake/v1/audit_pb';
import { LOG_COST_REWARD_VERSION, rewardText } from '../numbers/log_cost';
import { DecisionOutcome, type DecisionEvent } from '../../gen/sweepstake/v1/posteriors_pb';
import { Mode, SwitchReason } from '../../gen/sweepstake/v1/telemetry_pb';
import { significant } from '../../format';
import { kindWord, outcomeWord, reasonWord, verdictWord } from '../views/words';
import { msOf } from './log';

/** A decision, from the audit log or from the live stream. The gate is the check whether a switch pays;
 * its gains and losses are natural logarithms of ratios of costs. */
export interface Told extends Pick<AuditDecision,
  'activeArm' | 'candidate' | 'outcome' | 'reward' | 'rewardVersion' | 'verdict' | 'leader' | 'bestProbability' | 'expectedLossRatio'> {
  reason: SwitchReason;
  gate?: Pick<AuditGate, 'gain' | 'loss' | 'horizonS' | 'cooldownS' | 'costS'>;
  cooldownMs?: number;
}

/** Converts a row of the audit log. REQUIRES: the row has a decision (a tick or a bail-out). */
export function toldOfRow({ decision, reason }: AuditRow, setup?: AuditSetup): Told {
  const { gate } = decision!;
  return { ...decision!, reason, ...(setup && { cooldownMs: gate ? gate.cooldownS * 1000 : msOf(setup.cooldownNs) }) };
}

export function toldOfEvent(event: DecisionEvent, rewardVersion: number): Told {
  const { bestProbability, arms, candidateArm } = event;
  return { ...event, candidate: candidateArm, rewardVersion, leader: arms[bestProbability.indexOf(Math.max(...bestProbability))] ?? '' };
}

const percent = (share: number) => `${significant(100 * share, 2)} %`;
const seconds = (s: number) => `${significant(s, 2)} s`;

/** Returns a duration in seconds or milliseconds. */
export const durationText = (ms: number) => (ms < 1000 ? `${significant(ms, 2)} ms` : seconds(ms / 1000));

function whatHappened({ activeArm, candidate, outcome, reason, cooldownMs }: Told): string {
  const other = candidate && candidate !== activeArm ? candidate : 'another arm';
  switch (outcome) {
    case DecisionOutcome.SWITCHED: return `The daemon commanded a switch from ${activeArm} to ${other}. ${reasonWord(reason).meaning}`;
    case DecisionOutcome.KEPT: return `${activeArm} stays, because the policy chose it again.`;
    case DecisionOutcome.HELD_COOLDOWN:
      return `${other} looks better, but ${activeArm} stays: after a switch `
        + (cooldownMs === undefined ? 'the cooldown has to pass' : `${durationText(cooldownMs)} have to pass`) + ' before the next one.';
    case DecisionOutcome.HELD_GATE: return `${other} looks better, but ${activeArm} stays: the change would not pay for itself.`;
    case DecisionOutcome.EXPLORING:
      return reason === SwitchReason.EXPLORATION
        ? `${activeArm} has been measured, and the next arm follows. At the start every arm is measured once.`
        : `${activeArm} is being measured. At the start every arm is measured once.`;
    default: return `${activeArm} was active. ${outcomeWord(outcome).meaning}`;
  }
}

function whatWeighed({ candidate, activeArm, gate, outcome }: Told): string | undefined {
  if (!gate || !candidate || candidate === activeArm) return undefined;
  const saved = gate.horizonS * gate.gain;
  const risked = gate.cooldownS * gate.loss;
  const pays = saved - risked - gate.costS > 0;
  const worth = (s: number) => (s < 1e-6 ? 'nothing' : durationText(1000 * s));
  const pay = outcome === DecisionOutcome.SWITCHED ? 'pays' : 'would pay';
  return `For ${candidate}: it is expected to save ${percent(-Math.expm1(-gate.gain))} of the detection time for ${seconds(gate.horizonS)}, which counts as ${worth(saved)}. `
    + `Against it: it may turn out to cost ${gate.loss < 1e-4 ? 'hardly any' : percent(gate.loss)} more for ${seconds(gate.cooldownS)}, until the next switch is allowed, which counts as ${worth(risked)}. `
    + `The switch itself counts as ${worth(gate.costS)}. Altogether the switch ${pays ? pay : 'does not pay'}.`;
}

function whatIsBelieved({ leader, bestProbability, expectedLossRatio, verdict }: Told): string | undefined {
  if (!leader) return undefined;
  const leaderProbability = Math.max(...bestProbability);
  const believed = `After this decision ${leader} is the best arm with a probability of ${leaderProbability > 0.999 ? 'over 99.9 %' : percent(leaderProbability)}, `
    + `and choosing it loses ${percent(expectedLossRatio)} on average.`;
  return `${believed} The scene is called ${verdictWord(verdict).name}: ${verdictWord(verdict).meaning} The verdict changes when three decisions in a row agree.`;
}

function whatWasMeasured({ activeArm, reward, rewardVersion }: Told): string | undefined {
  if (reward === undefined) return 'The frames before this decision did not become evidence.';
  if (rewardVersion !== LOG_COST_REWARD_VERSION) return `The frames before this decision gave ${activeArm} a reward of ${significant(reward)} (1 is the best).`;
  return `In the frames before this decision ${activeArm} took ${rewardText(reward, true)} per frame, a reward of ${significant(reward)}.`;
}

/** Returns the sentences that explain a decision, the most important one first. */
export const explained = (told: Told): string[] =>
  [whatHappened(told), whatWeighed(told), whatWasMeasured(told), whatIsBelieved(told)].filter((each): each is string => each !== undefined);

function orderText({ operatorName, mode, arm }: AuditRow): string {
  if (mode === Mode.AI) return `${operatorName} let the daemon decide.`;
  return `${operatorName} ordered the game to keep to ${arm || 'the active arm'}.`;
}

// If the row names no operator, the action alone is the sentence.
function actionText({ operatorName, action }: AuditRow): string {
  return operatorName ? `${operatorName} ${action}.` : `${action.charAt(0).toUpperCase()}${action.slice(1)}.`;
}

/** Returns sentences that explain any row of the audit log. */
export function explainedRow(row: AuditRow, setup?: AuditSetup): string[] {
  const { kind, arm, switchCost } = row;
  const meaning = kindWord(kind).meaning;
  switch (kind) {
    case AuditKind.TICK: return explained(toldOfRow(row, setup));
    case AuditKind.BAIL_OUT: return [meaning, ...explained(toldOfRow(row, setup))];
    case AuditKind.SWITCH: {
      const costMs = msOf((switchCost?.rebuildTimeNs ?? 0n) + (switchCost?.settlingCostNs ?? 0n));
      return [`The game now uses ${arm}. ${reasonWord(row.reason).meaning} The change cost ${durationText(costMs)} of frame time.`];
    }
    case AuditKind.MODE: return [row.mode === Mode.AI ? 'The daemon decides.' : `The game keeps ${arm}, which a person chose.`];
    case AuditKind.ORDER: return [orderText(row)];
    case AuditKind.ADMIN: return [actionText(row)];
    case AuditKind.SETUP: return [setup ? `${meaning} The policy is ${setup.policy}, and the arms are ${setup.arms.join(', ')}.` : meaning];
    default: return [meaning];
  }
}
