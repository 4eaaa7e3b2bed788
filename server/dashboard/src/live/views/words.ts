// What the protocol's values are called on the page, and what they mean to somebody who makes a game and has never heard of a bandit:
// the only place where they have words.
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionEnd, SessionState } from '../../gen/sweepstake/v1/sessions_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';

/** A short name, a sentence that explains it, and a mark that tells it from others without colour. */
export interface Word { name: string; meaning: string; mark: string }

/** What somebody who comes to the page for the first time has to know. */
export const GLOSSARY: readonly (readonly [string, string])[] = [
  ['arm', 'One of the broad phases that a game can run, as SAP or KDTree.'],
  ['detection time', 'What the broad phase takes of a frame.'],
  ['window', 'The frames between two decisions, which are one measurement of the arm that ran.'],
  ['shadow lane', 'A thread of the game that runs the other arms on copies of some frames, beside the frame thread.'],
  ['P(best)', 'The probability that an arm is the cheapest one of its scene, as far as is known.'],
  ['policy', 'What chooses: it draws a cost for each arm from what is believed of it, and takes the least (Thompson sampling).'],
  ['prior', 'What a session begins with: what earlier sessions, builds and machines have taught.'],
];

const word = (name: string, mark: string, meaning: string): Word => ({ name, meaning, mark });
const UNKNOWN = word('unknown', '?', 'The daemon is newer than this page and says something that the page does not know.');

const OUTCOMES: Readonly<Record<DecisionOutcome, Word>> = {
  [DecisionOutcome.UNSPECIFIED]: UNKNOWN,
  [DecisionOutcome.KEPT]: word('kept', '•', 'The active arm is the one that the policy would take.'),
  [DecisionOutcome.SWITCHED]: word('switched', '→', 'The game was told to use another arm.'),
  [DecisionOutcome.HELD_COOLDOWN]: word('held: cooldown', '○', 'Another arm looks better, but the last switch is too recent.'),
  [DecisionOutcome.HELD_SETTLING]: word('held: settling', '◌',
    'The active arm is new, or a switch is under way; first frames build structures and warm caches, so that nothing is learnt from them.'),
  [DecisionOutcome.NO_FRAMES]: word('no frames', '–', 'No frame that searches has come since the last decision: the game pauses, loads, shows a menu, or stands still.'),
  [DecisionOutcome.MANUAL]: word('manual', '✋', 'The game keeps to an arm that a person chose; what it costs is recorded, and not learnt.'),
  [DecisionOutcome.EXPLORING]: word('exploring', '⌕', 'At the start every arm is measured once before any is preferred.'),
  [DecisionOutcome.REJECTED]: word('rejected', '✗', 'A measurement was no finite number; the whole window was thrown away.'),
  [DecisionOutcome.HELD_GATE]: word('held: does not pay', '○', 'Another arm looks better, but not by enough to pay for the switch.'),
  [DecisionOutcome.HELD_TIE]: word('held: tie', '○', 'Another arm looks better, but by so little that it does not matter.'),
};

const REASONS: Readonly<Record<SwitchReason, Word>> = {
  [SwitchReason.UNSPECIFIED]: word('no switch', '–', 'Nothing was switched.'),
  [SwitchReason.POLICY]: word('policy', '→', 'It cost the least in this draw from what is believed of each arm.'),
  [SwitchReason.EXPLORATION]: word('exploration', '⌕', 'It was its turn to be measured.'),
  [SwitchReason.BAIL_OUT]: word('bail-out', '!', 'A frame took longer than the bail-out limit, and the arm was to blame.'),
  [SwitchReason.MANUAL]: word('manual', '✋', 'A person chose it.'),
};

const VERDICTS: Readonly<Record<Verdict, Word>> = {
  [Verdict.UNSPECIFIED]: word('unknown', '?', 'Nothing is decided yet.'),
  [Verdict.STABLE]: word('stable', '●', 'One arm is very probably the best.'),
  [Verdict.TIE]: word('tie', '=', 'No arm is clearly the best, but choosing the leader loses too little to matter.'),
  [Verdict.AMBIGUOUS]: word('ambiguous', '≈', 'No arm is clearly the best, and choosing the leader may lose enough to matter: more measurements are needed.'),
  [Verdict.DEGRADED]: word('degraded', '▼', 'Even the best arm misses the frame-rate floor: another arm does not help, a lighter scene would.'),
};

