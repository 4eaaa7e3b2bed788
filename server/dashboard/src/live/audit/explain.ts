// Explains a decision in sentences. The view "Why this algorithm?" (../views/session/why.tsx) shows them.
import { type AuditDecision, type AuditGate, AuditKind, type AuditRow, type AuditSetup } from '../../gen/sweepstake/v1/audit_pb';
import { mean } from '../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, nsText, rewardText } from '../numbers/log_cost';
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
  arms: readonly string[]; // in the order of bestProbability; empty: unknown
  costsNs?: readonly number[]; // expected detection time per frame of each arm; absent: unknown
  gate?: Pick<AuditGate, 'gain' | 'loss' | 'horizonS' | 'cooldownS' | 'costS'>;
  cooldownMs?: number;
}

/** Converts a row of the audit log. REQUIRES: the row has a decision (a tick or a bail-out). */
export function toldOfRow({ decision, reason }: AuditRow, setup?: AuditSetup): Told {
  const { gate, posteriors, rewardVersion } = decision!;
  const isCost = rewardVersion === LOG_COST_REWARD_VERSION && posteriors.length > 0;
  return {
    ...decision!, reason, arms: setup?.arms ?? [], ...(isCost && { costsNs: posteriors.map((each) => costNsOf(mean(each))) }),
    ...(setup && { cooldownMs: gate ? gate.cooldownS * 1000 : msOf(setup.cooldownNs) }),
  };
}

export function toldOfEvent(event: DecisionEvent, rewardVersion: number): Told {
  const { bestProbability, arms, candidateArm } = event;
  return { ...event, candidate: candidateArm, rewardVersion, leader: arms[bestProbability.indexOf(Math.max(...bestProbability))] ?? '' };
}

const percent = (share: number) => (share > 0 && share < 1e-4 ? 'less than 0.01 %' : `${significant(100 * share, 2)} %`);
const seconds = (s: number) => `${significant(s, 2)} s`;

export const durationText = (ms: number) => (ms < 1000 ? `${significant(ms, 2)} ms` : seconds(ms / 1000));

const costOf = ({ arms, costsNs }: Told, arm: string) => costsNs?.[arms.indexOf(arm)];

const other = ({ candidate, activeArm }: Told) => (candidate && candidate !== activeArm ? candidate : '');

const rivalsOf = (told: Told) => told.arms.filter((arm) => arm !== told.activeArm && costOf(told, arm) !== undefined)
  .sort((a, b) => costOf(told, a)! - costOf(told, b)!);

const sureText = (probability: number) => (probability > 0.999 ? 'over 99.9 %' : percent(probability));

const SMALLEST_GAIN = 1e-4; // smaller gains are called nothing

/** The gain above which a switch pays: the gate's inequality divided by its horizon. */
const leastGain = ({ cooldownS, loss, costS, horizonS }: NonNullable<Told['gate']>) => (cooldownS * loss + costS) / horizonS;

/** A policy may stay although a switch would pay, if the saving is too small to be measured well. */
const pays = (gate: Told['gate']) => gate !== undefined && gate.horizonS > 0 && gate.gain > leastGain(gate);

/** Returns what is expected of the candidate: ": it is expected to take 20 µs per frame instead of 30 µs, and …"; empty if unknown. */
function expectedOf(told: Told): string {
  const [name, from, to] = [other(told), costOf(told, told.activeArm), costOf(told, other(told))];
  const probability = told.bestProbability[told.arms.indexOf(name)];
  if (!name || from === undefined || to === undefined || probability === undefined) return '';
  return `: ${name} is expected to take ${nsText(to, from)} per frame instead of ${nsText(from)}, and is the best with a probability of ${sureText(probability)}`;
}

function whatHappened(told: Told): string {
  const { activeArm, outcome, reason, cooldownMs } = told;
  const name = other(told) || 'another algorithm';
  switch (outcome) {
    case DecisionOutcome.SWITCHED:
      return reason === SwitchReason.POLICY
        ? `The daemon commanded a switch from ${activeArm} to ${name}${expectedOf(told) || `. ${reasonWord(reason).meaning.slice(0, -1)}`}.`
        : `The daemon commanded a switch from ${activeArm} to ${name}. ${reasonWord(reason).meaning}`;
    case DecisionOutcome.KEPT: {
      const [next] = rivalsOf(told);
      const own = costOf(told, activeArm);
      if (next === undefined || own === undefined || own > costOf(told, next)!) return `${activeArm} stays, because the policy chose it again.`;
      return `${activeArm} stays: it is expected to take ${nsText(own)} per frame. ${next} is the cheapest of the others, with ${nsText(costOf(told, next)!, own)}.`;
    }
    case DecisionOutcome.HELD_COOLDOWN:
      return `${name} looks better, but ${activeArm} stays: after a switch `
        + (cooldownMs === undefined ? 'the cooldown has to pass' : `${durationText(cooldownMs)} have to pass`) + ' before the next one.';
    case DecisionOutcome.HELD_GATE:
      return `${activeArm} stays, because ${pays(told.gate) ? 'the policy does not switch for so small a saving' : 'the saving would not pay for a switch'}${expectedOf(told)}.`;
    case DecisionOutcome.EXPLORING:
      return reason === SwitchReason.EXPLORATION
        ? `${activeArm} has been measured, and the next algorithm follows. At the start every algorithm is measured once.`
        : `${activeArm} is being measured. At the start every algorithm is measured once.`;
    default: return `${activeArm} was active. ${outcomeWord(outcome).meaning}`;
  }
}

