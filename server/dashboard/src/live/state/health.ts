// Polls the daemon's health while a view shows it: the checks of /readyz for the overview and the health view, the figures of /metrics
// for the health view.
import { computed, signal, type ReadonlySignal, type Signal } from '@preact/signals';
import { asApiError, parseError, type ApiError } from '../transport/calls';
import { parseChecks, parseMetrics, type Check, type Metrics } from './metrics';

const CHECKS_INTERVAL_MS = 10_000;
const FIGURES_INTERVAL_MS = 2000;
const PATIENCE_MS = 5000;  // timeout of a request
export const MAX_SAMPLES = 151;  // five minutes at FIGURES_INTERVAL_MS

export interface Sample {
  atMs: number;
  metrics: Metrics;
}

const heldChecks = signal<readonly Check[] | undefined>(undefined);
const heldSamples = signal<readonly Sample[]>([]);
const checksError = signal<ApiError | undefined>(undefined);
const figuresError = signal<ApiError | undefined>(undefined);
export const checks: ReadonlySignal<readonly Check[] | undefined> = heldChecks;  // undefined: not known yet
export const samples: ReadonlySignal<readonly Sample[]> = heldSamples;  // oldest first
export const healthError: ReadonlySignal<ApiError | undefined> = computed(() => checksError.value ?? figuresError.value);

// Requests `path` and passes the parsed answer to `take`. If `parse` returns undefined, that is an error, whatever the HTTP status.
async function learn<Found>(path: string, parse: (text: string) => Found | undefined, take: (found: Found) => void, problem: Signal<ApiError | undefined>): Promise<void> {
  try {
    const response = await fetch(path, { cache: 'no-store', signal: AbortSignal.timeout(PATIENCE_MS) });
    const text = await response.text();
    const found = parse(text);
    if (found === undefined) throw parseError(text, `the daemon answered ${path} with ${response.status} ${response.statusText}`);
    take(found);
    problem.value = undefined;
  } catch (error) {
    problem.value = asApiError(error);
  }
}

const checksIn = (text: string) => { const all = parseChecks(text); return all.length > 0 ? all : undefined; };
const metricsIn = (text: string) => { const all = parseMetrics(text); return all.size > 0 ? all : undefined; };

// A daemon that is not ready answers with status 503, and the answer still lists the checks.
export const learnChecks = () => learn('/readyz?verbose', checksIn, (all) => { heldChecks.value = all; }, checksError);

export const learnFigures = () => learn('/metrics', metricsIn, (metrics) => {
  heldSamples.value = [...heldSamples.peek(), { atMs: Date.now(), metrics }].slice(-MAX_SAMPLES);
}, figuresError);

function repeat(task: () => Promise<void>, intervalMs: number): () => void {
  void task();
  const timer = setInterval(() => { if (!document.hidden) void task(); }, intervalMs);
  return () => clearInterval(timer);
}

// These poll until the returned function is called.
export const followChecks = () => repeat(learnChecks, CHECKS_INTERVAL_MS);
export const followFigures = () => repeat(learnFigures, FIGURES_INTERVAL_MS);