const MODES: Readonly<Record<Mode, Word>> = {
  [Mode.UNSPECIFIED]: UNKNOWN,
  [Mode.MANUAL]: word('Manual', '✋', 'The game keeps to an arm that a person chose; nothing becomes evidence.'),
  [Mode.AI]: word('AI decides', '◆', 'The daemon chooses the arm.'),
};

const STATES: Readonly<Record<SessionState, Word>> = {
  [SessionState.UNSPECIFIED]: UNKNOWN,
  [SessionState.CONNECTED]: word('connected', '●', 'The game is connected.'),
  [SessionState.LOST]: word('lost', '○', 'The connection was lost; the game may come back.'),
  [SessionState.ENDING]: word('ending', '◌', 'The session has ended, and its last evidence is being written.'),
};

const ENDS: Readonly<Record<SessionEnd, Word>> = {
  [SessionEnd.UNSPECIFIED]: word('gone', '–', 'It was not there any more when the page was connected again.'),
  [SessionEnd.GOODBYE]: word('ended', '■', 'The game ended it.'),
  [SessionEnd.KICKED]: word('kicked', '✗', 'Somebody who runs the daemon ended it.'),
  [SessionEnd.FORGOTTEN]: word('forgotten', '…', 'The game did not come back in time; it may come back from the store.'),
};

const KINDS: Readonly<Record<string, Word>> = {
  setup: word('setup', '▶', 'A session began, or came back after a restart of the daemon.'),
  tick: word('decision', '•', 'The policy was asked, as it is every few seconds.'),
  'bail-out': word('bail-out', '!', 'A frame took longer than the bail-out limit.'),
  switch: word('switch done', '→', 'The game has changed to another arm.'),
  refusal: word('switch refused', '✗', 'The game did not do what it was told.'),
  mode: word('mode', '◆', 'The game changed who decides.'),
  order: word('order', '✋', 'An operator told the game who is to decide.'),
  missing: word('rows missing', '…', 'Rows stood here that were removed, since the log has bounds, or that could not be written.'),
  admin: word('administration', '⚙', 'An administrator did something.'),
};

export const outcomeWord = (value: DecisionOutcome) => OUTCOMES[value] ?? UNKNOWN;
export const reasonWord = (value: SwitchReason) => REASONS[value] ?? UNKNOWN;
export const verdictWord = (value: Verdict) => VERDICTS[value] ?? UNKNOWN;
export const modeWord = (value: Mode) => MODES[value] ?? UNKNOWN;
export const stateWord = (value: SessionState) => STATES[value] ?? UNKNOWN;
export const endWord = (value: SessionEnd) => ENDS[value] ?? UNKNOWN;
export const kindWord = (kind: string) => KINDS[kind] ?? UNKNOWN;
export const KIND_NAMES = Object.keys(KINDS);

// The audit log has the protocol's names in lower case: held-cooldown.
function valueOf<Value extends number>(names: Readonly<Record<string, string | number>>, text: string): Value {
  const value = names[text.toUpperCase().replaceAll('-', '_')];
  return (typeof value === 'number' ? value : 0) as Value;
}
export const outcomeOf = (text: string) => valueOf<DecisionOutcome>(DecisionOutcome, text);
export const reasonOf = (text: string) => valueOf<SwitchReason>(SwitchReason, text);
export const verdictOfText = (text: string) => valueOf<Verdict>(Verdict, text);
/** Those that a tick of the audit log can have, as it writes them. */
export const OUTCOME_NAMES = Object.keys(OUTCOMES).map(Number).filter((value) => value > 0)
  .map((value) => DecisionOutcome[value]!.toLowerCase().replaceAll('_', '-'));

/** Another arm was believed better, and was not taken. */
export const isHeldBack = (outcome: DecisionOutcome) =>
  [DecisionOutcome.HELD_COOLDOWN, DecisionOutcome.HELD_GATE, DecisionOutcome.HELD_TIE].includes(outcome);
