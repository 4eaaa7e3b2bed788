// A line chart with two logarithmic axes. Each line has its name at its right end, or in a legend if the page is narrow.
import * as Plot from '@observablehq/plot';
import { compact, significant } from '../../../../../server/dashboard/src/format';
import { axisNote, chartWidth, chips, figure, isNarrow } from './figure';
import { axes, logDomain, logTicks, spreadOut } from './scales';

export interface Point { x: number; y: number; text: string }
export interface Series {
  name: string; colour: string; symbol: Plot.SymbolType; solid: boolean; points: Point[];
}
export interface LineChart { id: string; title: string; note?: string | undefined; xLabel: string; yLabel: string; series: Series[] }

const MARGIN = { top: 16, bottom: 48, left: 64 };
const NAME_HEIGHT = 15;

// Draws the names at the right edge, as near to the ends of their lines as possible without overlap. A dotted line leads to each name.
function endNames(series: Series[], height: number, edge: number, [low, high]: [number, number]): Plot.Markish[] {
  const bottom = height - MARGIN.bottom;
  const pixels = (y: number) => bottom - (Math.log(y / low) / Math.log(high / low)) * (bottom - MARGIN.top);
  const value = (pixel: number) => low * (high / low) ** ((bottom - pixel) / (bottom - MARGIN.top));
  const last = series.map(({ points }) => points.at(-1)!);
  const placed = spreadOut(last.map(({ y }) => pixels(y)), NAME_HEIGHT, MARGIN.top, bottom).map(value);
  return series.flatMap((each, index) => [
    Plot.link([last[index]!], { x1: 'x', y1: 'y', x2: () => edge, y2: () => placed[index]!, stroke: each.colour, strokeDasharray: '1 4',
      className: 'leader' }),
    Plot.text([each.name], { x: () => edge, y: () => placed[index]!, text: (name: string) => name, dx: 6, textAnchor: 'start',
      fill: `color-mix(in srgb, ${each.colour} 75%, var(--text))`, fontWeight: each.solid ? 650 : 400 })]);
}

function lineMarks(series: Series): Plot.Markish[] {
  const { name, colour, symbol, solid, points } = series;
  return [
    Plot.line(points, { x: 'x', y: 'y', stroke: colour, strokeWidth: solid ? 2.3 : 1.5, ...(!solid && { strokeDasharray: '6 4' }) }),
    Plot.dot(points, {
      x: 'x', y: 'y', symbol, r: 4.5, stroke: colour, strokeWidth: 1.6, fill: solid ? colour : 'var(--card)',
      title: ({ text }: Point) => `${name}\n${text}`,
    })];
}

function picture({ xLabel, yLabel, series }: LineChart): SVGElement | HTMLElement {
  const points = series.flatMap((each) => each.points);
  const x = logDomain(points.map((point) => point.x), 1.08);
  const y = logDomain(points.map((point) => point.y), 1.4);
  const height = Math.max(470, MARGIN.top + MARGIN.bottom + 18 * series.length);
  const narrow = isNarrow();
  return Plot.plot({
    width: chartWidth(), height, marginTop: MARGIN.top, marginRight: narrow ? 24 : 190, marginBottom: MARGIN.bottom, marginLeft: MARGIN.left,
    className: 'picture',
    x: { type: 'log', domain: x, axis: null },
    y: { type: 'log', domain: y, axis: null },
    marks: [...axes('x', [...new Set(points.map((point) => point.x))], compact, narrow ? '' : xLabel),
      ...axes('y', logTicks(y), (tick) => significant(tick, 1), yLabel), ...series.flatMap(lineMarks), ...(narrow ? [] : endNames(series, height, x[1], y))],
  });
}

export const lineChart = (chart: LineChart): HTMLElement => figure(chart, picture(chart), axisNote(chart.xLabel), isNarrow() && chips(chart.series));
