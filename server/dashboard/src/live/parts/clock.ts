// A clock that updates texts such as "3 min ago", and functions that format times.
import { signal } from '@preact/signals';

// The browser's time in milliseconds since 1970, updated once a second while the page is visible.
export const now = signal(Date.now());
export const startClock = () => setInterval(() => { if (!document.hidden) now.value = Date.now(); }, 1000);

const UNITS: readonly [string, number][] = [['d', 86_400], ['h', 3600], ['min', 60], ['s', 1]];

// Returns a text such as "3 min"; "0 s" below a second.
export function duration(ms: number): string {
  const seconds = Math.max(0, Math.floor(ms / 1000));
  const [unit, size] = UNITS.find(([, each]) => seconds >= each) ?? ['s', 1];
  return `${Math.floor(seconds / size)} ${unit}`;
}

export const ago = (sinceMs: number, nowMs: number) => (nowMs - sinceMs < 2000 ? 'now' : `${duration(nowMs - sinceMs)} ago`);

// Returns a time in the browser's time zone, such as "2026-03-01 14:05:09", which is how dates are written in Swedish.
export const timeText = (unixMs: number) => new Date(unixMs).toLocaleString('sv');

// Returns the time of day, such as "14:05:09".
export const clockText = (unixMs: number) => new Date(unixMs).toLocaleTimeString('sv');
