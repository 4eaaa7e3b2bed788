import { describe, expect, it } from 'vitest';
import type { SceneHistory } from '../state/history';
import { centralInterval } from './beta';
import { PosteriorSeries } from './series';
import { diagnoseRewards } from './verdict';

const history = (points: Record<string, [timeMs: number, alpha: number, beta: number][]>): SceneHistory =>
  new Map(Object.entries(points).map(([arm, all]) => [arm, { timesMs: all.map(([ms]) => ms), alpha: all.map(([, alpha]) => alpha), beta: all.map(([, , beta]) => beta) }]));

describe('a series of posteriors', () => {
  const arms = ['A', 'B'];
  const rows = new PosteriorSeries(arms, 1).of(history({ A: [[10, 2, 2], [30, 20, 10]], B: [[20, 3, 9]] }));

  it('has a row for each time at which something changed', () => expect(rows.map(({ timeMs }) => timeMs)).toEqual([10, 20, 30]));

  it('keeps an arm as it was until it changes, and knows nothing before', () => {
    expect(rows.map(({ beliefs }) => beliefs.map((belief) => belief?.mean))).toEqual([[0.5, undefined], [0.5, 0.25], [20 / 30, 0.25]]);
    expect(rows[0]!.best).toEqual([undefined, undefined]);
  });

  it('has the intervals and probabilities of those posteriors', () => {
    const [low, high] = centralInterval({ alpha: 20, beta: 10 }, 0.95);
    expect([rows[2]!.beliefs[0]!.low95, rows[2]!.beliefs[0]!.high95]).toEqual([low, high]);
    expect(rows[2]!.best).toEqual(diagnoseRewards([{ alpha: 20, beta: 10 }, { alpha: 3, beta: 9 }], 1).bestProbability);
  });

  it('is bounded, and keeps peaks', () => {
    const long = Array.from({ length: 5000 }, (_, i): [number, number, number] => [i, i === 1234 ? 900 : 10, 10]);
    const thinned = new PosteriorSeries(['A'], 1).of(history({ A: long }));
    expect(thinned.length).toBeLessThanOrEqual(360);
    expect(thinned.map(({ timeMs }) => timeMs)).toContain(1234);
  });
});
