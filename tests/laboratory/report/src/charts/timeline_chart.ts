// A chart with one row per run: a bar shows which algorithm was active when. Strokes below the bar and crosses on it mark moments.
import * as Plot from '@observablehq/plot';
import { textColourOn } from '../palette';
import { axisNote, chartWidth, figure, isNarrow, LETTER, widest } from './figure';

export interface Stretch { from: number; to: number; name: string; colour: string; faint: boolean; text: string }
export interface Lane { name: string; stretches: Stretch[]; strokes: number[]; crosses: { at: number; text: string }[] }
export interface TimelineChart { id: string; title: string; note?: string | undefined; xLabel: string; lanes: Lane[] }

const LANE = 30;
const STROKES = 7; // pixels of a lane's height that the strokes below the bar take

export function timelineChart(chart: TimelineChart): HTMLElement {
  const inLane = <T extends object>(values: (lane: Lane) => T[]) =>
    chart.lanes.flatMap((lane) => values(lane).map((value) => ({ lane: lane.name, ...value })));
  const end = Math.max(0.1, ...chart.lanes.flatMap(({ stretches }) => stretches.map(({ to }) => to)));
  const left = widest(chart.lanes.map(({ name }) => name));
  const width = chartWidth();
  const fits = ({ from, to, name }: Stretch) => ((to - from) / end) * (width - left - 20) > LETTER * name.length + 4;
  const middle = ({ from, to }: Stretch) => (from + to) / 2;
  const picture = Plot.plot({
    width, height: LANE * chart.lanes.length + 60, marginTop: 8, marginBottom: 44,
    marginLeft: left, className: 'picture',
    x: { domain: [0, end] },
    y: { domain: chart.lanes.map(({ name }) => name), label: null, padding: 0.12, tickSize: 0 },
    color: { type: 'identity' },
    marks: [
      Plot.barX(inLane(({ stretches }) => stretches), { x1: 'from', x2: 'to', y: 'lane', fill: 'colour', insetBottom: STROKES,
        fillOpacity: ({ faint }: Stretch) => (faint ? 0.45 : 1), title: 'text', stroke: 'var(--card)', strokeWidth: 0.8 }),
      Plot.text(inLane(({ stretches }) => stretches.filter(fits)), { x: middle, y: 'lane', dy: -STROKES / 2, text: 'name', className: 'on-area',
        fill: ({ faint, colour }: Stretch) => (faint ? 'var(--text)' : textColourOn(colour)) }),
      Plot.tickX(inLane(({ strokes }) => strokes.map((at) => ({ at }))), { x: 'at', y: 'lane', insetTop: LANE - 4 - STROKES, stroke: 'var(--soft)', strokeWidth: 0.8 }),
      Plot.dot(inLane(({ crosses }) => crosses), { x: 'at', y: 'lane', dy: -STROKES / 2, symbol: 'times', r: 5, stroke: 'currentColor', strokeWidth: 2.4, title: 'text' }),
      Plot.axisX({ ticks: isNarrow() ? 4 : 8, label: isNarrow() ? null : chart.xLabel, labelAnchor: 'center', labelArrow: false }),
    ],
  } as Plot.PlotOptions);
  return figure(chart, picture, axisNote(chart.xLabel));
}
