// Reliability diagram: the observed frequency against the predicted probability, with a line per policy and the diagonal of perfect
// calibration.
import * as Plot from '@observablehq/plot';
import { axisNote, chartWidth, chips, figure, isNarrow, widest } from './figure';
import { axes } from './scales';

export interface ReliabilityPoint { predicted: number; observed: number; weight: number; text: string }
export interface ReliabilityLine { name: string; colour: string; points: ReliabilityPoint[] }
export interface ReliabilityChart { id: string; title: string; note?: string | undefined; xLabel: string; yLabel: string; lines: ReliabilityLine[] }

const TICKS = [0, 0.2, 0.4, 0.6, 0.8, 1];
const percentOf = (tick: number) => `${Math.round(100 * tick)} %`;

// REQUIRES: each line has points, in ascending order. The area of a mark grows with its weight.
function picture({ xLabel, yLabel, lines }: ReliabilityChart): SVGElement | HTMLElement {
  const most = Math.max(...lines.flatMap(({ points }) => points.map(({ weight }) => weight)));
  const radius = ({ weight }: ReliabilityPoint) => 3 + 9 * Math.sqrt(weight / most);
  const narrow = isNarrow();
  return Plot.plot({
    width: chartWidth(), height: narrow ? 340 : 560, marginTop: 16, marginRight: narrow ? 24 : widest(lines.map(({ name }) => name)), marginBottom: 48, marginLeft: 64, className: 'picture',
    x: { domain: [0, 1], axis: null }, y: { domain: [0, 1], axis: null },
    marks: [...axes('x', TICKS, percentOf, narrow ? '' : xLabel), ...axes('y', TICKS, percentOf, yLabel),
      Plot.line([[0, 0], [1, 1]], { stroke: 'currentColor', strokeDasharray: '4 4', strokeOpacity: 0.6 }),
      ...lines.flatMap(({ name, colour, points }) => [
        Plot.line(points, { x: 'predicted', y: 'observed', stroke: colour, strokeWidth: 2 }),
        Plot.dot(points, { x: 'predicted', y: 'observed', r: radius, fill: colour, fillOpacity: 0.75, stroke: 'var(--card)',
          title: ({ text }: ReliabilityPoint) => `${name}\n${text}` }),
        ...(narrow ? [] : [Plot.text(points.slice(-1), { x: 1, y: 'observed', text: () => name, dx: 16, textAnchor: 'start', fill: colour, fontWeight: 650 })])])],
    r: { type: 'identity' },
  });
}

export const reliabilityChart = (chart: ReliabilityChart): HTMLElement => figure(chart, picture(chart), axisNote(chart.xLabel), isNarrow() && chips(chart.lines));
