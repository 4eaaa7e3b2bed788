// Charts and texts about regret, shared by the pages of experiment and replay.
import type { RangeRow } from '../charts/range_chart';
import { SYMLOG_LINEAR } from '../charts/scales';
import { type Interval, percent } from '../format';

export const REGRET_AXIS = 'Percent of frame time lost to the best fixed algorithm';
// Explains the axis of a chart of regretRow, which has the scale `symlog`.
export const REGRET_SCALE = `Left is better; left of 0 is a gain. The axis is logarithmic beyond ±${SYMLOG_LINEAR} % and linear between.`;

export type PlayerStyle = Required<Pick<RangeRow, 'colour' | 'symbol' | 'solid'>>;

// AI Decides, the paper's policy and the other baselines have a colour each. Fixed arms and the oracle are grey.
export function styleOf(name: string, isPolicy: boolean, own: string): PlayerStyle {
  if (name === own || name === 'default') return { colour: 'var(--own)', symbol: 'circle', solid: true };
  if (name === 'paper') return { colour: 'var(--paper)', symbol: 'triangle', solid: true };
  return isPolicy ? { colour: 'var(--baseline)', symbol: 'diamond', solid: true } : { colour: 'var(--other)', symbol: 'circle', solid: false };
}

export function regretRow(name: string, style: PlayerStyle, regret: number, [low, high]: Interval, text: string): RangeRow {
  return { name, ...style, low: 100 * low, value: 100 * regret, high: 100 * high, label: percent(regret), text };
}
