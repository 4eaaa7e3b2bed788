// Parts that all charts share: the figure element around a picture, and its legend. The browser shows a mark's title as
// a tooltip.
import { h } from '../dom';
import { textColourOn } from '../palette';

export const LETTER = 7.6; // mean width of a bold letter at 13 px, rounded up
export const widest = (texts: string[]) => LETTER * Math.max(0, ...texts.map((text) => text.length)) + 20;

export interface FigureSpec { id: string; title: string; note?: string | undefined }

export function figure({ id, title, note }: FigureSpec, picture: SVGElement | HTMLElement, below?: HTMLElement): HTMLElement {
  picture.setAttribute('role', 'group');
  picture.setAttribute('aria-label', `${title}; the tables have the values`);
  return h('figure', { id, class: 'chart' },
    h('figcaption', {}, h('strong', {}, title), note && h('span', {}, note)), h('div', { class: 'plot' }, picture), below);
}

// Returns the legend of a chart of areas: each name beside its colour.
export const chips = (entries: { name: string; colour: string }[]) =>
  h('p', { class: 'chips' }, ...entries.map(({ name, colour }) => chip(name, colour)));

export const chip = (name: string, colour: string) => h('span', { class: 'chip', style: `--a: ${colour}; color: ${textColourOn(colour)}` }, name);
