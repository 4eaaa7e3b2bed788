// The document of `sweepstake-lab bench --json`, and its rows indexed for the page.
import { FAMILIES, familyRank } from '../../../../../server/dashboard/src/palette';
import type { Machine } from '../page';

export interface BenchRow {
  scene: string; objects: number; arm: string; threads: number; frames: number;
  ms_median: number; ms_mean: number; ms_min: number; ms_p99: number; pairs_mean: number;
  aabb_checks_mean: number | null; bytes: number | null; bytes_with_pairs: number | null;
  kind: 'arm' | 'peer'; family: string; simd: string | null; note?: string; difference?: string;
}
export type RatioKind = 'overall' | 'family' | 'simd' | 'growth' | 'threads' | 'spike' | 'memory';
export interface Ratio {
  scene: string; objects: number; threads: number; kind: RatioKind; family: string; ours: string; simd: string | null; other: string;
  value: number; value_mean?: number | null; goal?: number | null; goal_at_least?: number; met?: boolean | null; derived_through?: string;
}
export interface BenchDocument {
  command: 'bench'; command_line?: string; frames?: number; warmup: number; seed: number; threads?: number[]; simd?: string[]; cold?: boolean;
  peers?: boolean; peer_cap_s?: number; machine: Machine; rows: BenchRow[]; ratios: Ratio[];
  // tests/bench adds these: comparisons with peers whose times were published elsewhere, and comparisons with their
  // goals.
  published?: Ratio[]; goals?: Ratio[];
}

export interface Cell { scene: string; objects: number }
export interface Scene { name: string; cells: Cell[] }
// A row of the tables and a line of the charts: an arm with an instruction set, or a peer, with the fewest threads it ran with.
export interface Contestant { name: string; family: string; kind: 'arm' | 'peer'; threads: number; simd: string | null }

// `sets` contains the instruction sets of the arms, the best first. If all arms ran with the same set, `sets` is `[null]`, and only the
// machine's description names the set.
export interface BenchIndex {
  document: BenchDocument; scenes: Scene[]; cells: Cell[]; contestants: Contestant[]; families: string[];
  threadCounts: number[]; sets: (string | null)[]; rows: BenchRow[]; ratios: Ratio[];
  find(cell: Cell, name: string, threads: number, simd: string | null): BenchRow | undefined;
  rowOf(cell: Cell, contestant: Contestant): BenchRow | undefined;
  fastest(cell: Cell): BenchRow | undefined;
}

const unique = <T>(values: T[]) => [...new Set(values)];

function scenesOf(rows: BenchRow[]): Scene[] {
  return unique(rows.map(({ scene }) => scene)).map((name) => {
    const counts = unique(rows.filter(({ scene }) => scene === name).map(({ objects }) => objects));
    return { name, cells: counts.sort((a, b) => a - b).map((objects) => ({ scene: name, objects })) };
  });
}

function contestantsOf(rows: BenchRow[]): Contestant[] {
  const known = new Map<string, Contestant>();
  for (const { arm: name, family, kind, threads, simd, frames } of rows) {
    const key = [kind, name, simd].join('|');
    const before = known.get(key);
    if (frames > 0 && (!before || threads < before.threads)) known.set(key, { name, family, kind, threads, simd });
  }
  return [...known.values()].sort((a, b) =>
    familyRank(a.family) - familyRank(b.family) || a.family.localeCompare(b.family) || a.kind.localeCompare(b.kind));
}

const keyOf = ({ kind, scene, objects, threads, ours, simd, other, derived_through = '' }: Ratio) =>
  [kind, scene, objects, threads, ours, simd, other, derived_through].join('|');

// Merges the lists of comparisons. A comparison that is in several lists appears once in the result, with its goal if one of the lists has
// a goal for it.
function ratiosOf({ ratios, published = [], goals = [] }: BenchDocument): Ratio[] {
  const merged = new Map<string, Ratio>();
  for (const ratio of [...ratios, ...published, ...goals]) {
    merged.set(keyOf(ratio), { ...merged.get(keyOf(ratio)), ...ratio });
  }
  return [...merged.values()];
}

// Returns the instruction sets of the arms, or `[null]` if all arms ran with the same set.
function setsOf(rows: BenchRow[]): (string | null)[] {
  const sets = unique(rows.filter(({ kind }) => kind === 'arm').map(({ simd }) => simd));
  return sets.length > 1 ? sets : [null];
}

