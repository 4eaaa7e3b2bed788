// Draws a time chart with uPlot.
import uPlot from 'uplot';
import { compact } from '../../format';
import { rounded } from '../numbers/ticks';
import { clockText, dayText, minuteText } from '../parts/clock';
import { resolved, translucent } from './colours';
import { crosshairMs, type Range, setRange } from './view_state';

/** A line with one value per time; null if there is no value. */
export interface Line {
  label: string;
  values: readonly (number | null)[];
  told?: readonly (number | null)[]; // the values that the legend shows; absent: `values`
  colour: string;
  dash?: readonly number[];
  width?: number; // 0: only the edge of a band
  stepped?: boolean;
  isAside?: boolean; // the range of the axis ignores this line
  arm?: string; // the arm that the line shows; hiding this arm hides the line in all charts
}
/** The area between two lines, given by their indices. */
export interface Band { upper: number; lower: number; fill: (context: CanvasRenderingContext2D) => CanvasPattern | string }
export interface Level {
  value: number;
  label: string; // drawn to the right of the chart, where one word fits
  isAside?: boolean; // the range of the axis ignores this level, which is drawn only if values come near it
}
export interface Moment { timeMs: number; colour: string; label?: string }
/** The axis of values. zero: from 0 upwards; unit: 0 to 1; log: logarithmic, values > 0; lanes: rows with names, numbered from the top. */
export type Scale = 'zero' | 'unit' | 'log' | 'lanes' | 'signed';

export interface Picture {
  timesMs: readonly number[]; // ascending
  states?: readonly unknown[]; // for each time; a run of equal states is at least LEAST pixels wide
  lines: readonly Line[];
  bands?: readonly Band[];
  levels?: readonly Level[];
  moments?: readonly Moment[];
  scale: Scale;
  values?: readonly [number, number]; // the axis of values contains at least this range
  domain: Range;
  format: (value: number) => string;
  hidden: ReadonlySet<string>; // arms
  lanes?: readonly string[]; // the names of the rows
  paint?: (plot: uPlot) => void; // draws more
}

/** Margins in pixels. All charts of a view have the same margins, so that equal times are aligned vertically. */
export const LEFT = 80;
export const RIGHT = 50; // room for half of the last time's text, and for the labels of levels
// Font of `px` pixels at the page's normal font size of 15 px; scaled with the page in very wide windows.
export const fontOf = (px: number) => `${(px / 15) * Number.parseFloat(getComputedStyle(document.documentElement).fontSize)}px system-ui, "DejaVu Sans", sans-serif`;
export const LEAST = 2;
const MOMENT = 4; // minimum distance of moments in pixels
const DENSE = 24; // mean distance of moments in pixels below which they are short, since they would hide the chart
const TICK = 10; // length in pixels of a short moment; in a chart of stacked areas all are short, since lines would cut the areas into stripes
const SECOND = 1000;
const DAY = 86_400 * SECOND;

const TIME_STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10_800, 21_600, 43_200, 86_400, 172_800, 604_800].map((s) => s * SECOND);

/** Returns the label of a time on an axis with steps of `stepMs`. Rounds to seconds, since uPlot's positions are off by fractions of a millisecond. */
export function axisTime(ms: number, stepMs: number): string {
  const text = stepMs >= DAY ? dayText : stepMs >= 60 * SECOND ? minuteText : clockText;
  return text(Math.round(ms / SECOND) * SECOND);
}

/** An axis from 0 that would reach more than this multiple of the usual values ends at OUTLIER_END times the usual values instead. */
const OUTLIER = 2.5;
const OUTLIER_END = 2;

/** Returns the percentile 99.9 of the shown values; undefined if there are none. */
export function usualOf({ timesMs, lines, domain, hidden }: Pick<Picture, 'timesMs' | 'lines' | 'domain' | 'hidden'>): number | undefined {
  const isIn = timesMs.map((ms) => ms >= domain.fromMs && ms <= domain.toMs);
  const all = lines.filter(({ arm, isAside }) => !isAside && !hidden.has(arm ?? ''))
    .flatMap(({ values }) => values.filter((value, i): value is number => value !== null && isIn[i]!)).sort((a, b) => a - b);
  return all[Math.floor(0.999 * (all.length - 1))];
}

/** Returns the range of the axis of values for lines from `min` to `max`, which are null if no line has a value. With `usual` (usualOf),
 * an axis from 0 does not reach outliers. */
