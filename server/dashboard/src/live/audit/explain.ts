// "Why this arm?": a decision in sentences.
import { actionText, operatorOf } from './admin_words';
import type { AuditRow, Setup } from './rows';
import { LOG_COST_REWARD_VERSION, rewardText } from '../numbers/log_cost';
import { DecisionOutcome, type DecisionEvent } from '../../gen/sweepstake/v1/posteriors_pb';
import { SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { significant } from '../../format';
import { kindWord, outcomeOf, outcomeWord, reasonOf, reasonWord, verdictOfText, verdictWord } from '../views/words';

/**
 * What weighed for and against a switch to the candidate: what it is expected to save, and to cost more if it turns out worse, as natural
 * logarithms of ratios of detection times; for how many seconds each counts; and what the switch costs on the same scale (GateTerms of
 * engine_client/decider/types.h).
 */
export interface Gate { gain: number; loss: number; horizonS: number; cooldownS: number; costS: number }

/** A decision as the audit log or the live stream has it. */
export interface Told {
  activeArm: string;
  candidate: string; // '': none
  outcome: DecisionOutcome;
  reason: SwitchReason;
  reward?: number; // absent: the window taught nothing
  rewardVersion: number;
  verdict: Verdict;
  leader: string; // '': nothing is learnt
  leaderProbability: number;
  expectedLossRatio: number;
  gate?: Gate;
  cooldownMs?: number;
}

function gateOf(row: AuditRow): Gate | undefined {
  const gain = row.number('gain');
  if (gain === undefined) return undefined;
  const rest = (['loss', 'horizon_s', 'cooldown_s', 'switch_cost_s'] as const).map((column) => row.number(column) ?? 0);
  return { gain, loss: rest[0]!, horizonS: rest[1]!, cooldownS: rest[2]!, costS: rest[3]! };
}

/** REQUIRES: a row with a decision (a tick or a bail-out). */
export function toldOfRow(row: AuditRow, setup?: Setup): Told {
  const gate = gateOf(row);
  const reward = row.number('reward');
  return {
    activeArm: row.text('active_arm'),
    candidate: row.text('candidate'),
    outcome: outcomeOf(row.text('outcome')),
    reason: reasonOf(row.text('reason')),
    ...(reward !== undefined && { reward }),
    rewardVersion: row.number('reward_version') ?? 0,
    verdict: verdictOfText(row.text('verdict')),
    leader: row.text('leader'),
    leaderProbability: Math.max(0, ...row.numbers('best_probability')),
    expectedLossRatio: row.number('expected_loss_ratio') ?? 0,
    ...(gate && { gate }),
    ...(setup && { cooldownMs: gate ? gate.cooldownS * 1000 : setup.cooldownMs }),
  };
}

export function toldOfEvent(event: DecisionEvent, rewardVersion: number): Told {
  const leaderProbability = Math.max(0, ...event.bestProbability);
  return {
    activeArm: event.activeArm,
    candidate: event.candidateArm,
    outcome: event.outcome,
    reason: event.reason,
    ...(event.reward !== undefined && { reward: event.reward }),
    rewardVersion,
    verdict: event.verdict,
    leader: event.arms[event.bestProbability.indexOf(leaderProbability)] ?? '',
    leaderProbability,
    expectedLossRatio: event.expectedLossRatio,
  };
}

const percent = (share: number) => `${significant(100 * share, 2)} %`;
const seconds = (s: number) => `${significant(s, 2)} s`;

/** Returns a duration as people say it. */
export const durationText = (ms: number) => (ms < 1000 ? `${significant(ms, 2)} ms` : seconds(ms / 1000));

function whatHappened({ activeArm, candidate, outcome, reason, cooldownMs }: Told): string {
  const other = candidate && candidate !== activeArm ? candidate : 'another arm';
  switch (outcome) {
    case DecisionOutcome.SWITCHED: return `The game was told to change from ${activeArm} to ${other}. ${reasonWord(reason).meaning}`;
    case DecisionOutcome.KEPT: return `${activeArm} stays: the policy would take no other arm.`;
    case DecisionOutcome.HELD_COOLDOWN:
      return `${other} looks better, but ${activeArm} stays: after a switch `
        + (cooldownMs === undefined ? 'the cooldown has to pass' : `${durationText(cooldownMs)} have to pass`) + ' before the next one.';
    case DecisionOutcome.HELD_GATE: return `${other} looks better, but ${activeArm} stays: the change would not pay for itself.`;
    case DecisionOutcome.HELD_TIE: return `${other} looks better, but by too little to matter, so ${activeArm} stays.`;
    case DecisionOutcome.EXPLORING:
      return reason === SwitchReason.EXPLORATION
        ? `${activeArm} has been measured, and it is the next arm's turn: at the start every arm is measured once.`
        : `${activeArm} is being measured: at the start every arm is measured once.`;
    default: return `${activeArm} was active. ${outcomeWord(outcome).meaning}`;
  }
}

function whatWeighed({ candidate, activeArm, gate, outcome }: Told): string | undefined {
  if (!gate || !candidate || candidate === activeArm) return undefined;
  const saved = gate.horizonS * gate.gain;
  const risked = gate.cooldownS * gate.loss;
  const pays = saved - risked - gate.costS > 0;
  const worth = (s: number) => (s < 1e-6 ? 'nothing' : durationText(1000 * s));
  const more = Math.expm1(gate.loss);
  const pay = outcome === DecisionOutcome.SWITCHED ? 'pays' : 'would pay';
  return `For ${candidate}: it is expected to save ${percent(-Math.expm1(-gate.gain))} of the detection time for ${seconds(gate.horizonS)}, which counts as ${worth(saved)}. `
    + `Against it: it may turn out to cost ${more < 1e-4 ? 'hardly any' : percent(more)} more for ${seconds(gate.cooldownS)}, until the next switch is allowed, which counts as ${worth(risked)}; `
    + `and the change itself counts as ${worth(gate.costS)}. That ${pays ? pay : 'does not pay'}.`;
}

function whatIsBelieved({ leader, leaderProbability, expectedLossRatio, verdict }: Told): string | undefined {
  if (!leader) return undefined;
  const believed = `After this decision ${leader} is the best arm with a probability of ${leaderProbability > 0.999 ? 'over 99.9 %' : percent(leaderProbability)}, `
    + `and choosing it loses ${percent(expectedLossRatio)} on average.`;
  return `${believed} The scene is called ${verdictWord(verdict).name}: ${verdictWord(verdict).meaning} The word changes when three decisions in a row agree.`;
}

function whatWasMeasured({ activeArm, reward, rewardVersion }: Told): string | undefined {
  if (reward === undefined) return 'Nothing was learnt from the frames before it.';
  if (rewardVersion !== LOG_COST_REWARD_VERSION) return `The frames before it gave ${activeArm} a reward of ${significant(reward)} (1 is the best).`;
  return `In the frames before it ${activeArm} took ${rewardText(reward, true)} per frame, a reward of ${significant(reward)}.`;
}

/** Returns the sentences that explain a decision, the most important one first. */
export const explained = (told: Told): string[] =>
  [whatHappened(told), whatWeighed(told), whatWasMeasured(told), whatIsBelieved(told)].filter((each): each is string => each !== undefined);

function orderText(row: AuditRow): string {
  const who = operatorOf(row.text('setup'));
  if (row.text('mode') === 'ai') return `${who} let the daemon decide.`;
  return `${who} told the game to keep to ${row.text('arm') || 'the active arm'}.`;
}

/** Returns sentences for any row of the audit log. */
export function explainedRow(row: AuditRow, setup?: Setup): string[] {
  const kind = row.text('kind');
  const meaning = kindWord(kind).meaning;
  switch (kind) {
    case 'tick': return explained(toldOfRow(row, setup));
    case 'bail-out': return [meaning, ...explained(toldOfRow(row, setup))];
    case 'switch': {
      const cost = (row.number('rebuild_time_ns') ?? 0) + (row.number('settling_cost_ns') ?? 0);
      return [`The game now uses ${row.text('arm')}. ${reasonWord(reasonOf(row.text('reason'))).meaning} The change cost ${durationText(cost / 1e6)} of frame time.`];
    }
    case 'mode': return [row.text('mode') === 'ai' ? 'The daemon decides.' : `The game keeps to ${row.text('arm')} by hand.`];
    case 'order': return [orderText(row)];
    case 'admin': return [actionText(row)];
    case 'setup': return [`${meaning} Policy ${setup?.policy ?? ''}, arms ${setup?.arms.join(', ') ?? ''}.`];
    default: return [meaning];
  }
}
