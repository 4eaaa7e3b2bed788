// Applies received changes together, at most once per animation frame, so that each view is drawn once for any number of messages. A
// hidden page has no animation frames and uses a timer instead.
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

// Calls `update` at the next frame, after updates that were passed earlier.
export function withNextFrame(update: Update): void {
  waiting.push(update);
  if (isScheduled) return;
  isScheduled = true;
  if (document.hidden) setTimeout(apply, HIDDEN_INTERVAL_MS);
  else requestAnimationFrame(apply);
}

// Applies pending updates when the page becomes hidden, because its next animation frame comes when it is shown again.
export function applyWhenHidden(): void {
  document.addEventListener('visibilitychange', () => document.hidden && apply());
}
