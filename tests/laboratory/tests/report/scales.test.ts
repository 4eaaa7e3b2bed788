import { logDomain, logTicks, spreadOut } from '../../report/src/charts/scales';
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
