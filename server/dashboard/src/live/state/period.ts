// The period of time that views with a history show, in the URL: the latest minutes to weeks, or a chosen range (charts/view_state.ts).
import { computed, type ReadonlySignal } from '@preact/signals';
import { range, type Range } from '../charts/view_state';
import { route } from './route';

const MINUTE_MS = 60_000;
const DAY_MS = 1440 * MINUTE_MS;

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
