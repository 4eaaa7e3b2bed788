// What a session's timeline shows: which arm ran when, when a switch was not allowed or nothing was learnt, and what was decided.
import type { Step } from '../audit/steps';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { explained } from '../audit/explain';
import { isHeldBack, kindWord, outcomeWord } from '../views/words';

export interface Span { arm: string; fromMs: number; toMs: number }
export interface Shade { kind: 'cooldown' | 'settling'; fromMs: number; toMs: number }
/** One decision or event, or a run of decisions that held the same candidate back. */
export interface Mark {
  arm: string; // in whose lane it is
  isHollow: boolean;
  sign: string; // '': the arm's own symbol
  fromMs: number;
  toMs: number;
  count: number;
  step: Step; // the first one
  words: string;
}
export interface Timeline { spans: Span[]; shades: Shade[]; marks: Mark[] }

interface Lengths { cooldownMs: number; settlingMs: number }

function lengthsAt({ told, placed }: Step, before: Lengths): Lengths {
  return { cooldownMs: told?.cooldownMs ?? before.cooldownMs, settlingMs: placed?.setup?.settlingMs ?? before.settlingMs };
}

// Other steps than decisions that are worth a sign.
const SIGNED = ['bail-out', 'refusal', 'mode', 'order', 'setup'];

function markOf(step: Step, arm: string): Mark | undefined {
  const { told, timeMs, kind } = step;
  const mark = { arm, isHollow: false, sign: '', fromMs: timeMs, toMs: timeMs, count: 1, step };
  if (SIGNED.includes(kind)) return { ...mark, sign: kindWord(kind).mark, words: `${kindWord(kind).name}. ${kindWord(kind).meaning}` };
  if (!told?.candidate || told.candidate === told.activeArm) return undefined;
  const words = `${outcomeWord(told.outcome).name}. ${explained(told)[0] ?? ''}`;
  if (told.outcome === DecisionOutcome.SWITCHED) return { ...mark, arm: told.candidate, words };
  return isHeldBack(told.outcome) ? { ...mark, arm: told.candidate, isHollow: true, words } : undefined;
}

const goesOn = (run: Mark, next: Mark) =>
  run.isHollow && next.isHollow && run.arm === next.arm && run.step.told?.outcome === next.step.told?.outcome;

/** REQUIRES: times ascend. `endMs`: until when the last arm is shown. */
export function timelineOf(steps: readonly Step[], endMs: number): Timeline {
  const timeline: Timeline = { spans: [], shades: [], marks: [] };
  let lengths: Lengths = { cooldownMs: 0, settlingMs: 0 };
  let lastDecision: Mark | undefined; // the mark of the decision just before, if it has one
  for (const step of steps) {
    lengths = lengthsAt(step, lengths);
    addSpan(timeline, step, lengths);
    const mark = markOf(step, timeline.spans.at(-1)?.arm ?? '');
    if (mark && lastDecision && goesOn(lastDecision, mark)) {
      lastDecision.toMs = mark.toMs;
      ++lastDecision.count;
      continue;
    }
    if (mark) timeline.marks.push(mark);
    if (step.told) lastDecision = mark;
  }
  const last = timeline.spans.at(-1);
  if (last) last.toMs = Math.max(last.toMs, endMs);
  return timeline;
}

function addSpan({ spans, shades }: Timeline, { timeMs, activeArm, kind }: Step, { cooldownMs, settlingMs }: Lengths): void {
  const last = spans.at(-1);
  if (last) last.toMs = timeMs;
  if (!activeArm || activeArm === last?.arm) return;
  spans.push({ arm: activeArm, fromMs: timeMs, toMs: timeMs });
  if (!last || kind === 'setup') return;
  const before = shades.filter((shade) => shade.kind === 'cooldown').at(-1);
  if (before) before.toMs = Math.min(before.toMs, timeMs); // a new cooldown takes its place
  if (cooldownMs > 0) shades.push({ kind: 'cooldown', fromMs: timeMs, toMs: timeMs + cooldownMs });
  if (settlingMs > 0) shades.push({ kind: 'settling', fromMs: timeMs, toMs: timeMs + settlingMs });
}
