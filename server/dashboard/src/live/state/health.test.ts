import { expect, it } from 'vitest';
import { parseChecks, parseMetrics, quantileOf } from './health';

it('reads checks, their problems and their notes', () => {
  const text = '[+]decision-loop ok\n[-]store failed: disk full: /x\n[+]tls ok, but it expires\nreadyz check failed\n';
  expect(parseChecks(text)).toEqual([
    { name: 'decision-loop', isOk: true, note: '' },
    { name: 'store', isOk: false, note: 'disk full: /x' },
    { name: 'tls', isOk: true, note: 'it expires' },
  ]);
});

const TEXT = `commit_bucket{le="0.001"} 90
commit_bucket{le="0.01"} 99
commit_bucket{le="+Inf"} 100
commit_sum 1.5
commit_count 100
`;

it('reads quantiles of all observations, and of those after an earlier reading', () => {
  const metrics = parseMetrics(TEXT);
  expect(quantileOf(metrics, undefined, 'commit', 0.5)).toBe(0.001);
  expect(quantileOf(metrics, undefined, 'commit', 0.99)).toBe(0.01);
  expect(quantileOf(metrics, metrics, 'commit', 0.5)).toBeUndefined();
  const before = parseMetrics('commit_bucket{le="0.001"} 90\ncommit_bucket{le="0.01"} 90\ncommit_bucket{le="+Inf"} 90\n');
  expect(quantileOf(metrics, before, 'commit', 0.5)).toBe(0.01);
  expect(quantileOf(metrics, before, 'commit', 1)).toBe(Infinity);
});
