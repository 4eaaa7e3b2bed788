import { describe, expect, it } from 'vitest';
import { measuredIn, savingsOf, sumOf } from './use';

const point = (ranUs: number, wouldTake: Record<string, number>, initialUs: number, frames = 10n) => ({
  frameCount: frames,
  ranUs,
  initialUs,
  initialKnownFrameCount: initialUs > 0 ? 6n : 5n,
  arms: Object.entries(wouldTake).map(([arm, wouldTakeUs]) =>
    ({ arm, wouldTakeUs, frameCount: arm === 'Rare' ? 1n : frames, knownFrameCount: arm === 'New' ? 5n : 6n, activeFrameCount: 0n })),
  frameTimeNs: { bucketSteps: [8], counts: [10] },
});

describe('savings of a point', () => {
  it('compare with the cheapest algorithm that all sessions have and mostly know', () => {
    const use = measuredIn(point(100, { KDTree: 150, SAP: 120, Rare: 1, New: 1 }, 200))!;
    expect(use.againstSingleUs).toBe(20);
    expect(use.againstReferenceUs).toBe(50);
    expect(use.againstInitialUs).toBe(100);
  });
  it('are absent without measured frames, without KDTree, and without a known initial algorithm', () => {
    expect(measuredIn(point(0, {}, 0, 0n))).toBeUndefined();
    const use = measuredIn(point(100, { SAP: 120 }, 0))!;
    expect(use.againstReferenceUs).toBeUndefined();
    expect(use.againstInitialUs).toBeUndefined();
  });
  it('have the time of the whole frames', () => {
    expect(measuredIn(point(100, { SAP: 120 }, 0))!.frameUs).toBeCloseTo((10 * 2 ** (7.5 / 8)) / 1000);
  });
});

describe('sums of savings', () => {
  it('add up, and leave out scenes without a known initial algorithm', () => {
    const sum = sumOf([measuredIn(point(100, { KDTree: 150, SAP: 120 }, 200)), undefined, measuredIn(point(50, { SAP: 40 }, 60)), measuredIn(point(7, { SAP: 9 }, 0))])!;
    expect(sum.frameCount).toBe(20);
    expect(sum.ranUs).toBe(150);
    expect(sum.againstSingleUs).toBe(10);
    expect(sum.againstInitialUs).toBe(110);
    expect(sum.againstReferenceUs).toBeUndefined();
  });
  it('are absent if nothing was measured', () => {
    expect(sumOf([undefined])).toBeUndefined();
    expect(sumOf([measuredIn(point(7, { SAP: 9 }, 0))])).toBeUndefined();
  });
});

it('a saving has its size per frame, its share of the frame time, and its baseline', () => {
  const [first] = savingsOf({ frameCount: 10, ranUs: 100, againstInitialUs: -50, frameUs: 1000 });
  expect(first).toEqual({ us: -5, ratio: -0.05, against: 'the algorithm that each game begins with' });
});
