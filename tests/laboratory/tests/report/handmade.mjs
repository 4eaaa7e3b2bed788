// Documents made by hand: everything that a run can report but that a quick run of the program does not show.
const machine = {
  date: '2026-01-31T12:00:00Z', program: '0.1.0', cpu: 'Some <CPU> & Co', cores: 2, system: 'Linux', compiler: 'gcc 12', simd: 'avx512',
  libraries: { Highway: '1.0.3' }, absent_peers: ['ODE: libode-dev'],
};
export const EVIL = '/tmp/</script><b>"evil" & \'odd\'.aabbs';

const row = (scene, objects, kind, family, arm, ms, more = {}) => ({
  scene, objects, arm, threads: 1, frames: 40, ms_median: ms, ms_mean: ms * 1.1, ms_min: ms * 0.9, ms_p99: ms * 3, pairs_mean: 1234,
  aabb_checks_mean: kind === 'arm' ? 56_789 : null, bytes: kind === 'arm' ? 400_000 : null, bytes_with_pairs: kind === 'arm' ? 500_000 : null,
  kind, family, simd: kind === 'arm' ? 'avx512' : null, ...more });
// A comparison as the program prints it; tests/bench/judge.py adds `goal` and `met`, and `derived_through` to published ones.
const ratio = (objects, kind, ours, other, value, more = {}) =>
  ({ scene: 'suite-b', objects, threads: 1, kind, family: ours, ours, simd: 'avx512', other, value, value_mean: value, ...more });
export const bench = (rows, more = {}) => ({ command: 'bench', warmup: 20, frames: 40, seed: 1, simd: ['avx512'], cold: false, machine, rows, ratios: [], ...more });

const judged = [
  ratio(1000, 'overall', 'Grid', 'Bullet DBVT', 16.7, { goal: 5, met: true }),
  ratio(10_000, 'overall', 'Grid', 'Bullet DBVT', 1.67, { goal: 5, met: false }),
  ratio(1000, 'family', 'DBVT', 'Bullet DBVT', 8.33, { goal: 7, met: true }),
  ratio(10_000, 'spike', 'Grid', 'median', 3, { goal: 2, met: false }),
  ratio(10_000, 'growth', 'Grid', '1,000', 1, { goal: 2, met: true }),
  ratio(10_000, 'memory', 'Grid', '12 MB', 0.4, { goal: 1, met: true })];

export const fullBench = bench([
  ...[1000, 10_000].flatMap((objects) => [
    row('suite-b', objects, 'arm', 'Grid', 'Grid', objects * 3e-5), row('suite-b', objects, 'arm', 'DBVT', 'DBVT', objects * 9e-5),
    row('suite-b', objects, 'peer', 'DBVT', 'Bullet DBVT', 0.5)]),
  row('suite-b', 10_000, 'arm', 'Grid', 'Grid', 0.2, { threads: 2 }),
  row('suite-b', 1000, 'peer', 'Grid', 'Wrong', 0.4, { difference: 'frame 3: (1, 2) is missing' }),
  row('suite-b', 10_000, 'peer', 'SAP', 'Capped', 9, { frames: 3, note: 'stopped by the cap of 5 s' }),
  row('suite-b', 10_000, 'peer', 'SAP', 'Slow', 0, { frames: 0, note: 'would take longer than 5 s' }),
  row(EVIL, 77, 'arm', 'Grid', 'Grid', 0.01), row(EVIL, 77, 'peer', 'DBVT', 'Bullet DBVT', 0.5),
], {
  command_line: "sweepstake-lab bench --scene '<x>&'", threads: [1, 2], peers: true, peer_cap_s: 5,
  ratios: judged.map(({ goal, met, ...measured }) => measured), goals: judged,
  published: [ratio(1000, 'overall', 'Grid', 'Published peer', 99, { derived_through: 'Bullet DBVT', goal: 5, met: true })],
});

// Two instruction sets with cold caches, a peer beside them, and a goal between the sets that is missed.
const avx2 = { simd: 'avx2' };
const ofSets = [
  ratio(1000, 'overall', 'Grid', 'Embree', 20, { goal: 8, met: true }), ratio(1000, 'overall', 'Grid', 'Embree', 10, { ...avx2, goal: 8, met: true }),
  ratio(1000, 'family', 'Grid', 'Wrong', 6, { ...avx2 }),
  ratio(1000, 'simd', 'Grid', 'avx512', 2, { ...avx2, goal: 1.7, met: false }),
  ratio(1000, 'simd', 'SAP', 'avx512', 1.5, { ...avx2, goal: 2, goal_at_least: 1, met: true })];
