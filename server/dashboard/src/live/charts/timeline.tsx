// A session's switches over time, with a row per arm: the active arm is filled, cooldown and settling are shaded, and candidates that
// were held back are hollow. The mark under the pointer, or reached with the arrow keys, is described below the chart. Enter or a
// click opens its explanation.
import { useMemo, useState } from 'preact/hooks';
import uPlot from 'uplot';
import { counted } from '../../format';
import { shapeOf } from '../parts/arm';
import { clockText } from '../parts/clock';
import { visible } from '../parts/name';
import { armStyle, hatched, resolved, translucent } from './colours';
import { fontOf } from './plot';
import { usePlot } from './time_chart';
import { crosshairMs, type Range, zoomAction } from './view_state';
import { useWidth } from './width';
import type { Step } from '../audit/steps';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { explained } from '../audit/explain';
import { msOf } from '../audit/log';
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import { isHeldBack, kindWord, outcomeWord } from '../views/words';

const LANE = 26;
const AROUND = 38; // the axis of times, and the margin above the rows
const REACH = 14; // maximum distance in pixels between pointer and mark
const MARK = 10; // width of a mark in pixels
const LABEL = 11; // characters of a row's name

interface TimelineProps {
  steps: readonly Step[];
  arms: readonly string[];
  domain: Range;
  onOpen: (step: Step) => void;
}

// Positions in CSS pixels within the plotting area.
interface Geometry { x: (ms: number) => number; y: (arm: string) => number; msPerPixel: number; domain: Range }

const geometryOf = (plot: uPlot, arms: readonly string[], domain: Range): Geometry => ({
  domain,
  x: (ms) => plot.valToPos(Math.min(Math.max(ms, domain.fromMs), domain.toMs), 'x'),
  y: (arm) => plot.valToPos(Math.max(arms.indexOf(arm), 0) + 0.5, 'y'),
  msPerPixel: plot.posToVal(1, 'x') - plot.posToVal(0, 'x'),
});

const overlaps = ({ fromMs, toMs }: Range, domain: Range) => toMs >= domain.fromMs && fromMs <= domain.toMs;

const placed = ({ fromMs, arm }: Mark, { x, y }: Geometry) => `M${x(fromMs).toFixed(1)} ${y(arm)}`;

// Returns the path of a bar for the time of a run of decisions; '' if it is too short to draw.
function pill({ fromMs, toMs, arm }: Mark, { x, y }: Geometry): string {
  const width = x(toMs) - x(fromMs);
  if (width <= 3) return '';
  const inner = Math.max(width - 8, 0).toFixed(1);
  return `M${(x(fromMs) + 4).toFixed(1)} ${y(arm) - 4}h${inner}a4 4 0 0 1 0 8h-${inner}a4 4 0 0 1 0-8z`;
}

function paintMarks(ctx: CanvasRenderingContext2D, marks: readonly Mark[], arm: string, arms: readonly string[], geometry: Geometry, isOn = false): void {
  const colour = resolved(armStyle(arm, arms).colour);
  const shapes = (isHollow: boolean) => new Path2D(marks.filter((mark) => !mark.sign && mark.isHollow === isHollow).map((mark) => placed(mark, geometry) + shapeOf(arm)).join(''));
  ctx.strokeStyle = colour;
  ctx.lineWidth = isOn ? 2.5 : 1.5;
  ctx.stroke(new Path2D(marks.map((mark) => pill(mark, geometry)).join('')));
  for (const [shape, fill] of [[shapes(true), resolved('var(--card)')], [shapes(false), colour]] as const) {
    ctx.fillStyle = fill;
    ctx.fill(shape);
    ctx.stroke(shape);
  }
  ctx.fillStyle = resolved('var(--text)');
  for (const mark of marks) if (mark.sign) ctx.fillText(mark.sign, geometry.x(mark.fromMs), geometry.y(mark.arm));
}

// Returns all bars as one path, which is much faster to draw than one shape per bar. Bars less than a pixel apart are joined.
function bars(intervals: readonly Range[], { x, msPerPixel, domain }: Geometry, y: number, height: number): Path2D {
  const shown = joined(intervals.filter((each) => overlaps(each, domain)), msPerPixel);
  return new Path2D(shown.map(({ fromMs, toMs }) => `M${x(fromMs).toFixed(1)} ${y}h${Math.max(x(toMs) - x(fromMs), 1.5).toFixed(1)}v${height}H${x(fromMs).toFixed(1)}z`).join(''));
}

