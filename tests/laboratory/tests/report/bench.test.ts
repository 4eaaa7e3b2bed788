import { contestantTitle, familyLines, goalLines, indexBench, overallAt, overallSpan, sceneTitle, type BenchDocument, type BenchRow, type Ratio } from '../../report/src/model/bench';

const row = (more: Partial<BenchRow>): BenchRow => ({
  scene: 'suite-b', objects: 1000, arm: 'SAP', threads: 1, frames: 40, ms_median: 1, ms_mean: 1, ms_min: 1, ms_p99: 2, pairs_mean: 9,
  aabb_checks_mean: 5, bytes: 10, bytes_with_pairs: 20, kind: 'arm', family: 'SAP', simd: 'avx512', ...more });
const ratio = (more: Partial<Ratio>): Ratio => ({
  scene: 'suite-b', objects: 1000, threads: 1, kind: 'overall', family: 'SAP', ours: 'SAP', simd: 'avx512', other: 'Bullet', value: 5, ...more });
const document = (rows: BenchRow[], more: Partial<BenchDocument> = {}): BenchDocument => ({
  command: 'bench', warmup: 1, seed: 1, rows, ratios: [],
  machine: { date: '', program: '', cpu: '', cores: 1, system: '', compiler: '', simd: '', libraries: {} }, ...more });

describe('the index of a bench', () => {
  it('orders cells by count and contestants by family, ours first', () => {
    const index = indexBench(document([row({ objects: 3000, arm: 'Bullet', kind: 'peer' }), row({ objects: 3000 }), row({}), row({ arm: 'Grid', family: 'Grid' })]));
    expect(index.scenes).toEqual([{ name: 'suite-b', cells: [{ scene: 'suite-b', objects: 1000 }, { scene: 'suite-b', objects: 3000 }] }]);
    expect(index.contestants.map(({ name }) => name)).toEqual(['Grid', 'SAP', 'Bullet']);
  });

  it('takes the fewest threads for a contestant and leaves out what measured nothing', () => {
    const index = indexBench(document([row({ threads: 2, ms_median: 0.1 }), row({}), row({ arm: 'Slow', kind: 'peer', frames: 0, note: 'too slow' })]));
    expect(index.contestants).toEqual([{ name: 'SAP', family: 'SAP', kind: 'arm', threads: 1, simd: null }]);
    expect(index.threadCounts).toEqual([1, 2]);
    expect(index.fastest(index.cells[0]!)!.ms_median).toBe(1);
  });

  it('has a contestant per instruction set where there are several, the best first', () => {
    const rows = ['avx512', 'sse4'].map((simd) => row({ simd, ms_median: simd === 'sse4' ? 3 : 1 }));
    const index = indexBench(document([...rows, row({ arm: 'Bullet', kind: 'peer', simd: null })]));
    expect(index.sets).toEqual(['avx512', 'sse4']);
    expect(index.contestants.map(({ name, threads, simd }) => contestantTitle(name, threads, simd))).toEqual(['SAP avx512', 'SAP sse4', 'Bullet']);
    expect(index.contestants.map((each) => index.rowOf(index.cells[0]!, each)!.ms_median)).toEqual([1, 3, 1]);
    expect(contestantTitle('SAP', 2, 'sse4')).toBe('SAP sse4 (2 threads)');
  });

  it('names no instruction set where there is one', () => {
    const index = indexBench(document([row({}), row({ arm: 'Bullet', kind: 'peer', simd: null })], { ratios: [ratio({})] }));
    expect(index.sets).toEqual([null]);
    expect([...index.rows, ...index.ratios, ...index.contestants].map(({ simd }) => simd)).toEqual([null, null, null, null, null]);
  });

  it('names a recording by its file unless two have the same name', () => {
    const one = indexBench(document([row({ scene: '/a/x.aabbs' })]));
    expect(sceneTitle(one, '/a/x.aabbs')).toBe('x.aabbs');
    const two = indexBench(document([row({ scene: '/a/x.aabbs' }), row({ scene: '/b/x.aabbs' })]));
    expect(sceneTitle(two, '/a/x.aabbs')).toBe('/a/x.aabbs');
  });
});

describe('comparisons', () => {
  it('are merged with published ones and with their goals', () => {
    const index = indexBench(document([row({}), row({ objects: 3000 })], {
      ratios: [ratio({}), ratio({ objects: 3000, value: 9 })],
      published: [ratio({ other: 'PhysX', value: 3, derived_through: 'Embree' })],
      goals: [ratio({ goal: 4, met: true }), ratio({ other: 'PhysX', value: 3, derived_through: 'Embree', goal: 4, met: false })] }));
    expect(index.ratios).toHaveLength(3);
    expect(overallSpan(index, false)).toEqual({ low: 5, high: 9, count: 2 });
    expect(overallSpan(index, true)).toEqual({ low: 3, high: 3, count: 1 });
    expect(goalLines(index).map(({ kind, met, all, missed }) => [kind, met, all, missed.map(({ other }) => other)])).toEqual([['overall', 1, 2, ['PhysX']]]);
  });

  it('overall are those of one instruction set, the best one in the span, and of the hardest published peer', () => {
    const published = { derived_through: 'Embree' };
    const index = indexBench(document([row({}), row({ simd: 'avx2' })], {
      ratios: [ratio({}), ratio({ simd: 'avx2', value: 2 })],
      published: [ratio({ other: 'PhysX', value: 7, ...published }), ratio({ other: 'Jolt', value: 6, ...published })] }));
    expect(index.ratios).toHaveLength(4);
    expect(overallSpan(index, false)).toEqual({ low: 5, high: 5, count: 1 });
    expect(overallSpan(index, true)).toEqual({ low: 6, high: 6, count: 1 });
    expect(overallAt(index, index.cells[0]!, 1, 'avx2', false).map(({ value }) => value)).toEqual([2]);
    expect(overallAt(index, index.cells[0]!, 1, 'avx512', true).map(({ other }) => other)).toEqual(['Jolt', 'PhysX']);
  });

  it('between instruction sets have a line of goals of their own', () => {
    const judged = ratio({ kind: 'simd', simd: 'sse4', other: 'avx2', value: 0.9, goal: 2, goal_at_least: 1, met: false });
    const index = indexBench(document([row({}), row({ simd: 'sse4' })], { ratios: [judged] }));
    expect(goalLines(index).map(({ kind, met, all }) => [kind, met, all])).toEqual([['simd', 0, 1]]);
  });

  it('by family make a line per published peer and one for those that ran', () => {
    const lines = familyLines([ratio({ kind: 'family' }), ratio({ kind: 'family', other: 'Ode' }), ratio({ kind: 'family', other: 'PhysX', derived_through: 'Embree' }),
      ratio({ kind: 'family', simd: 'sse4' })]);
    expect(lines.map(({ ours, threads, simd, published }) => [ours, threads, simd, published])).toEqual(
      [['SAP', 1, 'avx512', ''], ['SAP', 1, 'avx512', 'PhysX'], ['SAP', 1, 'sse4', '']]);
  });
});
