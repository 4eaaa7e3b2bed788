// A chart over time: lines and bands, and a legend with the values at the crosshair. All charts of a view share crosshair and zoom.
// Drag to zoom, double-click to show all. Keys: arrows move the crosshair, + and − zoom, 0 shows all.
import { useSignalEffect } from '@preact/signals';
import type { ComponentChildren, RefObject } from 'preact';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import type uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { widened } from '../numbers/widened';
import { clockText } from '../parts/clock';
import { PeriodChoice } from '../parts/period_choice';
import { Name } from '../parts/name';
import { theme } from './colours';
import { ChartFrame } from './frame';
import { createPlot, dataOf, LEAST, LEFT, type Line, type Picture, RIGHT, showCrosshair } from './plot';
import { crosshairMs, hiddenArms, pausedMs, placeAt, setPaused, toggleArm, zoomAction } from './view_state';
import { useIsSeen, useWidth } from './width';

interface TimeChartProps extends Omit<Picture, 'hidden'> { title: string; height?: number }

const isTold = ({ label, width }: Line) => label !== '' && width !== 0;

// Returns the value at an index as text. At the end of the chart, returns the line's last value, because the line may end earlier.
function valueText({ told, values }: Line, place: number, isEnd: boolean, format: (value: number) => string): string {
  const all = told ?? values;
  let at = place;
  while (isEnd && at > 0 && (all[at] === null || all[at] === undefined)) --at;
  const value = all[at];
  return value === null || value === undefined ? '–' : format(value);
}

// The properties whose change needs a new plot, as one string.
const structureOf = ({ lines, bands = [], scale, hidden, lanes }: Picture) =>
  JSON.stringify([lanes, lines.map(({ label, colour, dash, width }) => [label, colour, dash, width]), bands.map(({ upper, lower }) => [upper, lower]), scale,
    [...hidden]]);

function actionOf(key: string, { timesMs, domain }: Picture): (() => void) | undefined {
  const at = crosshairMs.peek() ?? domain.toMs;
  const step = (by: number) => () => {
    const place = Math.min(Math.max(placeAt(timesMs, at) + by, 0), timesMs.length - 1);
    crosshairMs.value = timesMs[place];
  };
  switch (key) {
    case 'ArrowLeft': return step(-1);
    case 'ArrowRight': return step(1);
    case 'Home': return () => { crosshairMs.value = timesMs.find((each) => each >= domain.fromMs); };
    case 'End': return () => { crosshairMs.value = timesMs[placeAt(timesMs, domain.toMs)]; };
    case 'Escape': return () => { crosshairMs.value = undefined; };
    default: return zoomAction(key, domain, at);
  }
}

function Entry({ line: { arm, label, colour, dash }, value }: { line: Line; value: string }) {
  const content = (
    <>
      <svg width="26" height="10" aria-hidden="true">
        <line x1="1" x2="25" y1="5" y2="5" stroke={colour} stroke-width="2.5" stroke-dasharray={dash?.join(' ') ?? ''} />
      </svg>
      {' '}<Name text={label} /> <span class="value">{value}</span>
    </>
  );
  if (!arm) return <span class="entry">{content}</span>;
  return (
    <button type="button" class="entry" aria-pressed={!hiddenArms.value.has(arm)} title="Show or hide this line" onClick={() => toggleArm(arm)}>
      {content}
    </button>
  );
}

function Legend({ picture: { lines, timesMs, format, domain } }: { picture: Picture }) {
  const at = crosshairMs.value;
  const place = placeAt(timesMs, at ?? domain.toMs);
  return (
    <div class="legend">
      {lines.filter(isTold).map((line) => <Entry key={line.label} line={line} value={valueText(line, place, at === undefined, format)} />)}
      <time class="soft">{at === undefined ? '' : clockText(at)}</time>
    </div>
  );
}

function useTimes({ timesMs, states, domain: { fromMs, toMs } }: Pick<Picture, 'timesMs' | 'states' | 'domain'>, width: number): readonly number[] {
  const leastMs = (LEAST * (toMs - fromMs)) / Math.max(width - LEFT - RIGHT, 1);
  return useMemo(() => (states ? widened(timesMs, states, { fromMs, toMs }, leastMs) : timesMs), [timesMs, states, fromMs, toMs, leastMs]);
}

