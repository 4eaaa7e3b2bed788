// Follows the daemon's health while somebody looks: the checks on every view that names them, the figures on the view of its own.
import { signal, type ReadonlySignal } from '@preact/signals';
import { asApiError, type ApiError } from '../transport/calls';
import { parseChecks, parseMetrics, type Check, type Metrics } from './metrics';

const CHECKS_INTERVAL_MS = 10_000;
const FIGURES_INTERVAL_MS = 2000;
const PATIENCE_MS = 5000;
export const MAX_SAMPLES = 151;  // five minutes

export interface Sample {
  atMs: number;
  metrics: Metrics;
}

const heldChecks = signal<readonly Check[] | undefined>(undefined);
const heldSamples = signal<readonly Sample[]>([]);
const heldError = signal<ApiError | undefined>(undefined);
export const checks: ReadonlySignal<readonly Check[] | undefined> = heldChecks;  // undefined: not known yet
export const samples: ReadonlySignal<readonly Sample[]> = heldSamples;  // oldest first
export const healthError: ReadonlySignal<ApiError | undefined> = heldError;

const get = (path: string) => fetch(path, { cache: 'no-store', signal: AbortSignal.timeout(PATIENCE_MS) });

async function learn(task: () => Promise<void>): Promise<void> {
  try {
    await task();
    heldError.value = undefined;
  } catch (error) {
    heldError.value = asApiError(error);
  }
}

// A daemon that is not ready says so with 503, and lists its checks all the same.
export const learnChecks = () => learn(async () => {
  heldChecks.value = parseChecks(await (await get('/readyz?verbose')).text());
});

export const learnFigures = () => learn(async () => {
  const metrics = parseMetrics(await (await get('/metrics')).text());
  heldSamples.value = [...heldSamples.peek(), { atMs: Date.now(), metrics }].slice(-MAX_SAMPLES);
});

function repeat(task: () => Promise<void>, intervalMs: number): () => void {
  void task();
  const timer = setInterval(() => { if (!document.hidden) void task(); }, intervalMs);
  return () => clearInterval(timer);
}

// They learn until the returned function is called.
export const followChecks = () => repeat(learnChecks, CHECKS_INTERVAL_MS);
export const followFigures = () => repeat(learnFigures, FIGURES_INTERVAL_MS);
