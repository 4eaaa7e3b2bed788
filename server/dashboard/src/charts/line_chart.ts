// Lines on two logarithmic axes, each named at its end; the legend hides and shows them.
import * as Plot from '@observablehq/plot';
import { h } from '../dom';
import { compact, significant } from '../format';
import { figure, show } from './figure';
import { axes, logDomain, logTicks, spreadOut } from './scales';

export interface Point { x: number; y: number; text: string }
export interface Series {
  name: string; group: string; colour: string; symbol: Plot.SymbolType; solid: boolean; points: Point[];
}
export interface LineChart { id: string; title: string; note?: string | undefined; xLabel: string; yLabel: string; series: Series[] }

const WIDTH = 1080;
const MARGIN = { top: 16, right: 190, bottom: 48, left: 64 };
const NAME_HEIGHT = 15;

// The name of a line beside its last point; names that would touch move apart.
function endNames(series: Series[], height: number, domain: [number, number]): Plot.Markish[] {
  const bottom = height - MARGIN.bottom;
  const pixels = (y: number) => bottom - (Math.log(y / domain[0]) / Math.log(domain[1] / domain[0])) * (bottom - MARGIN.top);
  const last = series.map(({ points }) => points.at(-1)!);
  const placed = spreadOut(last.map(({ y }) => pixels(y)), NAME_HEIGHT, MARGIN.top, bottom);
  return series.map(({ name, colour, solid }, index) => Plot.text([last[index]!], {
    x: 'x', y: 'y', text: () => name, dx: 12, dy: placed[index]! - pixels(last[index]!.y), textAnchor: 'start',
    fill: colour, fontWeight: solid ? 650 : 400, className: `series-${series[index]!.name.replace(/\W+/g, '_')} name`,
  }));
}

function lineMarks({ name, colour, symbol, solid, points }: Series): Plot.Markish[] {
  const className = `series-${name.replace(/\W+/g, '_')}`;
  return [
    Plot.line(points, { x: 'x', y: 'y', stroke: colour, strokeWidth: solid ? 2.3 : 1.5, className, ...(!solid && { strokeDasharray: '6 4' }) }),
    Plot.dot(points, {
      x: 'x', y: 'y', symbol, r: 4.5, stroke: colour, strokeWidth: 1.6, fill: solid ? colour : 'var(--card)', className,
      title: ({ text }: Point) => `${name}\n${text}`,
    })];
}

function picture({ xLabel, yLabel, series }: LineChart): SVGElement | HTMLElement {
  const points = series.flatMap((each) => each.points);
  const y = logDomain(points.map((point) => point.y), 1.4);
  const height = Math.max(470, MARGIN.top + MARGIN.bottom + 18 * series.length);
  return Plot.plot({
    width: WIDTH, height, marginTop: MARGIN.top, marginRight: MARGIN.right, marginBottom: MARGIN.bottom, marginLeft: MARGIN.left,
    className: 'picture',
    x: { type: 'log', domain: logDomain(points.map((point) => point.x), 1.08), axis: null },
    y: { type: 'log', domain: y, axis: null },
    marks: [...axes('x', [...new Set(points.map((point) => point.x))], compact, xLabel),
      ...axes('y', logTicks(y), (tick) => significant(tick, 1), yLabel), ...series.flatMap(lineMarks), ...endNames(series, height, y)],
  });
}

function legendEntry({ name, colour, solid }: Series, onChange: (shown: boolean) => void): HTMLElement {
  const box = h('input', { type: 'checkbox' });
  box.checked = true;
  box.addEventListener('change', () => onChange(box.checked));
  return h('label', {}, box, h('span', { class: solid ? 'swatch' : 'swatch dashed', style: `--a: ${colour}` }), h('span', {}, name));
}

export function lineChart(chart: LineChart): HTMLElement {
  const hidden = new Set<Series>();
  const groups = [...new Set(chart.series.map(({ group }) => group))].map((group) =>
    h('div', {}, h('span', { class: 'group' }, group), h('div', {},
      ...chart.series.filter((series) => series.group === group).map((series) => legendEntry(series, (shown) => {
        if (shown) hidden.delete(series);
        else hidden.add(series);
        const series_ = chart.series.filter((each) => !hidden.has(each));
        const plot = element.querySelector<HTMLElement>('.plot')!;
        if (series_.length > 0) show(plot, chart.title, picture({ ...chart, series: series_ }));
      })))));
  const element = figure(chart, picture(chart), h('fieldset', { class: 'legend' }, h('legend', {}, 'Show or hide'), ...groups));
  return element;
}
