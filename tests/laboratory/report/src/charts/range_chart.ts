// A chart with one row per name: a bar from the low to the high value, a mark between them, and the value as text at the right edge.
import * as Plot from '@observablehq/plot';
import { significant } from '../../../../../server/dashboard/src/format';
import { axisNote, chartWidth, figure, isNarrow, widest } from './figure';
import { axes, linearTicks, logDomain, logTicks, SYMLOG_LINEAR, symlogDomain, symlogTicks } from './scales';

export interface RangeRow {
  name: string; colour: string; symbol?: Plot.SymbolType; solid: boolean;
  low: number; value: number; high: number; label: string; text: string;
}
export type RangeScale = 'log' | 'linear' | 'symlog';
export interface RangeChart { id: string; title: string; note?: string | undefined; xLabel: string; scale?: RangeScale; rows: RangeRow[] }

const ROW = 25;
const NAME_ABOVE = 17; // pixels that a name above its bar takes, where it has no room beside it

// Returns the range and the ticks of the axis. Only a symmetric logarithmic axis has negative values.
export function axisOf(scale: RangeScale, values: number[]): { domain: [number, number]; ticks: number[] } {
  if (scale === 'symlog') {
    const domain = symlogDomain(values);
    return { domain, ticks: symlogTicks(domain) };
  }
  const domain: [number, number] = scale === 'linear' ? [0, Math.max(...values.filter(Number.isFinite), 1e-9)] : logDomain(values, 1.1);
  return { domain, ticks: scale === 'linear' ? linearTicks(domain) : logTicks(domain) };
}

// REQUIRES: values above 0 on a logarithmic axis, and from 0 on a linear one.
function picture({ xLabel, scale = 'log', rows }: RangeChart): SVGElement | HTMLElement {
  const { domain, ticks } = axisOf(scale, rows.flatMap(({ low, high }) => [low, high]));
  const narrow = isNarrow();
  const above = narrow ? { dy: -NAME_ABOVE + 3 } : {};
  return Plot.plot({
    width: chartWidth(), height: (ROW + (narrow ? NAME_ABOVE : 0)) * rows.length + 70,
    marginLeft: narrow ? 14 : widest(rows.map(({ name }) => name)), marginRight: narrow ? 14 : widest(rows.map(({ label }) => label)),
    marginTop: narrow ? 24 : 12, marginBottom: 46, className: 'picture',
    x: { type: scale, domain, axis: null, ...(scale === 'symlog' && { constant: SYMLOG_LINEAR }) },
    y: { type: 'point', domain: rows.map(({ name }) => name), axis: null, padding: 0.6 },
    marks: [
      ...axes('x', ticks, (tick) => (scale === 'log' ? significant(tick, 1) : String(tick).replace('-', '−')), narrow ? '' : xLabel),
      Plot.ruleY(rows, { y: 'name', stroke: 'var(--faint)' }),
      scale === 'symlog' ? Plot.ruleX([0], { stroke: 'var(--soft)' }) : null,
      Plot.ruleY(rows, { y: 'name', x1: 'low', x2: 'high', stroke: 'colour', strokeWidth: 6, strokeLinecap: 'round', strokeOpacity: 0.42 }),
      Plot.dot(rows, { x: 'value', y: 'name', r: 5, symbol: (row: RangeRow) => row.symbol ?? 'circle', stroke: 'colour', strokeWidth: 1.8,
        fill: ({ solid, colour }: RangeRow) => (solid ? colour : 'var(--card)'), title: ({ name, text }: RangeRow) => `${name}\n${text}` }),
      ...[true, false].map((strong) => Plot.text(rows.filter(({ solid }) => solid === strong), { y: 'name', text: 'name', frameAnchor: 'left',
        textAnchor: narrow ? 'start' : 'end', dx: narrow ? -10 : -8, ...above, fill: 'currentColor', fontWeight: strong ? 650 : 400 })),
      Plot.text(rows, { y: 'name', text: 'label', frameAnchor: 'right', textAnchor: narrow ? 'end' : 'start', dx: narrow ? 10 : 8, ...above, fill: 'currentColor' }),
    ],
    color: { type: 'identity' },
    symbol: { type: 'identity' },
  } as Plot.PlotOptions);
}

export function rangeChart(chart: RangeChart): HTMLElement {
  return figure(chart, picture(chart), axisNote(chart.xLabel));
}

export const byValue = (rows: RangeRow[]) => [...rows].sort((a, b) => a.value - b.value);
