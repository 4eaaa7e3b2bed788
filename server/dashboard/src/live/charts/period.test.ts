import { describe, expect, it } from 'vitest';
import { PERIODS, timesOf } from './view_state';

const named = (name: string) => PERIODS.find((each) => each.name === name)!;

describe('the times of a period', () => {
  it('end now, and begin its length before', () =>
    expect(timesOf(named('hour'), undefined, 5_000_000)).toEqual({ fromUnixMs: 1_400_000, untilUnixMs: 0 }));
  it('are the whole history without a length', () => expect(timesOf(named('all'), undefined, 5_000_000)).toEqual({ fromUnixMs: 0, untilUnixMs: 0 }));
  it('are those of a chosen range', () => expect(timesOf(named('hour'), { fromMs: 10.4, toMs: 20.4 }, 5_000_000)).toEqual({ fromUnixMs: 10, untilUnixMs: 21 }));
});
