import { describe, expect, it, vi } from 'vitest';
import { domainOf, placeAt, range, setRange, zoomed } from './view_state';

describe('the range of time', () => {
  it('is the chosen range or all times, and is never empty', () => {
    expect(domainOf([5000, 9000], { fromMs: 1, toMs: 2 })).toEqual({ fromMs: 1, toMs: 2 });
    expect(domainOf([5000, 9000], undefined)).toEqual({ fromMs: 5000, toMs: 9000 });
    expect(domainOf([5000], undefined)).toEqual({ fromMs: 5000, toMs: 6000 });
    const { fromMs, toMs } = domainOf([], undefined);
    expect(toMs - fromMs).toBe(1000);
  });

  it('is in the URL, from 1970 to tomorrow, with its ends in order', () => {
    vi.stubGlobal('history', { pushState: vi.fn(), replaceState: vi.fn() });
    setRange({ fromMs: 9000.4, toMs: 5000 });
    expect(range.value).toEqual({ fromMs: 5000, toMs: 9000 });
    setRange({ fromMs: -1, toMs: 1e300 });
    expect(range.value!.fromMs).toBe(0);
    expect(range.value!.toMs - Date.now()).toBeGreaterThan(86_000_000);
    expect(range.value!.toMs - Date.now()).toBeLessThanOrEqual(86_400_000);
    setRange({ fromMs: 5000, toMs: 5000 });
    expect(range.value, 'an empty range').toBeUndefined();
    setRange(undefined);
    expect(range.value).toBeUndefined();
  });

  it('is zoomed about a time, whose position does not change', () => {
    expect(zoomed({ fromMs: 0, toMs: 100 }, 25, 0.5)).toEqual({ fromMs: 12.5, toMs: 62.5 });
    expect(zoomed({ fromMs: 0, toMs: 100 }, 500, 2)).toEqual({ fromMs: -100, toMs: 100 });
  });

  it('finds the last time that is not after a given time', () => expect([-1, 1, 4, 5, 99].map((ms) => placeAt([1, 4, 5], ms))).toEqual([-1, 0, 1, 2, 2]));
});