function paint(plot: uPlot, { shades, spans, marks }: Timeline, arms: readonly string[], domain: Range, on: Mark | undefined): void {
  const { ctx, bbox } = plot;
  const geometry = geometryOf(plot, arms, domain);
  const shown = thinned(marks.filter((mark) => overlaps(mark, domain)), MARK * geometry.msPerPixel);
  const fill = (style: string | CanvasPattern, intervals: readonly Range[], y: number, height: number) => {
    ctx.fillStyle = style;
    ctx.fill(bars(intervals, geometry, y, height));
  };
  ctx.save();
  ctx.translate(bbox.left, bbox.top);
  ctx.scale(uPlot.pxRatio, uPlot.pxRatio);
  ctx.setLineDash([]);
  ctx.lineJoin = 'round';
  ctx.font = `700 ${fontOf(14)}`;
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
  fill(translucent('var(--soft)', 0.14), shades.filter(({ kind }) => kind === 'cooldown'), 0, arms.length * LANE);
  ctx.globalAlpha = 0.5;
  fill(hatched(ctx, 'var(--soft)', 1), shades.filter(({ kind }) => kind === 'settling'), 0, arms.length * LANE);
  ctx.globalAlpha = 1;
  for (const arm of arms) fill(translucent(armStyle(arm, arms).colour, 0.75), spans.filter((span) => span.arm === arm), geometry.y(arm) - 7, 14);
  for (const arm of arms) paintMarks(ctx, shown.filter((mark) => mark.arm === arm), arm, arms, geometry);
  if (on && overlaps(on, domain)) paintMarks(ctx, [on], on.arm, arms, geometry, true);
  ctx.restore();
}

function nearestMark(marks: readonly Mark[], { x, y, domain }: Geometry, px: number, py: number): Mark | undefined {
  let best: Mark | undefined;
  let reach = REACH;
  for (const mark of marks) {
    if (!overlaps(mark, domain)) continue;
    const away = Math.hypot(Math.max(x(mark.fromMs) - px, 0, px - x(mark.toMs)), y(mark.arm) - py);
    if (away < reach) [reach, best] = [away, mark];
  }
  return best;
}

function spoken(mark: Mark | undefined): string {
  if (!mark) return 'Point to a mark, or select one with the arrow keys. Enter explains the selected mark.';
  const time = clockText(mark.fromMs);
  return mark.count > 1 ? `${time} to ${clockText(mark.toMs)}, ${mark.count} decisions: ${wordsOf(mark)}` : `${time}: ${wordsOf(mark)}`;
}

// Returns the action of a key, or undefined: arrows go from mark to mark.
function actionOf(key: string, marks: readonly Mark[], on: Mark | undefined, domain: Range, go: (mark: Mark | undefined) => void): (() => void) | undefined {
  const shown = marks.filter((mark) => overlaps(mark, domain));
  const place = on ? shown.indexOf(on) : -1;
  const goTo = (to: number) => () => go(shown[Math.min(Math.max(to, 0), shown.length - 1)]);
  switch (key) {
    case 'ArrowLeft': return goTo(place < 0 ? shown.length - 1 : place - 1);
    case 'ArrowRight': return goTo(place + 1);
    case 'Home': return goTo(0);
    case 'End': return goTo(shown.length - 1);
    case 'Escape': return () => go(undefined);
    default: return zoomAction(key, domain, on?.fromMs ?? domain.toMs);
  }
}

const NO_LINES: readonly [] = [];
const NONE_HIDDEN: ReadonlySet<string> = new Set();

