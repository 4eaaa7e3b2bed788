import { create } from '../../transport/messages';
import { expect, it } from 'vitest';
import { HistoryPointSchema, HistorySeriesSchema } from '../../../gen/sweepstake/v1/history_pb';
import { changed, latestBuilds } from './lists';

const build = (name: string, unixMs: bigint) => create(HistorySeriesSchema, { build: name, points: [create(HistoryPointSchema, { unixMs })] });
const latest = (...series: ReturnType<typeof build>[]) => latestBuilds(series)?.map((each) => each.build);

it('the latest two builds are those first played last, and on a tie those with the highest names', () => {
  expect(latest(build('11', 5n), build('9', 7n), build('12', 1n))).toEqual(['11', '9']);
  expect(latest(build('12', 5n), build('9', 5n), build('11', 5n))).toEqual(['11', '12']);
  expect(latest(build('', 9n), build('11', 5n)), 'sessions without a build do not count').toBeUndefined();
});

it('a change has both values', () => {
  const text = (ns: number) => `${ns} ns`;
  expect(changed(168, 100, '11', text)).toBe('of 168 ns, 68.0 % more than build 11 (100 ns)');
  expect(changed(90, 100, '11', text)).toBe('of 90 ns, 10.0 % less than build 11 (100 ns)');
  expect(changed(100, 100, '11', text)).toBe('of 100 ns, the same as build 11');
  expect(changed(undefined, 100, '11', text)).toBe('that is not known');
  expect(changed(100, undefined, '11', text)).toBe('that is not known');
});
