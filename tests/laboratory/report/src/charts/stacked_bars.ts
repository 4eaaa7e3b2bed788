// A chart with one bar per row, divided into the shares of the row's values.
import * as Plot from '@observablehq/plot';
import { share } from '../../../../../server/dashboard/src/format';
import { textColourOn } from '../palette';
import { chips, figure, LETTER, widest } from './figure';

export interface Kind { name: string; colour: string }
export interface StackedBars { id: string; title: string; note?: string | undefined; kinds: Kind[]; rows: { name: string; values: number[] }[] }

interface Segment { row: string; from: number; to: number; colour: string; name: string; label: string }

const WIDTH = 1080;

export function segmentsOf({ kinds, rows }: Pick<StackedBars, 'kinds' | 'rows'>): Segment[] {
  return rows.flatMap(({ name: row, values }) => {
    const sum = values.reduce((a, b) => a + b, 0);
    let from = 0;
    return values.map((value, index) => {
      const { name, colour } = kinds[index]!;
      const part = sum > 0 ? value / sum : 0;
      const segment = { row, from, to: from + part, colour, name, label: share(part) };
      from += part;
      return segment;
    }).filter(({ from, to }) => to > from);
  });
}

function picture(chart: StackedBars): SVGElement | HTMLElement {
  const segments = segmentsOf(chart);
  const left = widest(chart.rows.map(({ name }) => name));
  const fitting = ({ from, to, name, label }: Segment) => // returns the longest text that fits in the segment
    [`${name} ${label}`, name].find((each) => (to - from) * (WIDTH - left - 28) > LETTER * each.length) ?? '';
  const bar = { x1: 'from', x2: 'to', y: 'row', fill: 'colour' };
  return Plot.plot({
    width: WIDTH, height: 26 * chart.rows.length + 60, marginLeft: left, marginRight: 28, marginTop: 8, marginBottom: 44, className: 'picture',
    x: { domain: [0, 1], percent: false, ticks: 10, tickFormat: (tick: number) => `${Math.round(100 * tick)} %`, label: null },
    y: { domain: chart.rows.map(({ name }) => name), label: null, padding: 0.18, tickSize: 0 },
    color: { type: 'identity' },
    marks: [
      Plot.barX(segments, { ...bar, stroke: 'var(--card)', strokeWidth: 0.6, title: ({ row, name, label }: Segment) => `${row}\n${name} ${label}` }),
      Plot.text(segments, { x: ({ from, to }: Segment) => (from + to) / 2, y: 'row', text: fitting, fill: ({ colour }: Segment) => textColourOn(colour), className: 'on-area' }),
    ],
  } as Plot.PlotOptions);
}

export function stackedBars(chart: StackedBars): HTMLElement {
  return figure(chart, picture(chart), chips(chart.kinds));
}
