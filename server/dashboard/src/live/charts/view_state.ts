// What the charts of a view share: the range of time and the pause, which are in the address, the crosshair, and which arms are hidden.
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { route, setQuery } from '../state/route';

/** Times in milliseconds since 1970, by the daemon's clock. */
export interface Range { fromMs: number; toMs: number }

/** Where the reader points to; undefined: nowhere. */
export const crosshairMs = signal<number | undefined>(undefined);

const numberOf = (name: string) => {
  const value = Number(route.value.query.get(name) ?? Number.NaN);
  return Number.isFinite(value) ? value : undefined;
};

/** Undefined: all there is. */
export const range: ReadonlySignal<Range | undefined> = computed(() => {
  const fromMs = numberOf('from');
  const toMs = numberOf('to');
  return fromMs === undefined || toMs === undefined || toMs <= fromMs ? undefined : { fromMs, toMs };
});

export function setRange(next: Range | undefined): void {
  setQuery({ from: next && String(Math.round(next.fromMs)), to: next && String(Math.round(next.toMs)) }, { step: true });
}

/** Since when the view stands still; undefined: it does not. */
export const pausedMs: ReadonlySignal<number | undefined> = computed(() => numberOf('pause'));
export const setPaused = (atMs: number | undefined) => setQuery({ pause: atMs === undefined ? undefined : String(Math.round(atMs)) });

export const hiddenArms: ReadonlySignal<ReadonlySet<string>> = computed(() => new Set(route.value.query.getAll('hide').flatMap((list) => list.split('\n'))));
export function toggleArm(arm: string): void {
  const next = new Set(hiddenArms.peek());
  if (!next.delete(arm)) next.add(arm);
  next.delete('');
  setQuery({ hide: [...next].join('\n') });
}

/** Returns the value, or while the view is paused the one that it had when the pause began, or when it was first `isReady`. */
export function useFrozen<Value>(value: Value, isReady: boolean): Value {
  const held = useRef({ value, isReady });
  if (pausedMs.value === undefined || !held.current.isReady) held.current = { value, isReady };
  return held.current.value;
}

/** Returns the value, or where it changes more often than that, one that it had since: what costs much is not computed of each. */
export function usePaced<Value>(value: Value, everyMs: number): Value {
  const shown = useRef({ value, atMs: Number.NEGATIVE_INFINITY });
  const [, drawAgain] = useState(0);
  const waitMs = shown.current.atMs + everyMs - performance.now();
  if (value !== shown.current.value && waitMs <= 0) shown.current = { value, atMs: performance.now() };
  const isLate = value !== shown.current.value;
  useEffect(() => {
    if (!isLate) return undefined;
    const timer = setTimeout(() => drawAgain((count) => count + 1), waitMs);
    return () => clearTimeout(timer);
  });
  return shown.current.value;
}

/** Returns what is to be seen of what there is: the reader's range, or all of it. Never empty. */
export function domainOf(timesMs: readonly number[], shown: Range | undefined): Range {
  if (shown) return shown;
  const fromMs = timesMs[0] ?? Date.now();
  return { fromMs, toMs: Math.max(timesMs.at(-1) ?? fromMs, fromMs + 1000) };
}

/** Returns the place of the last time that is not after `timeMs`; −1: none. REQUIRES: times ascend. */
export function placeAt(timesMs: readonly number[], timeMs: number): number {
  let low = 0;
  let high = timesMs.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timesMs[middle]! <= timeMs) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Zooms about a time; a factor below 1 shows less, but for 10 ms. */
export function zoomed({ fromMs, toMs }: Range, aboutMs: number, asked: number): Range {
  const factor = asked < 1 ? Math.min(1, Math.max(asked, 10 / (toMs - fromMs))) : asked;
  const about = Math.min(Math.max(aboutMs, fromMs), toMs);
  return { fromMs: about - (about - fromMs) * factor, toMs: about + (toMs - about) * factor };
}
