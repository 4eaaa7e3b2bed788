import { describe, expect, it } from 'vitest';
import { buildChanges, byWeight, costRatios, LANE, pooled, type SceneChange, type Taught } from './priors_diff';

type More = Partial<Taught['example']> & { bailOutCount?: number };
const taught = (build: string, arm: string, alpha: number, beta: number, { bailOutCount = 0, ...more }: More = {}): Taught => ({
  example: { project: 'arcade', scene: 'arena', build, machineClass: 'test', rewardVersion: 3, arm, backendVersion: 1, measuredBy: '', ...more },
  alpha, beta, bailOutCount,
});

const EVIDENCE: readonly Taught[] = [
  taught('1.1', 'SAP', 620, 380), taught('1.1', 'KDTree', 300, 200),
  taught('1.1', 'SAP', 6000, 4000, { measuredBy: LANE }), taught('1.1', 'KDTree', 5600, 4400, { measuredBy: LANE }),
  taught('1.1', 'Grid', 5300, 4700, { measuredBy: LANE }),
  taught('1.2', 'SAP', 610, 390), taught('1.2', 'SAP', 100, 900),
  taught('1.2', 'SAP', 6000, 4000, { measuredBy: LANE, backendVersion: 2 }), taught('1.2', 'SAP', 615, 385, { backendVersion: 2 }),
  taught('1.2', 'Grid', 640, 360), taught('1.2', 'KDTree', 200, 300, { bailOutCount: 2 }),
  taught('1.2', 'KDTree', 5600, 4400, { measuredBy: LANE }), taught('1.2', 'Grid', 6100, 3900, { measuredBy: LANE }),
  taught('1.2', 'DBVT', 10, 90),
  taught('1.1', 'SAP', 620, 380, { scene: 'same' }), taught('1.1', 'Grid', 610, 390, { scene: 'same' }),
  taught('1.2', 'SAP', 620, 380, { scene: 'same' }), taught('1.2', 'Grid', 611, 389, { scene: 'same' }),
  taught('1.2', 'SAP', 620, 380, { scene: 'cave', machineClass: '' }),
  taught('1.1', 'SAP', 100, 500, { scene: 'old', rewardVersion: 1 }), taught('1.2', 'SAP', 900, 500, { scene: 'old', rewardVersion: 1 }),
];

describe('changes from build to build', () => {
  it('are those that the command line tells', () => {
    // `sweepstake priors diff FILE FILE --build 1.1 --other-build 1.2 --json`, of a file with these records.
    const expected = [
      { scene: 'arena', machineClass: 'test', arms: [['DBVT', undefined, 146117.26256036034], ['Grid', 4.774500028878618, 1],
        ['KDTree', 2.4431987649455724, 179.89145149444013], ['SAP', 1, 1.2502293787677672]] },
      { scene: 'cave', machineClass: '', arms: [['SAP', undefined, 1]] },
    ];
    const near = (value: unknown) => (typeof value === 'number' ? expect.closeTo(value, 8) : value);
    const changes = buildChanges(EVIDENCE, '1.1', '1.2').sort((a, b) => a.scene.localeCompare(b.scene));
    expect(changes.map(({ scene, leader }) => [scene, leader])).toEqual([['arena', 'other'], ['cave', 'in one']]);
    expect(changes.reverse().sort(byWeight).map(({ scene }) => scene)).toEqual(['arena', 'cave']);
    expect(changes.map(({ scene, machineClass, arms }) => ({ scene, machineClass, arms: arms.map(({ arm, before, after }) => [arm, before?.median, after?.median]) })))
      .toEqual(expected.map(({ arms, ...rest }) => ({ ...rest, arms: arms.map((arm) => arm.map(near)) })));
  });
  it('come first where another arm is the cheapest one, then where costs differ most', () => {
    const ratio = (median: number) => ({ median, low: median, high: median });
    const scene = (name: string, leader: SceneChange['leader'], after: number) =>
      ({ project: 'arcade', scene: name, machineClass: '', leader, arms: [{ arm: 'SAP', before: ratio(1), after: ratio(after) }, { arm: 'Grid', after: ratio(9) }] });
    expect([scene('a', 'same', 1.1), scene('e', 'in one', 1), scene('b', 'same', 0.5), scene('c', 'other', 1), scene('d', 'same', 1.1)].sort(byWeight).map((each) => each.scene)).toEqual(['c', 'b', 'a', 'd', 'e']);
  });
  it('are none between a build and itself, or where nothing is known', () => {
    expect(buildChanges(EVIDENCE, '1.1', '1.1')).toEqual([]);
    expect(buildChanges(EVIDENCE, 'other', 'another')).toEqual([]);
  });
});

it('Windows move the visits to their level, and bail-outs keep an arm from looking better than its windows', () => {
  const lane = { alpha: 50, beta: 50 };
  const [live, visited, guarded] = pooled([
    { live: { alpha: 60, beta: 40 }, lane, bailOutCount: 0 }, { live: { alpha: 0, beta: 0 }, lane, bailOutCount: 0 }, { live: { alpha: 10, beta: 90 }, lane, bailOutCount: 1 }]);
  expect(live!.alpha / (live!.alpha + live!.beta)).toBeCloseTo(0.6, 12);
  expect(visited!.alpha / (visited!.alpha + visited!.beta)).toBeCloseTo(0.6, 12);
  expect(guarded!.alpha / (guarded!.alpha + guarded!.beta)).toBeCloseTo(0.1, 12);
});

it('The cheapest arm costs 1, and an arm without evidence nothing that is known', () => {
  const nothing = { alpha: 0, beta: 0 };
  const ratios = costRatios(new Map([
    ['SAP', { live: { alpha: 62, beta: 38 }, lane: nothing, bailOutCount: 0 }], ['Grid', { live: { alpha: 61, beta: 39 }, lane: nothing, bailOutCount: 0 }],
    ['DBVT', { live: nothing, lane: nothing, bailOutCount: 0 }]]));
  expect([...ratios.keys()]).toEqual(['SAP', 'Grid']);
  expect(ratios.get('SAP')).toEqual({ median: 1, low: 1, high: 1 });
  const { median, low, high } = ratios.get('Grid')!;
  expect(median).toBeCloseTo(Math.exp(0.01 * Math.log(5e9)), 12);
  // Of two means of 100 rewards of Bernoulli's kind, times the range of the logarithm.
  const deviation = Math.sqrt((0.62 * 0.38 + 0.61 * 0.39) / 101) * Math.log(5e9);
  expect([Math.log(high / median), Math.log(median / low)].map((each) => each / deviation)).toEqual([expect.closeTo(1.96, 3), expect.closeTo(1.96, 3)]);
});
