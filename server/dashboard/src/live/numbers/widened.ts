// Moves the times of steps, so that short states stay visible in a chart. Pure functions.

/** Returns the times at which to draw steps whose states are `states`: each run of equal states within the range is at least `leastMs` long, or
 * as long as all of them fit. REQUIRES: times ascend. */
export function widened(timesMs: readonly number[], states: readonly unknown[], { fromMs, toMs }: { fromMs: number; toMs: number }, leastMs: number): number[] {
  const starts = [...timesMs.keys()].filter((i) => (i === 0 || states[i] !== states[i - 1]) && timesMs[i]! >= fromMs && timesMs[i]! <= toMs);
  const lengthMs = Math.min(leastMs, (toMs - fromMs) / (starts.length + 1));
  const begins: number[] = [];
  for (const i of starts) begins.push(Math.max(timesMs[i]!, i === 0 ? fromMs : (begins.at(-1) ?? fromMs) + lengthMs));
  for (let k = begins.length - 1; k >= 0; --k) begins[k] = Math.min(begins[k]!, (begins[k + 1] ?? toMs) - lengthMs);
  let run = -1;
  return timesMs.map((ms, i) => {
    if (i === starts[run + 1]) return begins[++run]!;
    return Math.min(Math.max(ms, begins[run] ?? -Infinity), begins[run + 1] ?? Infinity);
  });
}