export function indexBench(document: BenchDocument): BenchIndex {
  const scenes = scenesOf(document.rows);
  const sets = setsOf(document.rows);
  const named = <T extends { simd: string | null }>(values: T[]): T[] => (sets.length > 1 ? values : values.map((each) => ({ ...each, simd: null })));
  const rows = named(document.rows);
  const measured = rows.filter(({ frames }) => frames > 0);
  const contestants = contestantsOf(measured);
  const find = (cell: Cell, name: string, threads: number, simd: string | null) => measured.find((row) =>
    row.scene === cell.scene && row.objects === cell.objects && row.arm === name && row.threads === threads && row.simd === simd);
  const rowOf = (cell: Cell, { name, threads, simd }: Contestant) => find(cell, name, threads, simd);
  return {
    document, scenes, contestants, sets, rows, find, rowOf,
    cells: scenes.flatMap(({ cells }) => cells),
    families: unique(contestants.map(({ family }) => family)),
    threadCounts: unique(measured.filter(({ kind }) => kind === 'arm').map(({ threads }) => threads)).sort((a, b) => a - b),
    ratios: named(ratiosOf(document)),
    fastest: (cell) => contestants.map((each) => rowOf(cell, each)).filter((row) => row !== undefined)
      .sort((a, b) => a.ms_median - b.ms_median)[0],
  };
}

export const largeIsGood = (kind: RatioKind) => kind === 'family' || kind === 'overall' || kind === 'threads';
export const isPublished = ({ derived_through = '' }: Ratio) => derived_through !== '';
export const hasGoal = ({ goal }: Ratio) => goal !== undefined && goal !== null;
export const contestantTitle = (name: string, threads: number, simd: string | null) =>
  (simd ? `${name} ${simd}` : name) + (threads === 1 ? '' : ` (${threads} threads)`);

// Returns the title of a scene. For a recording this is the file's name, unless two recordings have the same file name; then it is the
// path.
export function sceneTitle({ scenes }: BenchIndex, scene: string): string {
  const fileName = (path: string) => path.split(/[\\/]/).at(-1)!;
  if (!scene.endsWith('.aabbs')) return scene;
  const same = scenes.filter(({ name }) => fileName(name) === fileName(scene));
  return same.length > 1 ? scene : fileName(scene);
}

// Returns the comparisons of our best arm with the best peer in a cell, the smallest speedup first. If `published` is true, there may be
// several comparisons.
export function overallAt({ ratios }: BenchIndex, cell: Cell, threads: number, simd: string | null, published: boolean): Ratio[] {
  return ratios.filter((ratio) => ratio.kind === 'overall' && isPublished(ratio) === published && ratio.scene === cell.scene &&
    ratio.objects === cell.objects && ratio.threads === threads && ratio.simd === simd).sort((a, b) => a.value - b.value);
}

// Returns the smallest and the largest speedup over all cells of our best arm over the best peer, with the best instruction set and the
// fewest threads.
export function overallSpan(index: BenchIndex, published: boolean): { low: number; high: number; count: number } | undefined {
  const values = index.cells.flatMap((cell) => overallAt(index, cell, index.threadCounts[0]!, index.sets[0] ?? null, published).slice(0, 1))
    .map(({ value }) => value);
  return values.length === 0 ? undefined : { low: Math.min(...values), high: Math.max(...values), count: values.length };
}

export interface GoalLine { kind: RatioKind; met: number; all: number; missed: Ratio[] }

export function goalLines({ ratios }: BenchIndex): GoalLine[] {
  const kinds: RatioKind[] = ['overall', 'family', 'simd', 'growth', 'threads', 'spike', 'memory'];
  return kinds.map((kind) => {
    const judged = ratios.filter((ratio) => ratio.kind === kind && hasGoal(ratio));
    const missed = judged.filter(({ met }) => !met);
    return { kind, all: judged.length, met: judged.length - missed.length, missed };
  }).filter(({ all }) => all > 0);
}

// A line of the table by family: an arm, compared with the best peer that ran or with a published one.
export interface FamilyLine { ours: string; threads: number; simd: string | null; published: string }

export function familyLines(ratios: Ratio[]): FamilyLine[] {
  const lines = new Map<string, FamilyLine>();
  for (const ratio of ratios) {
    const published = isPublished(ratio) ? ratio.other : '';
    const { ours, threads, simd } = ratio;
    lines.set([ours, threads, simd, published].join('|'), { ours, threads, simd, published });
  }
  return [...lines.values()].sort((a, b) => FAMILIES.indexOf(a.ours) - FAMILIES.indexOf(b.ours));
}
