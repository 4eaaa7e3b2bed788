// Detects a daemon that does not respond although the connection is open. The daemon sends nothing while nothing changes, so after
// some silence the page requests /livez. Without an answer the page's data is stale.
import { signal, type ReadonlySignal } from '@preact/signals';

const STALE_MS = 5000;  // silence after which the data is stale
const ASK_AFTER_MS = 3500;  // silence after which the page requests /livez
const PATIENCE_MS = 2500;  // timeout of the request
const BEAT_MS = 500;  // interval of the check

const stale = signal(false);
export const isStale: ReadonlySignal<boolean> = stale;

let heardMs = Date.now();
let isAsking = false;

export function heard(): void {
  heardMs = Date.now();
  stale.value = false;
}

async function ask(): Promise<void> {
  isAsking = true;
  try {
    await fetch('/livez', { cache: 'no-store', signal: AbortSignal.timeout(PATIENCE_MS) });
    heard();
  } catch {
    // No answer: the silence continues.
  } finally {
    isAsking = false;
  }
}

function beat(): void {
  if (document.hidden) return;
  const silentMs = Date.now() - heardMs;
  stale.value = silentMs > STALE_MS;
  if (silentMs > ASK_AFTER_MS && !isAsking) void ask();
}

// Starts the check. When a hidden page is shown, the time of silence starts at zero, because its timers did not run.
export function startPulse(): void {
  setInterval(beat, BEAT_MS);
  document.addEventListener('visibilitychange', () => {
    if (!document.hidden) heard();
  });
}
