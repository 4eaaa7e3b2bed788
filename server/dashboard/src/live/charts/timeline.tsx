// A session's switches over time, with a row per arm: the active arm is filled, cooldown and settling are shaded, and candidates that
// were held back are hollow. The mark under the pointer, or reached with the arrow keys, is described below the chart. Enter or a
// click opens its explanation.
import type { JSX } from 'preact';
import { useId, useMemo, useRef, useState } from 'preact/hooks';
import { shapeOf } from '../parts/arm';
import { clockText } from '../parts/clock';
import { visible } from '../parts/name';
import { armStyle } from './colours';
import { axisTime, LEFT, RIGHT, TIME_STEPS } from './plot';
import { linearTicks } from '../numbers/ticks';
import { crosshairMs, type Range, setRange, zoomAction } from './view_state';
import { useWidth } from './width';
import type { Step } from '../audit/steps';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { explained } from '../audit/explain';
import { msOf } from '../audit/log';
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import { isHeldBack, kindWord, outcomeWord } from '../views/words';

const LANE = 26;
const AXIS = 22;
const REACH = 14; // maximum distance in pixels between pointer and mark
const MARK = 10; // width of a mark in pixels

interface TimelineProps {
  steps: readonly Step[];
  arms: readonly string[];
  domain: Range;
  onOpen: (step: Step) => void;
}

interface Geometry { width: number; height: number; x: (ms: number) => number; ms: (x: number) => number; y: (arm: string) => number; domain: Range }

function geometryOf(width: number, arms: readonly string[], domain: Range): Geometry {
  const span = Math.max(width - LEFT - RIGHT, 1);
  const length = domain.toMs - domain.fromMs;
  return {
    width, domain,
    height: Math.max(arms.length, 1) * LANE + AXIS,
    x: (ms) => LEFT + (span * (Math.min(Math.max(ms, domain.fromMs), domain.toMs) - domain.fromMs)) / length,
    ms: (x) => domain.fromMs + (length * (x - LEFT)) / span,
    y: (arm) => Math.max(arms.indexOf(arm), 0) * LANE + LANE / 2,
  };
}

const overlaps = ({ fromMs, toMs }: Range, domain: Range) => toMs >= domain.fromMs && fromMs <= domain.toMs;

/** Returns at most `count` round clock times within the range, and their distance. */
function timeTicks({ fromMs, toMs }: Range, count: number): { timesMs: number[]; stepMs: number } {
  const stepMs = TIME_STEPS.find((each) => (toMs - fromMs) / each <= count);
  if (!stepMs) return { timesMs: linearTicks(fromMs, toMs, count), stepMs: 86_400_000 };
  const timesMs: number[] = [];
  for (let ms = Math.ceil(fromMs / stepMs) * stepMs; ms <= toMs; ms += stepMs) timesMs.push(ms);
  return { timesMs, stepMs };
}

function Lanes({ arms, geometry: { width, height, x, domain } }: { arms: readonly string[]; geometry: Geometry }) {
  const { timesMs, stepMs } = timeTicks(domain, Math.max(2, Math.floor(width / 110)));
  return (
    <g font-size=".73rem" fill="var(--soft)">
      {timesMs.map((ms) => (
        <g key={ms}>
          <line x1={x(ms)} x2={x(ms)} y1={0} y2={height - AXIS} stroke="var(--rule)" />
          <text x={x(ms)} y={height - 6} text-anchor="middle">{axisTime(ms, stepMs)}</text>
        </g>
      ))}
      {arms.map((arm, i) => (
        <g key={arm}>
          <line x1={LEFT} x2={width - RIGHT} y1={(i + 1) * LANE} y2={(i + 1) * LANE} stroke="var(--rule)" />
          <text x={LEFT - 10} y={i * LANE + LANE / 2 + 4} text-anchor="end" fill="var(--text)">{[...visible(arm)].slice(0, 11).join('')}</text>
        </g>
      ))}
    </g>
  );
}

