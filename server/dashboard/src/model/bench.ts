// The document of `sweepstake bench --json`, and its rows indexed for the page.
import { FAMILIES, familyRank } from '../palette';
import type { Machine } from '../page';

export interface BenchRow {
  scene: string; objects: number; arm: string; threads: number; frames: number;
  ms_median: number; ms_mean: number; ms_min: number; ms_p99: number; pairs_mean: number;
  aabb_checks_mean: number | null; bytes: number | null; bytes_with_pairs: number | null;
  kind: 'arm' | 'peer'; family: string; note?: string; difference?: string;
}
export type RatioKind = 'overall' | 'family' | 'growth' | 'threads' | 'spike' | 'memory';
export interface Ratio {
  scene: string; objects: number; threads: number; kind: RatioKind; family: string; ours: string; other: string;
  value: number; value_mean?: number | null; goal?: number | null; met?: boolean | null; derived_through?: string;
}
export interface BenchDocument {
  command: 'bench'; command_line?: string; frames?: number; warmup: number; seed: number; threads?: number[];
  peers?: boolean; peer_cap_s?: number; machine: Machine; rows: BenchRow[]; ratios: Ratio[];
  // Added by tests/bench: comparisons with peers that did not run, and comparisons with their goals.
  published?: Ratio[]; goals?: Ratio[];
}

export interface Cell { scene: string; objects: number }
export interface Scene { name: string; cells: Cell[] }
// A row of the tables and a line of the charts: an arm or a peer, with the fewest threads it ran with.
export interface Contestant { name: string; family: string; kind: 'arm' | 'peer'; threads: number }

export interface BenchIndex {
  document: BenchDocument; scenes: Scene[]; cells: Cell[]; contestants: Contestant[]; families: string[];
  threadCounts: number[]; ratios: Ratio[];
  find(cell: Cell, name: string, threads: number): BenchRow | undefined;
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
  for (const { arm: name, family, kind, threads, frames } of rows) {
    const before = known.get(kind + name);
    if (frames > 0 && (!before || threads < before.threads)) known.set(kind + name, { name, family, kind, threads });
  }
  return [...known.values()].sort((a, b) =>
    familyRank(a.family) - familyRank(b.family) || a.family.localeCompare(b.family) || a.kind.localeCompare(b.kind));
}

const keyOf = ({ kind, scene, objects, threads, ours, other, derived_through = '' }: Ratio) =>
  [kind, scene, objects, threads, ours, other, derived_through].join('|');

// All comparisons once, each with its goal where there is one.
function ratiosOf({ ratios, published = [], goals = [] }: BenchDocument): Ratio[] {
  const merged = new Map<string, Ratio>();
  for (const ratio of [...ratios, ...published, ...goals]) {
    merged.set(keyOf(ratio), { ...merged.get(keyOf(ratio)), ...ratio });
  }
  return [...merged.values()];
}

export function indexBench(document: BenchDocument): BenchIndex {
  const scenes = scenesOf(document.rows);
  const measured = document.rows.filter(({ frames }) => frames > 0);
  const contestants = contestantsOf(measured);
  const find = (cell: Cell, name: string, threads: number) => measured.find((row) =>
    row.scene === cell.scene && row.objects === cell.objects && row.arm === name && row.threads === threads);
  const rowOf = (cell: Cell, { name, threads }: Contestant) => find(cell, name, threads);
  return {
    document, scenes, contestants, find, rowOf,
    cells: scenes.flatMap(({ cells }) => cells),
    families: unique(contestants.map(({ family }) => family)),
    threadCounts: unique(measured.filter(({ kind }) => kind === 'arm').map(({ threads }) => threads)).sort((a, b) => a - b),
    ratios: ratiosOf(document),
    fastest: (cell) => contestants.map((each) => rowOf(cell, each)).filter((row) => row !== undefined)
      .sort((a, b) => a.ms_median - b.ms_median)[0],
  };
}

export const largeIsGood = (kind: RatioKind) => kind === 'family' || kind === 'overall' || kind === 'threads';
export const isPublished = ({ derived_through = '' }: Ratio) => derived_through !== '';
export const hasGoal = ({ goal }: Ratio) => goal !== undefined && goal !== null;
export const contestantTitle = (name: string, threads: number) => (threads === 1 ? name : `${name} (${threads} threads)`);

// A recording goes by its file's name unless another recording has the same name.
export function sceneTitle({ scenes }: BenchIndex, scene: string): string {
  const fileName = (path: string) => path.split(/[\\/]/).at(-1)!;
  if (!scene.endsWith('.aabbs')) return scene;
  const same = scenes.filter(({ name }) => fileName(name) === fileName(scene));
  return same.length > 1 ? scene : fileName(scene);
}

// The lowest and the highest of our best against the best peer, with the fewest threads.
export function overallSpan({ ratios, threadCounts }: BenchIndex, published: boolean): { low: number; high: number; count: number } | undefined {
  const values = ratios.filter((ratio) => ratio.kind === 'overall' && isPublished(ratio) === published && ratio.threads === threadCounts[0])
    .map(({ value }) => value);
  return values.length === 0 ? undefined : { low: Math.min(...values), high: Math.max(...values), count: values.length };
}

export interface GoalLine { kind: RatioKind; met: number; all: number; missed: Ratio[] }

export function goalLines({ ratios }: BenchIndex): GoalLine[] {
  const kinds: RatioKind[] = ['overall', 'family', 'growth', 'threads', 'spike', 'memory'];
  return kinds.map((kind) => {
    const judged = ratios.filter((ratio) => ratio.kind === kind && hasGoal(ratio));
    const missed = judged.filter(({ met }) => !met);
    return { kind, all: judged.length, met: judged.length - missed.length, missed };
  }).filter(({ all }) => all > 0);
}

// Lines of the table by family: an arm against the best peer that ran, or against one that did not.
export interface FamilyLine { ours: string; threads: number; published: string }

export function familyLines(ratios: Ratio[]): FamilyLine[] {
  const lines = new Map<string, FamilyLine>();
  for (const ratio of ratios) {
    const published = isPublished(ratio) ? ratio.other : '';
    lines.set(`${ratio.ours}|${ratio.threads}|${published}`, { ours: ratio.ours, threads: ratio.threads, published });
  }
  return [...lines.values()].sort((a, b) => FAMILIES.indexOf(a.ours) - FAMILIES.indexOf(b.ours));
}