export function valueRange({ scale, levels = [], values }: Pick<Picture, 'scale' | 'levels' | 'values'>, min: number | null, max: number | null,
  usual?: number): uPlot.Range.MinMax {
  if (scale === 'unit') return [0, 1];
  const all = [min, max, ...(values ?? [])].filter((value): value is number => typeof value === 'number' && Number.isFinite(value));
  const most = Math.max(...all, 0);
  if (scale === 'log') {
    const least = Math.min(...all.filter((value) => value > 0), most || 1);
    return [rounded(least, false), rounded(Math.max(most || 10, least * 1.01), true)];
  }
  const shown = levels.filter(({ isAside }) => !isAside).map(({ value }) => value);
  const reach = usual && !values && most > OUTLIER * usual ? OUTLIER_END * usual : most;
  const least = scale === 'signed' ? Math.min(0, ...all) * 1.08 : 0;
  return [least, Math.max(reach * 1.08, Math.max(0, ...shown) * 1.15) || (least < 0 ? 0 : 1)];
}

interface Stroke { colour: string; width: number; dash: number[] } // in CSS pixels

function drawLine({ ctx }: uPlot, [x1, y1, x2, y2]: readonly [number, number, number, number], { colour, width, dash }: Stroke): void {
  ctx.strokeStyle = resolved(colour);
  ctx.lineWidth = width * uPlot.pxRatio;
  ctx.setLineDash(dash.map((length) => length * uPlot.pxRatio));
  ctx.stroke(new Path2D(`M${x1} ${y1}L${x2} ${y2}`));
}

function drawLevels(plot: uPlot, { levels = [] }: Picture): void {
  const { ctx, bbox } = plot;
  let wordsY = Infinity;
  for (const { value, label } of levels) {
    const y = plot.valToPos(value, 'y', true);
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    drawLine(plot, [bbox.left, y, bbox.left + bbox.width, y], { colour: 'var(--bad)', width: 1, dash: [6, 4] });
    if (Math.abs(wordsY - y) >= 12 * uPlot.pxRatio) { // closer labels would overlap
      ctx.fillStyle = resolved('var(--bad)');
      ctx.textBaseline = 'middle';
      ctx.fillText(label, bbox.left + bbox.width + 4 * uPlot.pxRatio, y);
      wordsY = y;
    }
  }
}

// Draws a label beside its line: on the right if it fits, else on the left. Skips the label if it would overlap the previous label. Returns
// the x position at which the next label may begin.
function drawName({ ctx, bbox }: uPlot, name: string, x: number, freeFrom: number): number {
  const gap = 3 * uPlot.pxRatio;
  const width = ctx.measureText(name).width;
  const left = x + gap + width > bbox.left + bbox.width ? x - gap - width : x + gap;
  if (left < freeFrom) return freeFrom;
  ctx.fillStyle = resolved('var(--soft)');
  ctx.fillText(name, left, bbox.top + 11 * uPlot.pxRatio);
  return left + width + gap;
}

function drawMoments(plot: uPlot, { moments = [], domain, scale }: Picture): void {
  const { ctx, bbox } = plot;
  ctx.textBaseline = 'alphabetic';
  const shown = moments.filter(({ timeMs }) => timeMs >= domain.fromMs && timeMs <= domain.toMs);
  const isShort = scale === 'unit' || shown.length * DENSE * uPlot.pxRatio > bbox.width;
  let last = -Infinity;
  let wordsEnd = -Infinity;
  for (const { timeMs, colour, label } of shown) {
    const x = plot.valToPos(timeMs, 'x', true);
    if (!label && x - last < MOMENT * uPlot.pxRatio) continue;
    last = x;
    const line = [x, bbox.top, x, bbox.top + (isShort && !label ? TICK * uPlot.pxRatio : bbox.height)] as const;
    drawLine(plot, line, { colour: 'var(--card)', width: 3, dash: [] }); // an outline, so that the line is visible on an area of the same colour
    drawLine(plot, line, { colour, width: 1, dash: [2, 2] });
    if (label) wordsEnd = drawName(plot, label, x, wordsEnd);
  }
}

// Marks values above the axis with triangles at its end, in the colour of their line.
function drawOutliers(plot: uPlot, { timesMs, lines, hidden, scale }: Picture): void {
  if (scale !== 'zero') return;
  const { ctx, bbox } = plot;
  const [size, end] = [4 * uPlot.pxRatio, plot.scales.y?.max ?? Infinity];
  for (const { values, colour, arm, width } of lines) {
    if (width === 0 || hidden.has(arm ?? '')) continue;
    ctx.fillStyle = resolved(colour);
    let last = -Infinity;
    values.forEach((value, i) => {
      if (value === null || value <= end) return;
      const x = plot.valToPos(timesMs[i]!, 'x', true);
      if (x < bbox.left || x > bbox.left + bbox.width || x - last < 2 * size) return;
      last = x;
      ctx.fill(new Path2D(`M${x} ${bbox.top}l${size} ${1.5 * size}h${-2 * size}z`));
    });
  }
}

// Draws what uPlot does not draw, over its lines.
function drawMore(plot: uPlot, picture: Picture): void {
  plot.ctx.save();
  plot.ctx.font = fontOf(11 * uPlot.pxRatio);
  plot.ctx.textAlign = 'left';
  for (const draw of [drawMoments, drawLevels, drawOutliers]) draw(plot, picture);
  plot.ctx.restore();
  picture.paint?.(plot);
}

