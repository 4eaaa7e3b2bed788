// The state that the charts of a view share: period, range of time, pause and hidden arms (all in the URL), and the crosshair.
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { route, setQuery } from '../state/route';

/** Times in milliseconds since 1970, by the daemon's clock. */
export interface Range { fromMs: number; toMs: number }

/** The time under the pointer; undefined if the pointer is not in a chart. */
export const crosshairMs = signal<number | undefined>(undefined);

const numberOf = (name: string) => {
  const value = Number(route.value.query.get(name) ?? Number.NaN);
  return Number.isFinite(value) ? value : undefined;
};

const MINUTE_MS = 60_000;
const DAY_MS = 1440 * MINUTE_MS;

const within = (ms: number) => Math.min(Math.max(Math.round(ms), 0), Date.now() + DAY_MS);

export const range: ReadonlySignal<Range | undefined> = computed(() => {
  const [fromMs, toMs] = [numberOf('from'), numberOf('to')];
  if (fromMs === undefined || toMs === undefined) return undefined;
  return within(fromMs) < within(toMs) ? { fromMs: within(fromMs), toMs: within(toMs) } : undefined;
});

/** Sets the range of time, from 1970 to tomorrow. The ends may be in any order. */
export function setRange(next: Range | undefined): void {
  const [from, to] = next ? [within(next.fromMs), within(next.toMs)].sort((a, b) => a - b) : [];
  setQuery({ from: from?.toString(), to: to?.toString() }, { step: true });
}

export interface Period {
  name: string; // in the URL
  words: string;
  lengthMs: number; // 0: the whole history
}

export const PERIODS: readonly Period[] = [
  { name: 'quarter', words: 'last 15 minutes', lengthMs: 15 * MINUTE_MS },
  { name: 'hour', words: 'last hour', lengthMs: 60 * MINUTE_MS },
  { name: 'day', words: 'last day', lengthMs: DAY_MS },
  { name: 'week', words: 'last week', lengthMs: 7 * DAY_MS },
  { name: 'all', words: 'whole history', lengthMs: 0 },
];

/** The chosen period. A chosen range of time goes before it. */
export const period: ReadonlySignal<Period> = computed(() => PERIODS.find(({ name }) => name === route.value.query.get('period')) ?? PERIODS[0]!);

/** Returns the period as times; 0 as a start: the whole history, 0 as an end: now. */
export function timesOf({ lengthMs }: Period, chosen: Range | undefined, nowMs: number): { fromUnixMs: number; untilUnixMs: number } {
  if (chosen) return { fromUnixMs: Math.floor(chosen.fromMs), untilUnixMs: Math.ceil(chosen.toMs) };
  return { fromUnixMs: lengthMs === 0 ? 0 : nowMs - lengthMs, untilUnixMs: 0 };
}

export const periodKey: ReadonlySignal<string> = computed(() => `${period.value.name} ${range.value?.fromMs ?? ''} ${range.value?.toMs ?? ''}`);

/** When the view was paused; undefined if it is not. */
export const pausedMs: ReadonlySignal<number | undefined> = computed(() => numberOf('pause'));
export const setPaused = (atMs: number | undefined) => setQuery({ pause: atMs === undefined ? undefined : String(Math.round(atMs)) });

export const hiddenArms: ReadonlySignal<ReadonlySet<string>> = computed(() => new Set(route.value.query.getAll('hide').flatMap((list) => list.split('\n'))));
export function toggleArm(arm: string): void {
  const next = new Set(hiddenArms.peek());
  if (!next.delete(arm)) next.add(arm);
  next.delete('');
  setQuery({ hide: [...next].join('\n') });
}

/** Returns the value. While the view is paused, returns the value at the beginning of the pause, or the first value with `isReady`. */
export function useFrozen<Value>(value: Value, isReady: boolean): Value {
  const held = useRef({ value, isReady });
  if (pausedMs.value === undefined || !held.current.isReady) held.current = { value, isReady };
  return held.current.value;
}

/** Returns the value, updated at most once every `everyMs`, so that expensive computations do not run for each change. */
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

/** Returns the range to show: the chosen one, or all times. Never empty. */
export function domainOf(timesMs: readonly number[], shown: Range | undefined): Range {
  if (shown) return shown;
  const fromMs = timesMs[0] ?? Date.now();
  return { fromMs, toMs: Math.max(timesMs.at(-1) ?? fromMs, fromMs + 1000) };
}

/** Returns the index of the last time that is not after `timeMs`; −1 if there is none. REQUIRES: times ascend. */
export const placeAt = (timesMs: readonly number[], timeMs: number) => timesMs.findLastIndex((each) => each <= timeMs);

/** Zooms about a time. A factor below 1 shows less, but at least 10 ms. */
export function zoomed({ fromMs, toMs }: Range, aboutMs: number, asked: number): Range {
  const factor = asked < 1 ? Math.min(1, Math.max(asked, 10 / (toMs - fromMs))) : asked;
  const about = Math.min(Math.max(aboutMs, fromMs), toMs);
  return { fromMs: about - (about - fromMs) * factor, toMs: about + (toMs - about) * factor };
}

export function zoomAction(key: string, domain: Range, aboutMs: number): (() => void) | undefined {
  switch (key) {
    case '+': case '=': return () => setRange(zoomed(domain, aboutMs, 0.5));
    case '-': return () => setRange(range.peek() && zoomed(domain, aboutMs, 2));
    case '0': return () => setRange(undefined);
    default: return undefined;
  }
}
