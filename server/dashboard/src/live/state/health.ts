// Polls the daemon's health while a view shows it: the checks of /readyz and the figures of /metrics.
import { computed, signal, type Signal } from '@preact/signals';
import { type ApiError, asApiError, parseError, urlOf } from '../transport/calls';

const CHECK = /^\[([+-])\](\S+) (?:ok|failed)(?:: (.*)|, but (.*))?$/;

/** Returns the checks of /readyz?verbose. `note` is the problem of a failed check, or a warning. */
export const parseChecks = (text: string) =>
  text.split('\n').map((line) => CHECK.exec(line)).filter((found) => found !== null)
    .map(([, sign, name, problem, note]) => ({ name: name!, isOk: sign === '+', note: problem ?? note ?? '' }));

// The metric families by name. A family has its values by their labels, such as `reason="MALFORMED_MESSAGE"`; '' for a value without labels.
export type Metrics = ReadonlyMap<string, ReadonlyMap<string, number>>;

const SAMPLE = /^([a-zA-Z_:][\w:]*)(?:\{(.*)\})? (\S+)/;
const numberOf = (text: string) => (text === '+Inf' ? Infinity : text === '-Inf' ? -Infinity : Number(text));

export function parseMetrics(text: string): Metrics {
  const families = new Map<string, Map<string, number>>();
  for (const line of text.split('\n')) {
    const found = line.startsWith('#') ? null : SAMPLE.exec(line);
    if (!found) continue;
    const [, name, labels = '', value] = found;
    if (!families.has(name!)) families.set(name!, new Map());
    families.get(name!)!.set(labels, numberOf(value!));
  }
  return families;
}

export const valueOf = (metrics: Metrics, name: string): number | undefined => metrics.get(name)?.get('');
export const sumOf = (metrics: Metrics, name: string): number => [...metrics.get(name)?.values() ?? []].reduce((sum, value) => sum + value, 0);

// Returns the value of the label `name`: "frame_time" for the label 'reason' of `reason="frame_time"`.
export const labelOf = (labels: string, name: string) => new RegExp(`(?:^|,)${name}="((?:[^"\\\\]|\\\\.)*)"`).exec(labels)?.[1] ?? '';

// Returns the upper bound of the bucket that contains the quantile of the observations after `before`; undefined if there are none.
export function quantileOf(metrics: Metrics, before: Metrics | undefined, name: string, share: number): number | undefined {
  const [latest, earlier] = [metrics, before].map((each) => each?.get(`${name}_bucket`));
  const buckets = [...latest ?? []].map(([labels, count]) => ({ bound: numberOf(labelOf(labels, 'le')), count: count - (earlier?.get(labels) ?? 0) }))
    .sort((a, b) => a.bound - b.bound);
  const total = buckets.at(-1)?.count ?? 0;
  return total > 0 ? buckets.find(({ count }) => count >= share * total)?.bound : undefined;
}

const CHECKS_INTERVAL_MS = 10_000;
const FIGURES_INTERVAL_MS = 2000;
const PATIENCE_MS = 5000;  // timeout of a request
const MAX_SAMPLES = 151;  // five minutes at FIGURES_INTERVAL_MS

export interface Sample {
  atMs: number;
  metrics: Metrics;
}

const checksError = signal<ApiError | undefined>(undefined);
const figuresError = signal<ApiError | undefined>(undefined);
export const checks = signal<ReturnType<typeof parseChecks> | undefined>(undefined);  // undefined: not known yet
export const samples = signal<readonly Sample[]>([]);  // oldest first
export const healthError = computed(() => checksError.value ?? figuresError.value);

// Requests `path` and passes the text to `take`. `take` returns false if it finds nothing in the text.
// That is an error, whatever the HTTP status.
async function learn(path: string, take: (text: string) => boolean, problem: Signal<ApiError | undefined>): Promise<void> {
  try {
    const response = await fetch(urlOf(path), { cache: 'no-store', signal: AbortSignal.timeout(PATIENCE_MS) });
    const text = await response.text();
    if (!take(text)) throw parseError(text, `the daemon answered ${path} with ${response.status} ${response.statusText}`);
    problem.value = undefined;
  } catch (error) {
    problem.value = asApiError(error);
  }
}

// A daemon that is not ready answers with status 503, and the answer still lists the checks.
export const learnChecks = () => learn('/readyz?verbose', (text) => {
  const all = parseChecks(text);
  if (all.length > 0) checks.value = all;
  return all.length > 0;
}, checksError);

export const learnFigures = () => learn('/metrics', (text) => {
  const metrics = parseMetrics(text);
  if (metrics.size > 0) samples.value = [...samples.peek(), { atMs: Date.now(), metrics }].slice(-MAX_SAMPLES);
  return metrics.size > 0;
}, figuresError);

/** Runs the task now and then at intervals, until the returned function is called. */
export function repeat(task: () => Promise<void>, intervalMs: number, evenHidden: boolean): () => void {
  void task();
  const timer = setInterval(() => { if (evenHidden || !document.hidden) void task(); }, intervalMs);
  return () => clearInterval(timer);
}

export function followHealth(): () => void {
  const ends = [repeat(learnChecks, CHECKS_INTERVAL_MS, false), repeat(learnFigures, FIGURES_INTERVAL_MS, false)];
  return () => ends.forEach((end) => end());
}
