// Whether the daemon is alive behind a connection that is open. Where nothing changes nothing is sent, so that after some silence the
// page asks; what gives no answer is stale, whatever the connection says.
import { signal, type ReadonlySignal } from '@preact/signals';

const STALE_MS = 5000;
const ASK_AFTER_MS = 3500;
const PATIENCE_MS = 2500;
const BEAT_MS = 500;

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
    // Its silence goes on.
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

// Begins to listen. A page that was hidden, whose timers rested, first asks.
export function startPulse(): void {
  setInterval(beat, BEAT_MS);
  document.addEventListener('visibilitychange', () => {
    if (!document.hidden) heard();
  });
}
