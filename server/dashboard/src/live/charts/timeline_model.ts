// What a session's timeline shows: which arm ran when, when a switch was not allowed or nothing was learnt, and what was decided.
import type { Step } from '../audit/steps';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { explained } from '../audit/explain';
import { isHeldBack, kindWord, outcomeWord } from '../views/words';
import type { Range } from './view_state';

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
  if (SIGNED.includes(kind)) return { ...mark, sign: kindWord(kind).mark };
  if (!told?.candidate || told.candidate === told.activeArm) return undefined;
  if (told.outcome === DecisionOutcome.SWITCHED) return { ...mark, arm: told.candidate };
  return isHeldBack(told.outcome) ? { ...mark, arm: told.candidate, isHollow: true } : undefined;
}

/** Returns what a mark means. */
export function wordsOf({ sign, step: { kind, told } }: Mark): string {
  if (sign || !told) return `${kindWord(kind).name}. ${kindWord(kind).meaning}`;
  return `${outcomeWord(told.outcome).name}. ${explained(told)[0] ?? ''}`;
}

const goesOn = (run: Mark, next: Mark) =>
  run.isHollow && next.isHollow && run.arm === next.arm && run.step.told?.outcome === next.step.told?.outcome;

/** REQUIRES: times ascend. `arms`: those that have a lane. `endMs`: until when the last arm is shown. */
export function timelineOf(steps: readonly Step[], arms: readonly string[], endMs: number): Timeline {
  const timeline: Timeline = { spans: [], shades: [], marks: [] };
  let lengths: Lengths = { cooldownMs: 0, settlingMs: 0 };
  let lastDecision: Mark | undefined; // the mark of the decision just before, if it has one
  for (const step of steps) {
    lengths = lengthsAt(step, lengths);
    addSpan(timeline, step, lengths);
    const found = markOf(step, timeline.spans.at(-1)?.arm ?? '');
    const mark = found && arms.includes(found.arm) ? found : undefined;
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
  for (const before of shades.slice(-2)) if (before.kind === 'cooldown') before.toMs = Math.min(before.toMs, timeMs); // a new one takes its place
  if (cooldownMs > 0) shades.push({ kind: 'cooldown', fromMs: timeMs, toMs: timeMs + cooldownMs });
  if (settlingMs > 0) shades.push({ kind: 'settling', fromMs: timeMs, toMs: timeMs + settlingMs });
}

/** Returns the intervals, those that are less than `gapMs` apart as one. REQUIRES: they are in the order of their beginnings. */
export function joined(intervals: readonly Range[], gapMs: number): Range[] {
  const all: Range[] = [];
  for (const { fromMs, toMs } of intervals) {
    const last = all.at(-1);
    if (last && fromMs - last.toMs < gapMs) last.toMs = Math.max(last.toMs, toMs);
    else all.push({ fromMs, toMs });
  }
  return all;
}

/** Returns the marks without those that would cover one of the same look, less than `gapMs` before them in their lane. */
export function thinned(marks: readonly Mark[], gapMs: number): Mark[] {
  const shownMs = new Map<string, number>();
  return marks.filter(({ arm, isHollow, sign, fromMs, toMs }) => {
    const look = `${arm}\n${isHollow} ${sign}`;
    if (fromMs - (shownMs.get(look) ?? -Infinity) < gapMs && toMs - fromMs < gapMs) return false;
    shownMs.set(look, fromMs);
    return true;
  });
}
