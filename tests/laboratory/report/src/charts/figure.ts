// Parts that all charts share: the figure element around a picture, and its legend. The browser shows a mark's title as
// a tooltip.
import { h, type Child } from '../dom';
import { textColourOn } from '../palette';

export const LETTER = 7.6; // mean width of a bold letter at 13 px, rounded up
export const widest = (texts: string[]) => LETTER * Math.max(0, ...texts.map((text) => text.length)) + 20;

const WIDEST = 1080;
const NARROW = 640; // below this width, names stand above their bars or in a legend
export const isNarrow = () => document.documentElement.clientWidth < NARROW;

// Calls `redraw` when the page becomes narrow or wide, because the pictures have another layout then.
export const onNarrowChange = (redraw: () => void) => matchMedia(`(max-width: ${NARROW - 1}px)`).addEventListener('change', redraw);

// Returns the width of a picture in CSS pixels, so that it is not scaled and its letters keep their size. The margins are those of report.css.
export const chartWidth = () => Math.max(280, Math.min(WIDEST, document.documentElement.clientWidth - (isNarrow() ? 50 : 98)));

// A narrow picture has no room for the label of its horizontal axis, which then stands below it.
export const axisNote = (label: string): Child => isNarrow() && h('p', { class: 'soft small' }, label);

export interface FigureSpec { id: string; title: string; note?: string | undefined }

export function figure({ id, title, note }: FigureSpec, picture: SVGElement | HTMLElement, ...below: Child[]): HTMLElement {
  picture.setAttribute('role', 'group');
  picture.setAttribute('aria-label', `${title}; the tables have the values`);
  return h('figure', { id, class: 'chart' },
    h('figcaption', {}, h('strong', {}, title), note && h('span', {}, note)), h('div', { class: 'plot' }, picture), ...below);
}

// Returns the legend of a chart of areas: each name beside its colour.
export const chips = (entries: { name: string; colour: string }[]) =>
  h('p', { class: 'chips' }, ...entries.map(({ name, colour }) => chip(name, colour)));

export const chip = (name: string, colour: string) => h('span', { class: 'chip', style: `--a: ${colour}; color: ${textColourOn(colour)}` }, name);
