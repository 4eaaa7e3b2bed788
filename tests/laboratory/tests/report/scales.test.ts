import { linearTicks, logDomain, logTicks, spreadOut, symlogDomain, symlogTicks } from '../../report/src/charts/scales';
import { axisOf } from '../../report/src/charts/range_chart';
import { regretRow } from '../../report/src/pages/regret';
import { segmentsOf } from '../../report/src/charts/stacked_bars';

describe('a logarithmic axis', () => {
  it('reaches beyond its values, and far enough for one value', () => {
    const [low, high] = logDomain([1, 100], 1.25);
    expect(low).toBeCloseTo(0.8);
    expect(high).toBeCloseTo(125);
    const [alone, end] = logDomain([10]);
    expect(end / alone).toBeCloseTo(4);
  });

  it('passes over what has no logarithm', () => {
    expect(logDomain([0, -1, NaN, Infinity, 2, 20], 1)).toEqual([2, 20]);
    expect(logDomain([])).toEqual([1, 10]);
  });

  it('has ticks at 1, 2 and 5, or at decades where it is long', () => {
    expect(logTicks([0.04, 3])).toEqual([0.05, 0.1, 0.2, 0.5, 1, 2]);
    expect(logTicks([0.5, 20_000])).toEqual([1, 10, 100, 1000, 10_000]);
  });
});

describe('a linear axis', () => {
  it('has ticks at round numbers, whatever its ends are', () => {
    expect(linearTicks([0, 87.3])).toEqual([0, 10, 20, 30, 40, 50, 60, 70, 80]);
    expect(linearTicks([0, 100])).toEqual([0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
    expect(linearTicks([0, 0.0347])).toEqual([0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03]);
    expect(linearTicks([-0.3, 0.3], 5)).toEqual([-0.2, 0, 0.2]);
  });
});

describe('a symmetric logarithmic axis', () => {
  it('has room for negative values and for 0', () => {
    const [low, high] = symlogDomain([-13.4, -16.6, 0, 22.7], 1.25);
    expect(low).toBeCloseTo(-20.75);
    expect(high).toBeCloseTo(28.375);
    expect(symlogDomain([0, 0])).toEqual([0, 0.1]);
    expect(symlogDomain([NaN, 8], 1)).toEqual([0, 8]);
    expect(symlogDomain([-8], 1)).toEqual([-8, 0]);
  });

  it('has ticks at 0 and at powers of ten on both sides', () => {
    expect(symlogTicks([-20, 30])).toEqual([-10, -1, -0.1, 0, 0.1, 1, 10]);
    expect(symlogTicks([0, 2])).toEqual([0, 0.1, 1]);
    expect(symlogTicks([-20, 10_000])).toEqual([-10, -1, 0, 1, 10, 100, 1000, 10_000]);
    expect(symlogTicks([0, 0.1])).toEqual([0, 0.02, 0.04, 0.06, 0.08, 0.1]);
  });

  it('draws every value at its own place', () => {
    const row = (regret: number) => regretRow('a', { colour: '', symbol: 'circle', solid: true }, regret, [regret, regret], '');
    const values = [-0.166, -0.134, 0].map((regret) => row(regret).value);
    expect(new Set(values).size).toBe(3);
    const { domain: [low, high] } = axisOf('symlog', values);
    for (const value of values) expect(value).toSatisfy((at: number) => at > low && at <= high);
  });
});

describe('names', () => {
  it('stay in order and apart', () => {
    const placed = spreadOut([50, 52, 10, 99], 15, 0, 100);
    expect(placed[2]).toBe(10);
    expect(placed[1]! - placed[0]!).toBeGreaterThanOrEqual(15);
    expect(placed[3]! - placed[1]!).toBeGreaterThanOrEqual(15);
    expect(Math.max(...placed)).toBeLessThanOrEqual(100);
  });
});

describe('a stacked bar', () => {
  it('holds the shares of its values and leaves out what is zero', () => {
    const kinds = ['a', 'b', 'c'].map((name) => ({ name, colour: name }));
    const segments = segmentsOf({ kinds, rows: [{ name: 'row', values: [1, 0, 3] }, { name: 'none', values: [0, 0, 0] }] });
    expect(segments.map(({ name, from, to }) => [name, from, to])).toEqual([['a', 0, 0.25], ['c', 0.25, 1]]);
  });
});