/** Draws a picture into `host`, and again if it changes while it is on the screen. Returns the plot. */
export function usePlot(host: RefObject<HTMLElement>, picture: Picture, width: number, height: number): RefObject<uPlot> {
  const latest = useRef(picture);
  latest.current = picture;
  const isSeen = useIsSeen(host); // a chart outside the screen is not redrawn
  const plot = useRef<uPlot | null>(null);
  const drawn = useRef('');
  if (isSeen) drawn.current = structureOf(picture);
  const structure = drawn.current;
  const create = () => {
    plot.current?.destroy();
    plot.current = host.current && width > 0 ? createPlot(host.current, () => latest.current, width, height) : null;
    if (plot.current) showCrosshair(plot.current, crosshairMs.peek());
  };
  useEffect(() => {
    create();
    return () => {
      plot.current?.destroy();
      plot.current = null;
    };
  }, [structure, theme.value, width === 0]);
  useEffect(() => { if (width > 0) plot.current?.setSize({ width, height }); }, [width, height]);
  useEffect(() => { if (isSeen) plot.current?.setData(dataOf(picture)); },
    [isSeen, picture.timesMs, picture.lines, picture.moments, picture.paint, picture.values?.join(' '), picture.domain.fromMs, picture.domain.toMs]);
  useEffect(() => {
    addEventListener('beforeprint', create); // a printed page contains charts that are outside the screen
    return () => removeEventListener('beforeprint', create);
  }, [width, height]);
  useSignalEffect(() => {
    const at = crosshairMs.value;
    if (plot.current && !host.current?.matches(':hover')) showCrosshair(plot.current, at);
  });
  return plot;
}

function TimeChart({ title, height = 200, ...rest }: TimeChartProps) {
  const { element: host, width } = useWidth<HTMLDivElement>();
  const picture: Picture = { ...rest, timesMs: useTimes(rest, width), hidden: hiddenArms.value };
  const [spoken, setSpoken] = useState('');
  usePlot(host, picture, width, height);

  function onKeyDown(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const action = actionOf(event.key, picture);
    if (!action) return;
    if (event.key !== 'Escape') event.preventDefault(); // Escape also closes an explanation
    action();
    const place = placeAt(picture.timesMs, crosshairMs.peek() ?? picture.domain.toMs);
    setSpoken(picture.lines.filter(isTold).map((line) => `${line.label} ${valueText(line, place, false, picture.format)}`).join(', '));
  }

  return (
    <div class="time-chart">
      <div ref={host} class="plot" tabIndex={0} role="group" aria-label={`${title}. Arrow keys move the crosshair, plus and minus zoom, 0 shows all.`}
        onKeyDown={onKeyDown} onMouseLeave={() => { crosshairMs.value = undefined; }} />
      <Legend picture={picture} />
      <p class="unseen" role="status">{spoken}</p>
    </div>
  );
}

export interface TimeFigureProps extends TimeChartProps {
  id: string;
  note?: ComponentChildren;
  names: readonly string[]; // parts of the names of exported files
  empty?: ComponentChildren; // shown instead of the chart if there is nothing to draw
  unit?: string; // unit of the values in the table
  laterMs?: number; // real time minus drawn time; the table shows real times
  csvHref?: string | undefined;
}

export function TimeFigure({ id, note, names, empty, unit = '', laterMs = 0, csvHref, ...chart }: TimeFigureProps) {
  const { title, timesMs, lines } = chart;
  const table = () => {
    const columns = lines.filter(({ label }) => label !== '');
    return {
      header: ['time', ...columns.map(({ label }) => `${label} ${unit}`.trim())],
      rows: timesMs.map((ms, i) => [new Date(ms + laterMs).toISOString(), ...columns.map(({ told, values }) => (told ?? values)[i] ?? null)]),
    };
  };
  return <ChartFrame id={id} title={title} note={note} names={names} table={table} csvHref={csvHref} empty={empty}><TimeChart {...chart} /></ChartFrame>;
}

export function PauseButton() {
  const isPaused = pausedMs.value !== undefined;
  return <button type="button" aria-pressed={isPaused} onClick={() => setPaused(isPaused ? undefined : Date.now())}>{isPaused ? '▶ Resume' : '❚❚ Pause'}</button>;
}

export function TimeTools() {
  return (
    <div class="time-tools" role="toolbar" aria-label="Time">
      <PauseButton />
      <PeriodChoice />
      {pausedMs.value !== undefined && <span class="soft">Paused at {clockText(pausedMs.value)}.</span>}
      <span class="soft hint">Drag in a chart to zoom. Triangles mark values above the axis.</span>
    </div>
  );
}
