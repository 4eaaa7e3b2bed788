// The rows of the audit log (engine_client/decider/audit/audit_log.h), as the page reads them.
import { parseRecord } from '../numbers/csv';

/** The columns that the page reads. */
export type Column =
  | 'session' | 'segment' | 'row' | 'kind' | 'time_ns' | 'setup' | 'runs' | 'frame' | 'shadow' | 'descriptor' | 'arm' | 'reason'
  | 'rebuild_time_ns' | 'settling_cost_ns' | 'mode' | 'decision_id' | 'policy' | 'reward_version' | 'seed' | 'active_arm' | 'candidate'
  | 'outcome' | 'reward' | 'increment_arm' | 'increment_alpha' | 'increment_beta' | 'alpha' | 'beta' | 'draws' | 'best_probability'
  | 'leader' | 'expected_loss_ratio' | 'verdict' | 'gain' | 'loss' | 'horizon_s' | 'cooldown_s' | 'switch_cost_s' | 'propensity';

/** A row whose cells are found by the names of the file's header. A cell that is not there, or a column that is not, is empty. */
export class AuditRow {
  private readonly lists = new Map<Column, readonly number[]>(); // those that were asked for

  constructor(private readonly places: ReadonlyMap<string, number>, private readonly cells: readonly string[]) {}

  text(column: Column): string {
    return this.cells[this.places.get(column) ?? -1] ?? '';
  }
  /** Undefined: empty, or no number. */
  number(column: Column): number | undefined {
    const value = Number(this.text(column) || Number.NaN);
    return Number.isNaN(value) ? undefined : value;
  }
  /** A list of numbers, empty where there is none. */
  numbers(column: Column): readonly number[] {
    const known = this.lists.get(column) ?? items(this.text(column)).map(Number);
    this.lists.set(column, known);
    return known;
  }
  /** All that the row says: a name and a text per cell that is not empty. */
  entries(): [name: string, text: string][] {
    return [...this.places].map(([name, place]): [string, string] => [name, this.cells[place] ?? '']).filter(([, text]) => text !== '');
  }
  /** Names the row within the log. */
  get id(): string {
    return `${this.text('session')}.${this.text('segment')}.${this.text('row')}`;
  }
}

const items = (text: string) => (text === '' ? [] : text.split(' '));

/** Reads rows after the header. A row that is no CSV is left out and counted. */
export class RowReader {
  private places: ReadonlyMap<string, number> = new Map();
  unreadableCount = 0;

  header(line: string): void {
    this.places = new Map((parseRecord(line) ?? []).map((name, place): [string, number] => [name, place]));
  }
  row(record: string): AuditRow | undefined {
    const cells = parseRecord(record);
    if (!cells) ++this.unreadableCount;
    return cells && new AuditRow(this.places, cells);
  }
}

/** Splits at separators that have no backslash before them, and takes the backslashes away. */
function splitEscaped(text: string, separator: string, unescape: boolean): string[] {
  const parts: string[] = [];
  let part = '';
  for (let i = 0; i < text.length; ++i) {
    if (text[i] === '\\' && i + 1 < text.length) part += (unescape ? '' : '\\') + text[++i];
    else if (text[i] === separator) {
      parts.push(part);
      part = '';
    } else part += text[i];
  }
  return [...parts, part];
}

/** What the row of kind `setup` says; of unknown keys nothing. */
export interface Setup {
  project: string;
  scene: string;
  machineClass: string;
  unixStartMs: number; // 0: unknown
  startNs: number;
  arms: string[];
  policy: string;
  mode: string;
  activeArm: string;
  decisionIntervalMs: number;
  cooldownMs: number;
  settlingMs: number;
  bailOutMs: number;
  priors: { alpha: number; beta: number }[]; // one per arm, or none: Beta(1,1)
}

const NS_PER_MS = 1e6;

/** Returns the parts of a setup's cell as they were written. */
export const setupParts = (cell: string): string[] => splitEscaped(cell, ';', true);

/** Returns the pairs of a setup's cell. */
export function setupPairs(cell: string): Map<string, string> {
  return new Map(splitEscaped(cell, ';', false).map((pair): [string, string] => {
    const equals = pair.indexOf('=');
    return equals < 0 ? [pair, ''] : [pair.slice(0, equals), pair.slice(equals + 1)];
  }));
}

