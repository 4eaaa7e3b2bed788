// A chart with one bar per row, divided into the shares of the row's values.
import * as Plot from '@observablehq/plot';
import { share } from '../../../../../server/dashboard/src/format';
import { textColourOn } from '../palette';
import { chartWidth, chips, figure, isNarrow, LETTER, widest } from './figure';

export interface Kind { name: string; colour: string }
export interface StackedBars { id: string; title: string; note?: string | undefined; kinds: Kind[]; rows: { name: string; values: number[] }[] }

interface Segment { row: string; from: number; to: number; colour: string; name: string; label: string }

const NAME_ABOVE = 16; // pixels that a row's name above its bar takes if the page is narrow

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
  const [width, narrow] = [chartWidth(), isNarrow()];
  const names = chart.rows.map(({ name }) => name);
  const left = narrow ? 14 : widest(names);
  const insetTop = narrow ? NAME_ABOVE : 0;
  const fitting = ({ from, to, name, label }: Segment) => // returns the longest text that fits in the segment
    [`${name} ${label}`, name].find((each) => (to - from) * (width - left - 28) > LETTER * each.length) ?? '';
  const bar = { x1: 'from', x2: 'to', y: 'row', fill: 'colour', insetTop };
  return Plot.plot({
    width, height: (26 + insetTop) * names.length + 60, marginLeft: left, marginRight: 28, marginTop: 8, marginBottom: 44, className: 'picture',
    x: { domain: [0, 1], percent: false, ticks: narrow ? 5 : 10, tickFormat: (tick: number) => `${Math.round(100 * tick)} %`, label: null },
    y: { domain: names, label: null, padding: 0.18, tickSize: 0, ...(narrow && { axis: null }) },
    color: { type: 'identity' },
    marks: [
      Plot.barX(segments, { ...bar, stroke: 'var(--card)', strokeWidth: 0.6, title: ({ row, name, label }: Segment) => `${row}\n${name} ${label}` }),
      Plot.text(segments, { x: ({ from, to }: Segment) => (from + to) / 2, y: 'row', dy: insetTop / 2, text: fitting, fill: ({ colour }: Segment) => textColourOn(colour), className: 'on-area' }),
      narrow ? Plot.text(names, { y: (name: string) => name, text: (name: string) => name, frameAnchor: 'left', textAnchor: 'start', dy: -NAME_ABOVE / 2 - 3, fill: 'currentColor' }) : null,
    ],
  } as Plot.PlotOptions);
}

export function stackedBars(chart: StackedBars): HTMLElement {
  return figure(chart, picture(chart), chips(chart.kinds));
}
