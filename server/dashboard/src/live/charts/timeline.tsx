// A session's switches over time, with a row per arm: the active arm is filled, cooldown and settling are shaded, and candidates that
// were held back are hollow. The mark under the pointer, or reached with the arrow keys, is described below the chart. Enter or a
// click opens its explanation.
import type { JSX } from 'preact';
import { useId, useMemo, useRef, useState } from 'preact/hooks';
import type { Step } from '../audit/steps';
import { shapeOf } from '../parts/arm';
import { visible } from '../parts/visible';
import { armStyle } from './arm_style';
import { axisTime, LEFT, RIGHT, TIME_STEPS } from './plot';
import { linearTicks } from '../numbers/ridge';
import { joined, type Mark, type Shade, thinned, type Timeline, timelineOf, wordsOf } from './timeline_model';
import { crosshairMs, range, type Range, setRange, zoomed } from './view_state';
import { useWidth } from './width';

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

// Returns the path of a bar as long as a run of decisions took; '' if it is too short to draw.
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

// Draws all bars as one path, which is many times as fast as one shape per bar.
function Bars({ intervals, geometry: { x, ms, domain }, y, height, ...rest }: { intervals: readonly Range[]; geometry: Geometry; y: number; height: number } & JSX.SVGAttributes<SVGPathElement>) {
  const shown = joined(intervals.filter((each) => overlaps(each, domain)), ms(1) - ms(0));
  const d = shown.map(({ fromMs, toMs }) => `M${x(fromMs).toFixed(1)} ${y}h${Math.max(x(toMs) - x(fromMs), 1.5).toFixed(1)}v${height}H${x(fromMs).toFixed(1)}z`);
  return <path d={d.join('')} {...rest} />;
}

// The part of the picture that does not depend on the pointer. Bars and marks closer than a pixel or a mark's width are merged, so that
// long sessions are drawn fast.
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
  const time = new Date(mark.fromMs).toLocaleTimeString();
  return mark.count > 1 ? `${time} to ${new Date(mark.toMs).toLocaleTimeString()}, ${mark.count} decisions: ${wordsOf(mark)}` : `${time}: ${wordsOf(mark)}`;
}

// Returns the actions of keys: arrows go from mark to mark.
function actionsOf(marks: readonly Mark[], on: Mark | undefined, domain: Range, go: (mark: Mark | undefined) => void, open: (step: Step) => void): Readonly<Record<string, () => void>> {
  const shown = marks.filter((mark) => overlaps(mark, domain));
  const place = on ? shown.indexOf(on) : -1;
  const goTo = (to: number) => go(shown[Math.min(Math.max(to, 0), shown.length - 1)]);
  const about = on?.fromMs ?? domain.toMs;
  const zoomIn = () => setRange(zoomed(domain, about, 0.5));
  return {
    ArrowLeft: () => goTo(place < 0 ? shown.length - 1 : place - 1), ArrowRight: () => goTo(place + 1), Home: () => goTo(0), End: () => goTo(shown.length - 1),
    Enter: () => on && open(on.step), Escape: () => go(undefined),
    '+': zoomIn, '=': zoomIn, '-': () => setRange(range.peek() && zoomed(domain, about, 2)), 0: () => setRange(undefined),
  };
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
    const action = event.ctrlKey || event.metaKey || event.altKey ? undefined : actionsOf(timeline.marks, on, domain, go, onOpen)[event.key];
    if (!action) return;
    event.preventDefault();
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
      <p class="legend soft" aria-hidden="true">filled: the active arm · hollow: a candidate that was held back · grey: cooldown, no switch allowed · hatched: settling, frames are not evidence</p>
    </div>
  );
}