/** Returns the saving that was expected of the candidate, and the least one that pays for a switch. Both are a time per frame or, if costs are not known, a share of the detection time. */
function whatWouldPay(told: Told): string | undefined {
  const { activeArm, gate } = told;
  const name = other(told);
  if (!gate || !name || !(gate.horizonS > 0)) return undefined;
  const activeNs = costOf(told, activeArm);
  const saved = (gain: number) => {
    const share = -Math.expm1(-gain);
    return activeNs === undefined ? `${percent(share)} of the detection time` : `${nsText(share * activeNs, -Math.expm1(-gate.gain) * activeNs)} per frame`;
  };
  const least = leastGain(gate);
  const condition = least < SMALLEST_GAIN ? `Any saving pays for a switch to ${name}, because its cost and its risk are almost nothing. `
    : `A switch to ${name} pays above a saving of ${saved(least)}: its cost, spread over ${seconds(gate.horizonS)}, and the risk that ${name} is slower. `;
  return condition + `The expected saving, without that risk, is ${saved(gate.gain)}.`;
}

function whatIsBelieved({ leader, bestProbability, expectedLossRatio, verdict }: Told): string | undefined {
  if (!leader) return undefined;
  const leaderProbability = Math.max(...bestProbability);
  return `After this decision ${leader} is the best algorithm with a probability of ${sureText(leaderProbability)}, and choosing it loses ${percent(expectedLossRatio)} on average. `
    + `The verdict on the scene is “${verdictWord(verdict).name}”. It changes when three decisions in a row agree.`;
}

function whatWasMeasured({ activeArm, reward, rewardVersion }: Told): string | undefined {
  if (reward === undefined) return 'The frames before this decision did not become evidence.';
  if (rewardVersion !== LOG_COST_REWARD_VERSION) return `The frames before this decision gave ${activeArm} a reward of ${significant(reward)} (1 is the best).`;
  return `In the frames before this decision ${activeArm} took ${rewardText(reward, true)} per frame, a reward of ${significant(reward)}.`;
}

export const explained = (told: Told): string[] =>
  [whatHappened(told), whatWouldPay(told), whatWasMeasured(told), whatIsBelieved(told)].filter((each): each is string => each !== undefined);

const orderText = ({ operatorName, mode, arm }: AuditRow): string =>
  `${operatorName} ${mode === Mode.AI ? 'let the daemon decide' : `ordered the game to keep to ${arm || 'the active algorithm'}`}.`;

// If the row names no operator, the action alone is the sentence.
const actionText = ({ operatorName, action }: AuditRow): string =>
  operatorName ? `${operatorName} ${action}.` : `${action.charAt(0).toUpperCase()}${action.slice(1)}.`;

/** Returns what an executed switch cost, from its row. */
export function costOfSwitch({ switchCost }: AuditRow): string {
  const ns = (switchCost?.rebuildTimeNs ?? 0n) + (switchCost?.settlingCostNs ?? 0n);
  return ns > 0n ? `The change cost ${durationText(msOf(ns))} of frame time.` : 'The change cost no frame time that could be measured.';
}

export function explainedRow(row: AuditRow, setup?: AuditSetup): string[] {
  const { kind, arm } = row;
  const meaning = kindWord(kind).meaning;
  switch (kind) {
    case AuditKind.TICK: return explained(toldOfRow(row, setup));
    case AuditKind.BAIL_OUT: return [meaning, ...explained(toldOfRow(row, setup))];
    case AuditKind.SWITCH: return [`The game now uses ${arm}. ${reasonWord(row.reason).meaning} ${costOfSwitch(row)}`];
    case AuditKind.MODE: return [row.mode === Mode.AI ? 'The daemon decides.' : `The game keeps ${arm}, which a person chose.`];
    case AuditKind.ORDER: return [orderText(row)];
    case AuditKind.ADMIN: return [actionText(row)];
    case AuditKind.SETUP: return [setup ? `${meaning} The policy is ${setup.policy}, and the algorithms are ${setup.arms.join(', ')}.` : meaning];
    default: return [meaning];
  }
}
