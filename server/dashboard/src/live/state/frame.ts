// Applies what arrives at most once per animation frame, and in one go: however many messages came since the last frame,
// every view is drawn once. A hidden page has no animation frames; there a timer takes their place.
import { batch } from '@preact/signals';

const HIDDEN_INTERVAL_MS = 1000;

type Update = () => void;
const waiting: Update[] = [];
let isScheduled = false;

function apply(): void {
  if (!isScheduled) return;
  isScheduled = false;
  const updates = waiting.splice(0);
  batch(() => updates.forEach((update) => update()));
}

// Calls `update` with the next frame, after those that were asked for earlier.
export function withNextFrame(update: Update): void {
  waiting.push(update);
  if (isScheduled) return;
  isScheduled = true;
  if (document.hidden) setTimeout(apply, HIDDEN_INTERVAL_MS);
  else requestAnimationFrame(apply);
}

// A page that is hidden meanwhile would wait for its frame until it is shown again.
export function applyWhenHidden(): void {
  document.addEventListener('visibilitychange', () => document.hidden && apply());
}