export function setupOf(row: AuditRow): Setup {
  const pairs = setupPairs(row.text('setup'));
  const list = (key: string) => (pairs.get(key) ? splitEscaped(pairs.get(key)!, ',', true) : []);
  const text = (key: string) => splitEscaped(pairs.get(key) ?? '', ',', true).join(',');
  const ms = (key: string) => Number(pairs.get(key) ?? 0) / NS_PER_MS;
  const arms = list('arms');
  return {
    project: text('project'),
    scene: text('scene'),
    machineClass: text('machine_class'),
    unixStartMs: Number(pairs.get('unix_start_ms') ?? 0),
    startNs: Number(pairs.get('start_ns') ?? 0),
    arms,
    policy: text('policy'),
    mode: text('mode'),
    activeArm: arms[Number(pairs.get('active_arm') ?? 0)] ?? '',
    decisionIntervalMs: ms('decision_interval_ns'),
    cooldownMs: ms('cooldown_ns'),
    settlingMs: ms('settling_ns'),
    bailOutMs: ms('bail_out_ns'),
    priors: list('priors').map((item) => {
      const [alpha = 1, beta = 1] = item.split(':').map(Number);
      return { alpha, beta };
    }),
  };
}

/** When something was, by the daemon's wall clock at the segment's start and its steady clock since. */
export const unixMsOf = (setup: Setup, timeNs: number) => setup.unixStartMs + (timeNs - setup.startNs) / NS_PER_MS;

/** The same function, which computes each answer once: views ask for those of all rows whenever one is added. */
export function once<Of extends object, Answer>(compute: (of: Of) => Answer): (of: Of) => Answer {
  const known = new WeakMap<Of, { answer: Answer }>();
  return (of) => {
    const before = known.get(of) ?? { answer: compute(of) };
    known.set(of, before);
    return before.answer;
  };
}

/** What the frames of a decision window cost, as the `runs` cell of a tick sums them. */
export interface WindowMeans {
  frameCount: number;
  frameMs: number; // mean
  detectionMs: number; // mean of those frames that did not rebuild
  checkCount: number; // mean per frame
  nativeBytes: number; // peak
}

// Where these members are in the cell's second item: those of ArmRun, then those of its Window.
const FRAMES = 7;
const ORDINARY_FRAMES = 8;
const TIME_NS = 9;
const DETECTION_NS = 10;
const CHECKS = 16;
const PEAK_BYTES = 18;
const MEMBERS = 19;

/** Undefined: the window has no frames. */
export const windowOf = once((row: AuditRow): WindowMeans | undefined => {
  const run = items(row.text('runs'))[1]?.split(':').map(Number);
  const frameCount = run?.[FRAMES] ?? 0;
  if (!run || run.length !== MEMBERS || frameCount === 0) return undefined;
  return {
    frameCount,
    frameMs: run[TIME_NS]! / frameCount / NS_PER_MS,
    detectionMs: run[ORDINARY_FRAMES]! > 0 ? run[DETECTION_NS]! / run[ORDINARY_FRAMES]! / NS_PER_MS : Number.NaN,
    checkCount: run[CHECKS]! / frameCount,
    nativeBytes: run[PEAK_BYTES]!,
  };
});

/** One visit of the shadow lane. */
export interface Visit { arm: number; detectionNs: number; buildNs: number; wasActive: boolean; wasCapped: boolean }

/** Returns the visits that the lane reported since the row before. */
export const visitsOf = once((row: AuditRow): readonly Visit[] => items(row.text('shadow')).map((item) => {
  const [, detectionNs = 0, buildNs = 0, , , arm = 0, , , flags = 0] = item.split(':').map(Number);
  return { arm, detectionNs, buildNs, wasActive: (flags & 1) !== 0, wasCapped: (flags & 2) !== 0 };
}));

/** Objects in the broad phase. Undefined: not measured. */
export const objectCountOf = once((row: AuditRow): number | undefined => {
  const count = row.text('descriptor').split(':')[0];
  return count ? Number(count) : undefined;
});
