// A clock that updates texts such as "3 min ago", and functions that format times.
import { signal } from '@preact/signals';

// The browser's time in milliseconds since 1970, updated once a second while the page is visible.
export const now = signal(Date.now());
export const startClock = () => setInterval(() => { if (!document.hidden) now.value = Date.now(); }, 1000);

const UNITS: readonly [string, number][] = [['day', 86_400], ['hour', 3600], ['minute', 60], ['second', 1]];
const formats = new Map(UNITS.map(([unit]) => [unit, new Intl.NumberFormat('en', { style: 'unit', unit, unitDisplay: 'short' })]));

// Returns a text such as "3 min" or "2 days"; "0 sec" below a second.
export function duration(ms: number): string {
  const seconds = Math.max(0, Math.floor(ms / 1000));
  const [unit, size] = UNITS.find(([, each]) => seconds >= each) ?? ['second', 1];
  return formats.get(unit)!.format(Math.floor(seconds / size));
}

export const ago = (sinceMs: number, nowMs: number) => (nowMs - sinceMs < 2000 ? 'now' : `${duration(nowMs - sinceMs)} ago`);

// British English has the day before the month and a clock of 24 hours. Times are in the browser's time zone.
const format = (options: Intl.DateTimeFormatOptions) => {
  const known = new Intl.DateTimeFormat('en-GB', options);
  return (unixMs: number) => known.format(unixMs);
};
export const timeText = format({ dateStyle: 'medium', timeStyle: 'medium' }); // such as "1 Mar 2026, 14:05:09"
export const clockText = format({ timeStyle: 'medium' }); // such as "14:05:09"
export const minuteText = format({ timeStyle: 'short' }); // such as "14:05"
export const dayText = format({ day: 'numeric', month: 'short' }); // such as "1 Mar"