export function TimelineChart({ steps, arms, domain, onOpen }: TimelineProps) {
  const { element: host, width } = useWidth<HTMLDivElement>();
  const timeline = useMemo(() => timelineOf(steps, arms, domain.toMs), [steps, arms, domain.toMs]);
  const [on, setOn] = useState<Mark | undefined>(undefined);
  const { timesMs, lanes } = useMemo(() => ({ timesMs: steps.map(({ timeMs }) => timeMs), lanes: arms.map((arm) => [...visible(arm)].slice(0, LABEL).join('')) }), [steps, arms]);
  const paintAll = useMemo(() => (plot: uPlot) => paint(plot, timeline, arms, domain, on), [timeline, arms, domain.fromMs, domain.toMs, on]);
  const plot = usePlot(host, { timesMs, lanes, domain, paint: paintAll, lines: NO_LINES, scale: 'lanes', format: String, hidden: NONE_HIDDEN }, width, arms.length * LANE + AROUND);
  const onMouseMove = () => plot.current && setOn(nearestMark(timeline.marks, geometryOf(plot.current, arms, domain), plot.current.cursor.left ?? -1, plot.current.cursor.top ?? -1));

  function onKeyDown(event: KeyboardEvent): void {
    const go = (mark: Mark | undefined) => {
      setOn(mark);
      crosshairMs.value = mark?.fromMs;
    };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const action = event.key === 'Enter' && on ? () => onOpen(on.step) : actionOf(event.key, timeline.marks, on, domain, go);
    if (!action) return;
    if (event.key !== 'Escape') event.preventDefault(); // Escape also closes an explanation
    action();
  }
  return (
    <div class="timeline">
      <div ref={host} class={on ? 'plot mark' : 'plot'} tabIndex={0} role="group" onKeyDown={onKeyDown} onMouseMove={onMouseMove} onClick={() => on && onOpen(on.step)}
        onMouseLeave={() => { crosshairMs.value = undefined; }}
        aria-label={`Switches over time, ${counted(timeline.spans.length, 'period', 'periods')}. Arrow keys go from decision to decision, Enter explains one.`} />
      <p class="say" role="status"><bdi>{visible(spoken(on))}</bdi></p>
      <p class="legend soft" aria-hidden="true">▶: the session begins · filled: the active algorithm · hollow: a candidate that was held back · grey: cooldown, when no switch is allowed · hatched: settling, when frames are not evidence</p>
    </div>
  );
}

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
  step: Step; // the first step of the run
}
export interface Timeline { spans: Span[]; shades: Shade[]; marks: Mark[] }

interface Lengths { cooldownMs: number; settlingMs: number }

function lengthsAt(step: Step, before: Lengths): Lengths {
  const setup = step.placed?.setup;
  return { cooldownMs: step.told?.cooldownMs ?? before.cooldownMs, settlingMs: setup ? msOf(setup.settlingNs) : before.settlingMs };
}

// Kinds of steps other than decisions that have a sign.
const SIGNED = new Set([AuditKind.BAIL_OUT, AuditKind.REFUSAL, AuditKind.MODE, AuditKind.ORDER, AuditKind.SETUP]);

function markOf(step: Step, arm: string): Mark | undefined {
  const { told, timeMs, kind } = step;
  const mark = { arm, isHollow: false, sign: '', fromMs: timeMs, toMs: timeMs, count: 1, step };
  if (SIGNED.has(kind)) return { ...mark, sign: kindWord(kind).mark };
  if (!told?.candidate || told.candidate === told.activeArm) return undefined;
  if (told.outcome === DecisionOutcome.SWITCHED) return { ...mark, arm: told.candidate };
  return isHeldBack(told.outcome) ? { ...mark, arm: told.candidate, isHollow: true } : undefined;
}

export function wordsOf({ sign, step: { kind, told } }: Mark): string {
  if (sign || !told) return `${kindWord(kind).name}. ${kindWord(kind).meaning}`;
  return `${outcomeWord(told.outcome).name}. ${explained(told)[0] ?? ''}`;
}

const goesOn = (run: Mark, next: Mark) =>
  run.isHollow && next.isHollow && run.arm === next.arm && run.step.told?.outcome === next.step.told?.outcome;

/** Returns what to draw for the steps. REQUIRES: times ascend. `arms` are the arms that have a row. The last arm is shown until `endMs`. */
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

/** Returns the intervals. Joins intervals less than `gapMs` apart. REQUIRES: they are ordered by their beginnings. */
export function joined(intervals: readonly Range[], gapMs: number): Range[] {
  const all: Range[] = [];
  for (const { fromMs, toMs } of intervals) {
    const last = all.at(-1);
    if (last && fromMs - last.toMs < gapMs) last.toMs = Math.max(last.toMs, toMs);
    else all.push({ fromMs, toMs });
  }
  return all;
}

/** Leaves out marks shorter than `gapMs` that begin less than `gapMs` after a kept mark of the same look and arm. */
export function thinned(marks: readonly Mark[], gapMs: number): Mark[] {
  const shownMs = new Map<string, number>();
  return marks.filter(({ arm, isHollow, sign, fromMs, toMs }) => {
    const look = `${arm}\n${isHollow} ${sign}`;
    if (fromMs - (shownMs.get(look) ?? -Infinity) < gapMs && toMs - fromMs < gapMs) return false;
    shownMs.set(look, fromMs);
    return true;
  });
}
