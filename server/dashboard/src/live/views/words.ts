// Names and explanations of the protocol's values, for a game developer who does not know bandit algorithms. All views use them.
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionEnd, SessionState } from '../../gen/sweepstake/v1/sessions_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import type { SceneVerdict } from '../state/summaries';

/** A short name, a sentence that explains it, and a symbol that distinguishes it without colour. */
interface Word { name: string; meaning: string; mark: string }

export const GLOSSARY: readonly (readonly [string, string])[] = [
  ['algorithm', 'One of the broad phases that a game can run, such as SAP or KDTree. The paper and the API call it an arm.'],
  ['detection time', 'The time that the broad phase takes in a frame.'],
  ['window', 'The frames between two decisions. They are one measurement of the algorithm that ran.'],
  ['shadow lane', 'A thread of the game beside the frame thread. It runs the other algorithms on copies of some frames.'],
  ['P(best)', 'The probability that an algorithm is the cheapest of its scene, given the evidence so far.'],
  ['leader', 'The algorithm with the highest P(best) in a scene.'],
  ['regime', 'A period in which the number of objects, their speed and the share of static objects are similar. Each regime has its own costs.'],
  ['reward', 'The cost of a window as a number from 0 to 1; 1 is the best.'],
  ['bail-out', 'A frame that took longer than the bail-out limit. If its algorithm was the cause, the game changes to another algorithm at once.'],
  ['policy', 'The rule that chooses the algorithm. “adaptive” (AI Decides) compares the expected costs, and switches if the expected saving exceeds the cost of the switch. “paper” draws a random reward for each algorithm from its posterior, and takes the highest (Thompson sampling).'],
  ['posterior', 'The distribution of an algorithm’s cost after all measurements. It is narrow if the cost is well known.'],
  ['prior', 'The distribution with which a session begins. It comes from earlier sessions, builds and machines.'],
];

const word = (name: string, mark: string, meaning: string): Word => ({ name, meaning, mark });
const UNKNOWN = word('unknown', '?', 'The daemon is newer than this page and uses a value that the page does not know. Reload the page.');
const wordOf = <Value extends PropertyKey>(words: Readonly<Record<Value, Word>>) => (value: Value): Word => words[value] ?? UNKNOWN;

export const outcomeWord = wordOf<DecisionOutcome>({
  [DecisionOutcome.UNSPECIFIED]: UNKNOWN,
  [DecisionOutcome.KEPT]: word('kept', '•', 'The policy chose the active algorithm again.'),
  [DecisionOutcome.SWITCHED]: word('switched', '→', 'The daemon commanded a switch to another algorithm.'),
  [DecisionOutcome.HELD_COOLDOWN]: word('held: cooldown', '○', 'Another algorithm looks better, but the last switch is too recent.'),
  [DecisionOutcome.HELD_SETTLING]: word('held: settling', '◌',
    'The active algorithm is new, or a switch is in progress. The first frames build data structures and warm caches, so they are not evidence.'),
  [DecisionOutcome.NO_FRAMES]: word('no frames', '–', 'There was no frame with collision detection since the last decision: the game is paused, loads, or shows a menu.'),
  [DecisionOutcome.MANUAL]: word('manual', '✋', 'The game keeps an algorithm that a person chose. Its cost is recorded, but is not evidence.'),
  [DecisionOutcome.EXPLORING]: word('exploring', '⌕', 'At the start every algorithm is measured once before any is preferred.'),
  [DecisionOutcome.REJECTED]: word('rejected', '✗', 'A measurement was not a finite number, so the whole window was discarded.'),
  [DecisionOutcome.HELD_GATE]: word('held: does not pay', '○', 'Another algorithm looks better, but not by enough to pay for the switch.'),
});

