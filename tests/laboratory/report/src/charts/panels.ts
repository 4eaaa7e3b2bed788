// Small line charts with common axes, one per panel. A line marked as `strong` is thick and has its name beside it.
import * as Plot from '@observablehq/plot';
import { h } from '../dom';
import { figure } from './figure';

export interface PanelPoint { x: number; y: number; text: string }
export interface PanelLine { name: string; colour: string; strong: boolean; points: PanelPoint[] }
export interface Panel { title: string; note: string; lines: PanelLine[] }
export interface Panels { id: string; title: string; note?: string | undefined; panels: Panel[] }

// Returns an axis range with a margin below and above the values, even if all values are equal.
function domainOf(values: number[]): [number, number] {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = Math.max((high - low) / 20, 0.01);
  return [low - room, high + room];
}

function draw(panel: Panel, x: [number, number], y: [number, number]): HTMLElement {
  const points = panel.lines.flatMap((line) => line.points);
  const strong = panel.lines.filter((line) => line.strong && line.points.length > 0);
  const picture = Plot.plot({
    width: 260, height: 150, marginLeft: 34, marginRight: 8, marginTop: 8, marginBottom: 24, className: 'picture',
    x: { domain: x, ticks: 4, label: null }, y: { domain: y, ticks: 4, label: null, grid: true },
    marks: [
      ...panel.lines.map((line) => Plot.line(line.points, { x: 'x', y: 'y', stroke: line.colour, strokeWidth: line.strong ? 2.8 : 1.3, clip: true })),
      ...strong.map((line) => Plot.text([line.points.at(-1)!], { x: 'x', y: 'y', text: () => line.name, textAnchor: 'end', dy: -9,
        fill: line.colour, stroke: 'var(--card)', strokeWidth: 3, fontWeight: 650 })),
      Plot.tip(points, Plot.pointer({ x: 'x', y: 'y', title: 'text', anchor: 'bottom', fill: 'var(--text)', stroke: 'none', className: 'plot-tip' })),
    ],
  });
  picture.setAttribute('aria-label', `${panel.title}, ${panel.note}`);
  return h('div', { class: 'panel' }, h('p', {}, h('b', {}, panel.title), ' ', h('span', { class: 'soft' }, panel.note)), picture);
}

export function panels(chart: Panels): HTMLElement {
  const points = chart.panels.flatMap(({ lines }) => lines.flatMap((line) => line.points));
  if (points.length === 0) return figure(chart, h('p', { class: 'soft' }, 'These runs have no decisions.'));
  const x = domainOf(points.map((point) => point.x));
  const y = domainOf(points.map((point) => point.y));
  return figure(chart, h('div', { class: 'panels' }, ...chart.panels.map((panel) => draw(panel, [0, x[1]], y))));
}
