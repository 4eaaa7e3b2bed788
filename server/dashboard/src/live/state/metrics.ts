// Parsers of the checks of /readyz and the figures of /metrics.

// One check of /readyz?verbose.
export interface Check {
  name: string;
  isOk: boolean;
  note: string;  // the problem of a failed check, or a warning
}

const CHECK = /^\[([+-])\](\S+) (?:ok|failed)(?:: (.*)|, but (.*))?$/;

export function parseChecks(text: string): Check[] {
  return text.split('\n').map((line) => CHECK.exec(line)).filter((found) => found !== null)
    .map(([, sign, name, problem, note]) => ({ name: name!, isOk: sign === '+', note: problem ?? note ?? '' }));
}

// By the name of a metric family: its values by their labels, such as `reason="MALFORMED_MESSAGE"`; '' for a value without labels.
export type Metrics = ReadonlyMap<string, ReadonlyMap<string, number>>;

const SAMPLE = /^([a-zA-Z_:][\w:]*)(?:\{(.*)\})? (\S+)/;
const numberOf = (text: string) => (text === '+Inf' ? Infinity : text === '-Inf' ? -Infinity : Number(text));

// Reads the Prometheus text format.
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

// Returns the cumulative counts of a histogram's buckets, with ascending upper bounds.
function bucketsOf(metrics: Metrics, name: string): [bound: number, count: number][] {
  return [...metrics.get(`${name}_bucket`) ?? []].map(([labels, count]): [number, number] => [numberOf(labelOf(labels, 'le')), count])
    .sort(([a], [b]) => a - b);
}

// Returns the upper bound of the bucket that contains the quantile of the observations after `before`; undefined if there are none.
export function quantileOf(metrics: Metrics, before: Metrics | undefined, name: string, share: number): number | undefined {
  const earlier = new Map(before ? bucketsOf(before, name) : []);
  const buckets = bucketsOf(metrics, name).map(([bound, count]): [number, number] => [bound, count - (earlier.get(bound) ?? 0)]);
  const total = buckets.at(-1)?.[1] ?? 0;
  if (total <= 0) return undefined;
  return buckets.find(([, count]) => count >= share * total)?.[0];
}