export const reasonWord = wordOf<SwitchReason>({
  [SwitchReason.UNSPECIFIED]: word('no switch', '–', 'The algorithm did not change.'),
  [SwitchReason.POLICY]: word('policy', '→', 'The policy chose the algorithm from the posteriors.'),
  [SwitchReason.EXPLORATION]: word('exploration', '⌕', 'The algorithm was the next one to be measured.'),
  [SwitchReason.BAIL_OUT]: word('bail-out', '!', 'A frame took longer than the bail-out limit, and the algorithm was the cause.'),
  [SwitchReason.MANUAL]: word('manual', '✋', 'A person chose the algorithm.'),
});

export const verdictWord = wordOf<SceneVerdict>({
  changing: word('changing', '⇄', 'The best algorithm depends on the regime of the scene, or the session still switches more than four times a minute.'),
  [Verdict.UNSPECIFIED]: word('unknown', '?', 'There is no decision about this scene yet.'),
  [Verdict.STABLE]: word('stable', '●', 'One algorithm is very probably the best.'),
  [Verdict.TIE]: word('tie', '=', 'No algorithm is clearly the best, but the leader costs hardly more than the best algorithm.'),
  [Verdict.AMBIGUOUS]: word('ambiguous', '≈', 'No algorithm is clearly the best, and the leader may cost noticeably more than the best algorithm. More measurements are needed.'),
  [Verdict.DEGRADED]: word('degraded', '▼', 'Even with the best algorithm, the broad phase keeps the frame rate below the frame-rate floor, the required minimum.'),
});

export const modeWord = wordOf<Mode>({
  [Mode.UNSPECIFIED]: UNKNOWN,
  [Mode.MANUAL]: word('Manual', '✋', 'The game keeps an algorithm that a person chose. Its frames do not become evidence.'),
  [Mode.AI]: word('AI decides', '◆', 'The daemon chooses the algorithm.'),
});

export const stateWord = wordOf<SessionState>({
  [SessionState.UNSPECIFIED]: UNKNOWN,
  [SessionState.CONNECTED]: word('connected', '●', 'The game is connected.'),
  [SessionState.LOST]: word('lost', '○', 'The connection was lost. The game may reconnect.'),
  [SessionState.ENDING]: word('ending', '◌', 'The session has ended, and its last evidence is being written.'),
});

export const endWord = wordOf<SessionEnd>({
  [SessionEnd.UNSPECIFIED]: word('gone', '–', 'The session ended while the page was disconnected.'),
  [SessionEnd.GOODBYE]: word('ended', '■', 'The game ended the session.'),
  [SessionEnd.KICKED]: word('kicked', '✗', 'An operator of the daemon ended the session.'),
  [SessionEnd.FORGOTTEN]: word('forgotten', '…', 'The game did not reconnect in time. If it reconnects later, the session can continue from the stored evidence.'),
});

export const kindWord = wordOf<AuditKind>({
  [AuditKind.UNSPECIFIED]: UNKNOWN,
  [AuditKind.SETUP]: word('setup', '▶', 'A session began, or continued after a restart of the daemon.'),
  [AuditKind.TICK]: word('decision', '•', 'The policy made one of its regular decisions.'),
  [AuditKind.BAIL_OUT]: word('bail-out', '!', 'A frame took longer than the bail-out limit.'),
  [AuditKind.SWITCH]: word('switch done', '→', 'The game has changed to another algorithm.'),
  [AuditKind.REFUSAL]: word('switch refused', '✗', 'The game did not execute a switch command.'),
  [AuditKind.MODE]: word('mode', '◆', 'The game changed between manual mode and AI Decides.'),
  [AuditKind.ORDER]: word('order', '✋', 'An operator ordered manual mode or AI Decides.'),
  [AuditKind.MISSING]: word('rows missing', '…', 'Rows are missing here: they were removed because the size of the log is limited, or could not be written.'),
  [AuditKind.ADMIN]: word('administration', '⚙', 'An administrator changed something, such as a token or stored evidence.'),
});

/** Whether another arm looked better but was not chosen. */
export const isHeldBack = (outcome: DecisionOutcome) =>
  [DecisionOutcome.HELD_COOLDOWN, DecisionOutcome.HELD_GATE].includes(outcome);
