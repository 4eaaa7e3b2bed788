// What all charts share: the figure around a picture, its legend, and the values shown at the
// pointer and by the arrow keys. A mark with a title answers to both.
import { h, type Child } from '../dom';
import { textColourOn } from '../../../../../server/dashboard/src/palette';

const REACH = 30; // pixels from the pointer to a mark that still answers

export const LETTER = 7.6; // mean width of a bold letter at 13 px, rounded up
export const widest = (texts: string[]) => LETTER * Math.max(0, ...texts.map((text) => text.length)) + 20;

interface Target { element: SVGElement; box: DOMRect; text: string }

function distance({ left, right, top, bottom }: DOMRect, x: number, y: number): number {
  return Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
}

// Replaces titles by labels, because the browser's own tooltip would cover ours.
function takeTitles(svg: SVGElement): Map<SVGElement, string> {
  const texts = new Map<SVGElement, string>();
  for (const title of svg.querySelectorAll<SVGTitleElement>(':scope > g title')) {
    const mark = title.parentElement as unknown as SVGElement;
    texts.set(mark, title.textContent ?? '');
    mark.setAttribute('aria-label', title.textContent ?? '');
    mark.classList.add('point');
    title.remove();
  }
  return texts;
}

function nearest(targets: Target[], x: number, y: number): Target | undefined {
  let best: Target | undefined;
  let reach = REACH;
  for (const target of targets) {
    const away = distance(target.box, x, y);
    if (away < reach) [reach, best] = [away, target];
  }
  return best;
}

// Left and right follow the picture from mark to mark; up and down go to the nearest mark above and below.
function neighbour(targets: Target[], from: Target | undefined, key: string): Target | undefined {
  if (!from) return targets[0];
  const horizontal = key === 'ArrowLeft' || key === 'ArrowRight';
  const sign = key === 'ArrowRight' || key === 'ArrowDown' ? 1 : -1;
  const along = (to: Target) => sign * (horizontal ? to.box.x - from.box.x : to.box.y - from.box.y);
  const across = (to: Target) => Math.abs(horizontal ? to.box.y - from.box.y : to.box.x - from.box.x);
  const ahead = targets.filter((to) => to !== from && along(to) > 0.5);
  ahead.sort((a, b) => along(a) + 3 * across(a) - along(b) - 3 * across(b));
  return ahead[0] ?? from;
}

// Shows the values of `svg`'s marks in a box beside them, and makes other series faint meanwhile.
function explain(svg: SVGElement, plot: HTMLElement): void {
  const texts = takeTitles(svg);
  if (texts.size === 0) return;
  const tip = h('div', { class: 'tip', role: 'status', hidden: 'hidden' });
  plot.append(tip);
  const targets = () => [...texts].map(([element, text]) => ({ element, text, box: element.getBoundingClientRect() }));
  let focused: Target | undefined;

  function show(target: Target | undefined): void {
    for (const on of svg.querySelectorAll('.on')) on.classList.remove('on');
    const series = target?.element.closest('[class*="series-"]');
    svg.classList.toggle('one', Boolean(series));
    tip.hidden = !target;
    if (!target) return;
    target.element.classList.add('on');
    const name = [...(series?.classList ?? [])].find((each) => each.startsWith('series-'));
    if (name) for (const part of svg.querySelectorAll(`.${name}`)) part.classList.add('on');
    tip.textContent = target.text;
    const frame = plot.getBoundingClientRect();
    const x = target.box.right - frame.left + plot.scrollLeft;
    const fits = target.box.right + 14 + tip.offsetWidth < frame.right;
    const left = fits ? x + 10 : Math.max(0, target.box.left - frame.left + plot.scrollLeft - tip.offsetWidth - 10);
    tip.style.left = `${Math.min(left, plot.scrollLeft + frame.width - tip.offsetWidth)}px`;
    tip.style.top = `${Math.max(0, target.box.top - frame.top - tip.offsetHeight / 2)}px`;
  }

  svg.setAttribute('tabindex', '0');
  svg.addEventListener('pointermove', (event) => show(nearest(targets(), event.clientX, event.clientY) ?? focused));
  svg.addEventListener('pointerleave', () => show(focused));
  svg.addEventListener('blur', () => show(focused = undefined));
  svg.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' && !event.key.startsWith('Arrow')) return;
    event.preventDefault();
    const all = targets();
    const current = all.find(({ element }) => element === focused?.element);
    show(focused = event.key === 'Escape' ? undefined : neighbour(all, current, event.key));
  });
}

export interface FigureSpec { id: string; title: string; note?: string | undefined }

export function figure({ id, title, note }: FigureSpec, picture: SVGElement | HTMLElement, ...below: Child[]): HTMLElement {
  const plot = h('div', { class: 'plot' });
  show(plot, title, picture);
  return h('figure', { id, class: 'chart' },
    h('figcaption', {}, h('strong', {}, title), note && h('span', {}, note)), plot, ...below);
}

// Replaces the content of a figure's `plot` by `picture`.
export function show(plot: HTMLElement, title: string, picture: SVGElement | HTMLElement): void {
  plot.replaceChildren(picture);
  picture.setAttribute('role', 'group');
  picture.setAttribute('aria-label', `${title}; the tables hold the values`);
  if (picture instanceof SVGElement) explain(picture, plot);
}

// Names with their colours, for charts of areas.
export function chips(entries: { name: string; colour: string }[]): HTMLElement {
  return h('p', { class: 'chips' }, ...entries.map(({ name, colour }) => chip(name, colour)));
}

export const chip = (name: string, colour: string) => h('span', { class: 'chip', style: `--a: ${colour}; color: ${textColourOn(colour)}` }, name);
