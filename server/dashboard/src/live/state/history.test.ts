import { describe, expect, it } from 'vitest';
import { mean } from '../numbers/beta';
import { seriesOf } from '../state/history';

describe('a series of posteriors', () => {
  const history = { arms: ['B', 'A'], rows: [
    { timeMs: 10, expectedLossRatio: 0, arms: [{ alpha: 3, beta: 9 }] },
    { timeMs: 20, expectedLossRatio: 0.25, arms: [{ alpha: 3, beta: 9, best: 0.125 }, { alpha: 20, beta: 10, best: 0.875 }] },
  ] };
  const rows = seriesOf(history, ['A', 'B']);

  it('has the arms in the requested order, and undefined for an arm before its first evidence', () => {
    expect(rows.map(({ timeMs }) => timeMs)).toEqual([10, 20]);
    expect(rows.map(({ beliefs }) => beliefs.map((belief) => belief && mean(belief)))).toEqual([[undefined, 0.25], [20 / 30, 0.25]]);
  });

  it('has the probabilities and the loss that the daemon sent', () => {
    expect(rows[0]).toMatchObject({ best: [undefined, undefined], expectedLossRatio: undefined });
    expect(rows[1]).toMatchObject({ best: [0.875, 0.125], expectedLossRatio: 0.25 });
  });
});
