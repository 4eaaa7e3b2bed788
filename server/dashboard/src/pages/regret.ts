// Charts and words of regret, for the pages of experiment and replay.
import type { RangeRow } from '../charts/range_chart';
import { percent, type Interval } from '../format';

export const REGRET_AXIS = 'Percent of frame time lost to the best fixed algorithm';
const MIN_PERCENT = 0.01;

// What loses less, or wins, stands at the left edge of the logarithmic axis.
export const onAxis = (ratio: number) => Math.max(100 * ratio, MIN_PERCENT);

export interface PlayerStyle { colour: string; solid: boolean }

// Ours in one colour, the paper's in another, other baselines in a third, fixed arms and the oracle in grey.
export function styleOf(name: string, isPolicy: boolean, own: string): PlayerStyle {
  if (name === own || name === 'default') return { colour: 'var(--own)', solid: true };
  if (name === 'paper') return { colour: 'var(--paper)', solid: true };
  return isPolicy ? { colour: 'var(--baseline)', solid: true } : { colour: 'var(--other)', solid: false };
}

export function regretRow(name: string, style: PlayerStyle, regret: number, [low, high]: Interval, text: string): RangeRow {
  return { name, ...style, low: onAxis(low), value: onAxis(regret), high: onAxis(high), label: percent(regret), text };
}