const placed = ({ fromMs, arm }: Mark, { x, y }: Geometry) => `M${x(fromMs).toFixed(1)} ${y(arm)}`;

// Returns the path of a bar for the time of a run of decisions; '' if it is too short to draw.
function pill({ fromMs, toMs, arm }: Mark, { x, y }: Geometry): string {
  const width = x(toMs) - x(fromMs);
  if (width <= 3) return '';
  const inner = Math.max(width - 8, 0).toFixed(1);
  return `M${(x(fromMs) + 4).toFixed(1)} ${y(arm) - 4}h${inner}a4 4 0 0 1 0 8h-${inner}a4 4 0 0 1 0-8z`;
}

function Sign({ mark, geometry: { x, y } }: { mark: Mark; geometry: Geometry }) {
  return <text class="mark" x={x(mark.fromMs)} y={y(mark.arm) + 5} text-anchor="middle" font-size=".93rem" font-weight="700" fill="var(--text)">{mark.sign}</text>;
}

// The marks of one arm.
function Marks({ marks, arm, arms, geometry, isOn = false }: { marks: readonly Mark[]; arm: string; arms: readonly string[]; geometry: Geometry; isOn?: boolean }) {
  const { colour } = armStyle(arm, arms);
  const shapes = (isHollow: boolean) => marks.filter((mark) => !mark.sign && mark.isHollow === isHollow).map((mark) => placed(mark, geometry) + shapeOf(arm)).join('');
  return (
    <g class={isOn ? 'mark on' : 'mark'} stroke={colour} stroke-width={isOn ? 2.5 : 1.5}>
      <path d={marks.map((mark) => pill(mark, geometry)).join('')} fill="none" />
      <path d={shapes(true)} fill="var(--card)" />
      <path d={shapes(false)} fill={colour} />
      <g stroke="none">{marks.filter(({ sign }) => sign).map((mark) => <Sign key={`${mark.fromMs} ${mark.sign}`} mark={mark} geometry={geometry} />)}</g>
    </g>
  );
}

// Draws all bars as one path, which is much faster than one shape per bar.
function Bars({ intervals, geometry: { x, ms, domain }, y, height, ...rest }: { intervals: readonly Range[]; geometry: Geometry; y: number; height: number } & JSX.SVGAttributes<SVGPathElement>) {
  const shown = joined(intervals.filter((each) => overlaps(each, domain)), ms(1) - ms(0));
  const d = shown.map(({ fromMs, toMs }) => `M${x(fromMs).toFixed(1)} ${y}h${Math.max(x(toMs) - x(fromMs), 1.5).toFixed(1)}v${height}H${x(fromMs).toFixed(1)}z`);
  return <path d={d.join('')} {...rest} />;
}

// The part of the picture that does not depend on the pointer. Bars less than a pixel apart are joined. Short marks that would overlap a
// shown mark of the same arm and look are left out. Long sessions are therefore drawn fast.
function Still({ timeline: { shades, spans, marks }, arms, geometry, settling }: { timeline: Timeline; arms: readonly string[]; geometry: Geometry; settling: string }) {
  const { y, ms, height, domain } = geometry;
  const shadesOf = (kind: Shade['kind']) => ({ class: kind, intervals: shades.filter((shade) => shade.kind === kind), geometry, y: 0, height: height - AXIS });
  const shown = thinned(marks.filter((mark) => overlaps(mark, domain)), ms(MARK) - ms(0));
  return (
    <g>
      <Bars {...shadesOf('cooldown')} fill="var(--soft)" opacity="0.14" />
      <Bars {...shadesOf('settling')} fill={`url(#${settling})`} />
      <Lanes arms={arms} geometry={geometry} />
      {arms.map((arm) => (
        <Bars key={arm} class="span" intervals={spans.filter((span) => span.arm === arm)} geometry={geometry} y={y(arm) - 7} height={14}
          fill={armStyle(arm, arms).colour} opacity="0.75" />
      ))}
      {arms.map((arm) => <Marks key={arm} marks={shown.filter((mark) => mark.arm === arm)} arm={arm} arms={arms} geometry={geometry} />)}
    </g>
  );
}