const derived = { derived_through: 'Embree' };
export const benchOfSets = bench([
  row('suite-b', 1000, 'arm', 'Grid', 'Grid', 0.1), row('suite-b', 1000, 'arm', 'Grid', 'Grid', 0.2, avx2),
  row('suite-b', 1000, 'arm', 'Grid', 'Grid', 0.05, { threads: 2 }), row('suite-b', 1000, 'arm', 'Grid', 'Grid', 0.16, { threads: 2, ...avx2 }),
  row('suite-b', 1000, 'arm', 'SAP', 'SAP', 0.4), row('suite-b', 1000, 'arm', 'SAP', 'SAP', 0.6, avx2),
  row('suite-b', 1000, 'peer', 'KDTree', 'Embree', 2),
], {
  simd: ['avx512', 'avx2'], cold: true, threads: [1, 2], peers: true, peer_cap_s: 5,
  ratios: ofSets.map(({ goal, goal_at_least, met, ...measured }) => measured), goals: ofSets.filter(({ goal }) => goal),
  published: [ratio(1000, 'overall', 'Grid', 'Best published', 3, { ...avx2, ...derived }),
    ratio(1000, 'overall', 'Grid', 'Named peer', 5, { ...avx2, ...derived, goal: 4, met: true })],
});

const nothing = { ms_median: null, ms_mean: null, ms_min: null, ms_p99: null, pairs_mean: null, aabb_checks_mean: null };
// Documents that hold little: each has to be drawn, whatever is missing.
export const degenerateBenches = {
  'no rows': bench([]),
  'one point': bench([row('suite-b', 1000, 'arm', 'Grid', 'Grid', 0.5)]),
  'all equal': bench([1000, 2000].flatMap((objects) => ['Grid', 'SAP', 'Other'].map((arm) => row('suite-b', objects, 'arm', arm, arm, 0.5)))),
  'no time': bench([1000, 2000].map((objects) => row('suite-b', objects, 'arm', 'Grid', 'Grid', 0))),
  'no numbers': bench([1000, 2000].map((objects) => row('suite-b', objects, 'arm', 'Grid', 'Grid', 1, nothing))),
  'no number, one count': bench([row('suite-b', 1000, 'arm', 'Grid', 'Grid', 1, nothing), row('suite-b', 1000, 'arm', 'SAP', 'SAP', 1)]),
};

// What an experiment that was ended has: the first cell's rows and runs, a disturbed machine, a bail-out, nothing replayed.
export function partialExperiment(whole) {
  const runs = whole.runs.map((run, i) => ({ ...run, held_back_s: [run.end_s / 3, run.end_s / 2], bail_outs: i === 0 ? [{ time_s: run.end_s / 2, arm: 1 }] : [] }));
  const truths = whole.truths.map((truth) => ({ ...truth, control_ratio: 1.2, players: [], comparisons: [], agreements: [] }));
  const cells = whole.cells.map((cell) => ({ ...cell, scene: 'brownian', objects: 1000 }));
  const rows = whole.rows.map((each) => ({ ...each, scene: 'brownian', objects: 1000, dominance: 'KDTree 1/2; SAP 1/2' }));
  return { ...whole, complete: false, finished_runs: 5, planned_runs: 8, rows, runs, truths, cells, over_cells: [] };
}

// JSON has null in place of values that are not numbers. Computed figures can be null, counts cannot.
const COUNTS = ['runs', 'objects', 'seeds'];
const noNumbers = (values) => Object.fromEntries(Object.entries(values).map(([key, value]) =>
  [key, typeof value === 'number' && !COUNTS.includes(key) ? null : value]));
export function degenerateExperiments(whole) {
  const none = { rows: [], runs: [], truths: [], over_cells: [] };
  const runs = whole.runs.map((run) => ({ ...run, periods: [], held_back_s: [], posteriors: [], verdicts: {}, time: noNumbers(run.time) }));
  const nan = (run) => ({ ...run, posteriors: run.posteriors.map(({ time_s, means }) => ({ time_s, means: means.map(() => null) })) });
  const one = (run) => ({ ...run, posteriors: run.posteriors.slice(0, 1), active_shares: run.active_shares.map(() => 0) });
  return {
    'nothing is in': { ...whole, ...none, complete: false, finished_runs: 0 },
    'no truth': { ...whole, truths: [], over_cells: [] },
    'empty runs': { ...whole, runs },
    'no means': { ...whole, runs: whole.runs.map(nan) },
    'one mean': { ...whole, runs: whole.runs.map(one) },
    'no numbers': { ...whole, rows: whole.rows.map(noNumbers), truths: whole.truths.map((truth) => ({ ...truth, players: truth.players.map((each) => ({ ...noNumbers(each), ci95: [null, null] })) })) },
    'all equal': { ...whole, truths: whole.truths.map((truth) => ({ ...truth, players: truth.players.map((each) => ({ ...each, regret: 0.1, ci95: [0.1, 0.1] })) })) },
  };
}

export const degenerateReplays = (whole) => ({
  'no rows': { ...whole, rows: [], scenes: [] },
  'of an older program': { ...whole, calibration: undefined, rows: whole.rows.map(({ ms_per_frame, reliability, regret_detection, regret_60hz, ...rest }) => rest) },
  'no numbers': { ...whole, rows: whole.rows.map((each) => ({ ...noNumbers(each), ci95: [null, null], verdicts: {} })) },
});
export const judgedReplay = (whole) => ({ ...whole, goals: [
  { goal: 'regret', limit_text: '≤ 5 %', reached: 0.07, met: false, cells: [{ cell: 'storms', value: 0.07, met: false }] },
  { goal: 'memory', limit_text: '≤ 1', reached: null, met: false, cells: [] }] });
