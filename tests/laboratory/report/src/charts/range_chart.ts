// A chart with one row per name: a bar from the low to the high value, a mark between them, and the value as text at the right edge.
import * as Plot from '@observablehq/plot';
import { significant } from '../../../../../server/dashboard/src/format';
import { figure, widest } from './figure';
import { axes, linearTicks, logDomain, logTicks } from './scales';

export interface RangeRow {
  name: string; colour: string; symbol?: Plot.SymbolType; solid: boolean;
  low: number; value: number; high: number; label: string; text: string;
}
export interface RangeChart { id: string; title: string; note?: string | undefined; xLabel: string; linear?: boolean; rows: RangeRow[] }

const WIDTH = 1080;
const ROW = 25;

// REQUIRES: positive values, unless the axis is linear.
function picture({ xLabel, linear, rows }: RangeChart): SVGElement | HTMLElement {
  const values = rows.flatMap(({ low, high }) => [low, high]);
  const domain: [number, number] = linear ? [0, Math.max(...values.filter(Number.isFinite), 1e-9)] : logDomain(values, 1.1);
  return Plot.plot({
    width: WIDTH, height: ROW * rows.length + 70, marginLeft: widest(rows.map(({ name }) => name)),
    marginRight: widest(rows.map(({ label }) => label)), marginTop: 12, marginBottom: 46, className: 'picture',
    x: { type: linear ? 'linear' : 'log', domain, axis: null },
    y: { type: 'point', domain: rows.map(({ name }) => name), axis: null, padding: 0.6 },
    marks: [
      ...axes('x', linear ? linearTicks(domain) : logTicks(domain), (tick) => (linear ? String(tick) : significant(tick, 1)), xLabel),
      Plot.ruleY(rows, { y: 'name', stroke: 'var(--faint)' }),
      Plot.ruleY(rows, { y: 'name', x1: 'low', x2: 'high', stroke: 'colour', strokeWidth: 6, strokeLinecap: 'round', strokeOpacity: 0.42 }),
      Plot.dot(rows, { x: 'value', y: 'name', r: 5, symbol: (row: RangeRow) => row.symbol ?? 'circle', stroke: 'colour', strokeWidth: 1.8,
        fill: ({ solid, colour }: RangeRow) => (solid ? colour : 'var(--card)'), title: ({ name, text }: RangeRow) => `${name}\n${text}` }),
      ...[true, false].map((strong) => Plot.text(rows.filter(({ solid }) => solid === strong), { y: 'name', text: 'name', frameAnchor: 'left',
        textAnchor: 'end', dx: -8, fill: 'currentColor', fontWeight: strong ? 650 : 400 })),
      Plot.text(rows, { y: 'name', text: 'label', frameAnchor: 'right', textAnchor: 'start', dx: 8, fill: 'currentColor' }),
    ],
    color: { type: 'identity' },
    symbol: { type: 'identity' },
  } as Plot.PlotOptions);
}

export function rangeChart(chart: RangeChart): HTMLElement {
  return figure(chart, picture(chart));
}

export const byValue = (rows: RangeRow[]) => [...rows].sort((a, b) => a.value - b.value);