function seriesOf({ lines, hidden }: Picture): uPlot.Series[] {
  return [{}, ...lines.map(({ label, colour, dash, width = 2, stepped = false, isAside = false, arm }): uPlot.Series => ({
    label,
    show: !(arm && hidden.has(arm)),
    width,
    stroke: () => (width > 0 ? resolved(colour) : 'rgba(0, 0, 0, 0)'),
    ...(dash?.length && { dash: [...dash] }),
    ...(stepped && { paths: uPlot.paths.stepped!({ align: 1 }) }),
    auto: !isAside,
    points: { show: false },
    spanGaps: false,
  }))];
}

function axis(now: () => Picture, isTime: boolean): uPlot.Axis {
  return {
    stroke: () => resolved('var(--soft)'),
    font: fontOf(12),
    grid: { stroke: () => resolved('var(--rule)'), width: 1 },
    ticks: { show: false },
    ...(isTime
      ? { size: 30, space: 70, incrs: TIME_STEPS, values: (_: uPlot, splits: number[], __: number, ___: number, step: number) => splits.map((ms) => axisTime(ms, step)) }
      : { size: LEFT, values: (_: uPlot, splits: number[]) => splits.map((value: number | null) => (value === null ? null : (now().scale === 'unit' ? compact : now().format)(value))) }),
  };
}

// Labels a logarithmic axis at 1, 2 and 5 times powers of ten, or at powers of ten only if the axis is too short.
function roundOnly(plot: uPlot, splits: number[]): (number | null)[] {
  const decades = Math.log10((plot.scales.y?.max ?? 10) / (plot.scales.y?.min ?? 1));
  const isShown = decades * 60 > plot.height ? /^1e/ : /^[125]e/;
  return splits.map((value) => (isShown.test(value.toExponential(0)) && Math.abs(Number(value.toPrecision(1)) / value - 1) < 1e-9 ? value : null));
}

export const dataOf = ({ timesMs, lines }: Picture) => [timesMs, ...lines.map(({ values }) => values)] as unknown as uPlot.AlignedData;

function options(now: () => Picture, width: number, height: number): uPlot.Options {
  const { scale, bands = [], hidden, lines, lanes } = now();
  const valueAxis = axis(now, false);
  if (scale === 'log') valueAxis.filter = roundOnly;
  if (lanes) Object.assign(valueAxis, { gap: 12, stroke: () => resolved('var(--text)'), splits: () => lanes.map((_, i) => i + 0.5), values: () => lanes });
  const isShown = (place: number) => !hidden.has(lines[place]?.arm ?? '');
  return {
    width,
    height,
    ms: 1,
    padding: [8, RIGHT, 0, 0],
    legend: { show: false },
    series: seriesOf(now()),
    bands: bands.filter(({ upper, lower }) => isShown(upper) && isShown(lower)).map(({ upper, lower, fill }) =>
      ({ series: [upper + 1, lower + 1], fill: (plot: uPlot) => fill(plot.ctx) })),
    scales: {
      x: { time: true, range: () => [now().domain.fromMs, now().domain.toMs] },
      y: lanes ? { dir: -1, range: [0, Math.max(lanes.length, 1)] } : { ...(scale === 'log' && { distr: 3 }), range: (_, min, max) => valueRange(now(), min, max, scale === 'zero' ? usualOf(now()) : undefined) },
    },
    axes: [axis(now, true), valueAxis],
    cursor: {
      y: false,
      points: { show: false },
      drag: { x: true, y: false, setScale: false, dist: 6 },
      bind: { dblclick: () => () => { setRange(undefined); return null; } },
    },
    hooks: {
      draw: [(plot) => drawMore(plot, now())],
      setCursor: [(plot) => {
        const { left = -1 } = plot.cursor;
        if (plot.over.matches(':hover')) crosshairMs.value = left < 0 ? undefined : plot.posToVal(left, 'x');
      }],
      setSelect: [(plot) => {
        const { left, width: wide } = plot.select;
        if (wide > 0) setRange({ fromMs: plot.posToVal(left, 'x'), toMs: plot.posToVal(left + wide, 'x') });
        plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      }],
    },
  };
}

/** Draws into `host`. Calls `now` at each redraw for the current data. If the set of lines changes, create a new plot. */
export const createPlot = (host: HTMLElement, now: () => Picture, width: number, height: number) =>
  new uPlot(options(now, width, height), dataOf(now()), host);

/** Shows the crosshair at the time at which the pointer is in another chart. */
export function showCrosshair(plot: uPlot, timeMs: number | undefined): void {
  const left = timeMs === undefined ? -10 : plot.valToPos(timeMs, 'x');
  plot.setCursor({ left, top: left < 0 ? -10 : 0 }, false);
}

export const fillOf = (colour: string, opacity: number) => () => translucent(colour, opacity);
