// Reads the histograms that the daemon sends (message LogHistogram), and computes percentiles, with an error of at most 4.5 %.

/** The fields of the message LogHistogram. `bucketSteps` are the differences between the numbers of consecutive buckets. */
export interface LogHistogram { readonly bucketSteps: readonly number[]; readonly counts: readonly number[] }
/** The number of values in each bucket. */
export type Buckets = ReadonlyMap<number, number>;

/** The geometric middle of a bucket: bucket 0 contains the zeros, bucket n the numbers from 2^((n − 1)/8) to 2^(n/8). */
export const middleOf = (bucket: number) => (bucket === 0 ? 0 : 2 ** ((bucket - 0.5) / 8));

/** Decodes a message LogHistogram. Returns no buckets if it breaks the rules of the message. */
export function bucketsOf({ bucketSteps, counts }: LogHistogram): Buckets {
  const buckets = new Map<number, number>();
  if (bucketSteps.length !== counts.length) return buckets;
  let bucket = 0;
  bucketSteps.forEach((step, i) => {
    bucket += step;
    buckets.set(bucket, (buckets.get(bucket) ?? 0) + counts[i]!);
  });
  return buckets;
}

export const countOf = (buckets: Buckets) => [...buckets.values()].reduce((sum, count) => sum + count, 0);

/** Returns the value that `share` (0 to 1) of the values do not exceed; undefined without values. */
export function percentile(buckets: Buckets, share: number): number | undefined {
  const total = countOf(buckets);
  if (total === 0) return undefined;
  const rank = Math.max(1, Math.ceil(share * total));
  let below = 0;
  for (const [bucket, count] of buckets) {
    below += count;
    if (below >= rank) return middleOf(bucket);
  }
  return undefined;
}

/** Returns p50, p95 and p99; undefined without values. */
export function percentiles(histogram: LogHistogram | undefined): number[] | undefined {
  const buckets = histogram && bucketsOf(histogram);
  return buckets && countOf(buckets) > 0 ? [0.5, 0.95, 0.99].map((share) => percentile(buckets, share)!) : undefined;
}
