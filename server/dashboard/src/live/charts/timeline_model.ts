// The data of a session's timeline: which arm ran when, times of cooldown and settling, and the decisions.
import type { Step } from '../audit/steps';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { explained } from '../audit/explain';
import { msOf } from '../audit/log';
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import { isHeldBack, kindWord, outcomeWord } from '../views/words';
import type { Range } from './view_state';

export interface Span { arm: string; fromMs: number; toMs: number }
export interface Shade { kind: 'cooldown' | 'settling'; fromMs: number; toMs: number }
/** One decision or event, or a run of decisions that held the same candidate back. */
export interface Mark {
  arm: string; // the arm in whose row the mark is
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
  return { cooldownMs: told?.cooldownMs ?? before.cooldownMs, settlingMs: placed?.setup ? msOf(placed.setup.settlingNs) : before.settlingMs };
}

// Kinds of steps other than decisions that have a sign.
const SIGNED = [AuditKind.BAIL_OUT, AuditKind.REFUSAL, AuditKind.MODE, AuditKind.ORDER, AuditKind.SETUP];

function markOf(step: Step, arm: string): Mark | undefined {
  const { told, timeMs, kind } = step;
  const mark = { arm, isHollow: false, sign: '', fromMs: timeMs, toMs: timeMs, count: 1, step };
  if (SIGNED.includes(kind)) return { ...mark, sign: kindWord(kind).mark };
  if (!told?.candidate || told.candidate === told.activeArm) return undefined;
  if (told.outcome === DecisionOutcome.SWITCHED) return { ...mark, arm: told.candidate };
  return isHeldBack(told.outcome) ? { ...mark, arm: told.candidate, isHollow: true } : undefined;
}

/** Returns a sentence that explains a mark. */
export function wordsOf({ sign, step: { kind, told } }: Mark): string {
  if (sign || !told) return `${kindWord(kind).name}. ${kindWord(kind).meaning}`;
  return `${outcomeWord(told.outcome).name}. ${explained(told)[0] ?? ''}`;
}

const goesOn = (run: Mark, next: Mark) =>
  run.isHollow && next.isHollow && run.arm === next.arm && run.step.told?.outcome === next.step.told?.outcome;

/** REQUIRES: times ascend. `arms` are the arms that have a row. The last arm is shown until `endMs`. */
export function timelineOf(steps: readonly Step[], arms: readonly string[], endMs: number): Timeline {
  const timeline: Timeline = { spans: [], shades: [], marks: [] };
  let lengths: Lengths = { cooldownMs: 0, settlingMs: 0 };
  let lastDecision: Mark | undefined; // the mark of the previous decision, if it has one
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
  if (!last || kind === AuditKind.SETUP) return;
  for (const before of shades.slice(-2)) if (before.kind === 'cooldown') before.toMs = Math.min(before.toMs, timeMs); // the new cooldown replaces it
  if (cooldownMs > 0) shades.push({ kind: 'cooldown', fromMs: timeMs, toMs: timeMs + cooldownMs });
  if (settlingMs > 0) shades.push({ kind: 'settling', fromMs: timeMs, toMs: timeMs + settlingMs });
}

/** Returns the intervals, joining those less than `gapMs` apart. REQUIRES: they are ordered by their beginnings. */
export function joined(intervals: readonly Range[], gapMs: number): Range[] {
  const all: Range[] = [];
  for (const { fromMs, toMs } of intervals) {
    const last = all.at(-1);
    if (last && fromMs - last.toMs < gapMs) last.toMs = Math.max(last.toMs, toMs);
    else all.push({ fromMs, toMs });
  }
  return all;
}

/** Returns the marks without those less than `gapMs` after a mark of the same look and arm, which they would cover. */
export function thinned(marks: readonly Mark[], gapMs: number): Mark[] {
  const shownMs = new Map<string, number>();
  return marks.filter(({ arm, isHollow, sign, fromMs, toMs }) => {
    const look = `${arm}\n${isHollow} ${sign}`;
    if (fromMs - (shownMs.get(look) ?? -Infinity) < gapMs && toMs - fromMs < gapMs) return false;
    shownMs.set(look, fromMs);
    return true;
  });
}