function Crosshair({ geometry: { x, height, domain } }: { geometry: Geometry }) {
  const at = crosshairMs.value;
  if (at === undefined || at < domain.fromMs || at > domain.toMs) return null;
  return <line x1={x(at)} x2={x(at)} y1={0} y2={height - AXIS} stroke="var(--text)" stroke-dasharray="3 3" pointer-events="none" />;
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

export function TimelineChart({ steps, arms, domain, onOpen }: TimelineProps) {
  const { element, width } = useWidth<HTMLDivElement>();
  const timeline = useMemo(() => timelineOf(steps, arms, domain.toMs), [steps, arms, domain.toMs]);
  const [on, setOn] = useState<Mark | undefined>(undefined);
  const settling = useId();
  const brush = useRef<number | undefined>(undefined);
  const [brushTo, setBrushTo] = useState<number | undefined>(undefined);
  const geometry = geometryOf(width, arms, domain);
  const { ms, height } = geometry;
  const still = useMemo(() => <Still timeline={timeline} arms={arms} geometry={geometry} settling={settling} />,
    [timeline, arms, width, domain.fromMs, domain.toMs]);

  const placeOf = (event: PointerEvent): [number, number] => {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  function onPointerMove(event: PointerEvent): void {
    const [px, py] = placeOf(event);
    crosshairMs.value = px < LEFT || px > width - RIGHT ? undefined : ms(px);
    setOn(nearestMark(timeline.marks, geometry, px, py));
    if (brush.current !== undefined) setBrushTo(px);
  }
  function onPointerUp(event: PointerEvent): void {
    const from = brush.current;
    const [to] = placeOf(event);
    brush.current = undefined;
    setBrushTo(undefined);
    if (from !== undefined && Math.abs(to - from) > 6) setRange({ fromMs: ms(Math.min(from, to)), toMs: ms(Math.max(from, to)) });
    else if (on) onOpen(on.step);
  }
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
    <div ref={element} class="timeline">
      {width > 0 && (
        <svg class="picture" width={width} height={height} viewBox={`0 0 ${width} ${height}`} tabindex={0} role="group"
          aria-label="Switches over time. Arrow keys go from decision to decision, Enter explains one." onPointerMove={onPointerMove}
          onPointerDown={(event) => { brush.current = placeOf(event)[0]; }} onPointerUp={onPointerUp}
          onPointerLeave={() => { crosshairMs.value = undefined; brush.current = undefined; setBrushTo(undefined); }} onKeyDown={onKeyDown}
          onDblClick={() => setRange(undefined)}>
          <defs>
            <pattern id={settling} width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
              <rect width="3" height="6" fill="var(--soft)" opacity="0.45" />
            </pattern>
          </defs>
          {still}
          {on && overlaps(on, domain) && <Marks marks={[on]} arm={on.arm} arms={arms} geometry={geometry} isOn />}
          {brush.current !== undefined && brushTo !== undefined && (
            <rect x={Math.min(brush.current, brushTo)} width={Math.abs(brushTo - brush.current)} y={0} height={height - AXIS} fill="var(--accent)" opacity="0.2" />
          )}
          <Crosshair geometry={geometry} />
        </svg>
      )}
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

/** Returns a sentence that explains a mark. */
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

/** Returns the marks without short ones that would overlap: those shorter than `gapMs` that begin less than `gapMs` after a kept mark of
 * the same look and arm. */
export function thinned(marks: readonly Mark[], gapMs: number): Mark[] {
  const shownMs = new Map<string, number>();
  return marks.filter(({ arm, isHollow, sign, fromMs, toMs }) => {
    const look = `${arm}\n${isHollow} ${sign}`;
    if (fromMs - (shownMs.get(look) ?? -Infinity) < gapMs && toMs - fromMs < gapMs) return false;
    shownMs.set(look, fromMs);
    return true;
  });
}
