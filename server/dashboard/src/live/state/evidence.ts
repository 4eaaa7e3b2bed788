// What the daemon has learnt and from whom, for as long as its view is open. The records of an export are summed as they come, so that
// many sources take little memory.
import type { ExportPriorsResponse, PriorRecord } from '../../gen/sweepstake/v1/priors_pb';

export const MAX_SOURCES = 20_000;
export const MAX_KEPT_RECORDS = 200_000;  // a file of more cannot be imported

// What all sources of one scene, class of machines, version of the reward, arm and backend, and lane or frame thread taught.
export interface EvidenceSum {
  key: string;
  example: PriorRecord;  // has the names
  sourceCount: number;
  alpha: number;
  beta: number;
  windowCount: number;
  bailOutCount: number;
}

// What one source taught.
export interface SourceSum {
  sourceId: string;
  project: string;
  scenes: Set<string>;
  arms: Set<string>;
  windowCount: number;
  bailOutCount: number;
}

export interface Evidence {
  sums: Map<string, EvidenceSum>;
  sources: Map<string, SourceSum>;  // up to MAX_SOURCES
  records: PriorRecord[];  // up to MAX_KEPT_RECORDS
  recordCount: number;
  foldedRecordCount: number;
  foldedWindowCount: number;
}

export const noEvidence = (): Evidence =>
  ({ sums: new Map(), sources: new Map(), records: [], recordCount: 0, foldedRecordCount: 0, foldedWindowCount: 0 });

const keyOf = (record: PriorRecord) => [record.project, record.scene, record.machineClass, record.rewardVersion, record.arm,
  record.backendVersion, record.measuredBy].join('\n');

function sumFor(sums: Map<string, EvidenceSum>, record: PriorRecord): EvidenceSum {
  const key = keyOf(record);
  const known = sums.get(key);
  if (known) return known;
  const sum = { key, example: record, sourceCount: 0, alpha: 0, beta: 0, windowCount: 0, bailOutCount: 0 };
  sums.set(key, sum);
  return sum;
}

function sourceFor(sources: Map<string, SourceSum>, { sourceId, project }: PriorRecord): SourceSum | undefined {
  const known = sources.get(sourceId);
  if (known || sources.size >= MAX_SOURCES) return known;
  const source = { sourceId, project, scenes: new Set<string>(), arms: new Set<string>(), windowCount: 0, bailOutCount: 0 };
  sources.set(sourceId, source);
  return source;
}

function add(evidence: Evidence, record: PriorRecord): void {
  const sum = sumFor(evidence.sums, record);
  ++sum.sourceCount;
  sum.alpha += record.alphaIncrement;
  sum.beta += record.betaIncrement;
  const source = sourceFor(evidence.sources, record);
  source?.scenes.add(record.scene);
  source?.arms.add(record.arm);
  for (const each of source ? [sum, source] : [sum]) {
    each.windowCount += Number(record.windowCount);
    each.bailOutCount += Number(record.bailOutCount);
  }
}

export function addPart(evidence: Evidence, { records, foldedRecordCount, foldedWindowCount }: ExportPriorsResponse): void {
  for (const record of records) add(evidence, record);
  evidence.records.push(...records.slice(0, MAX_KEPT_RECORDS - evidence.records.length));
  evidence.recordCount += records.length;
  evidence.foldedRecordCount += Number(foldedRecordCount);
  evidence.foldedWindowCount += Number(foldedWindowCount);
}

// The file that `sweepstake priors import` and a game read.
export function priorsFile(records: readonly PriorRecord[]): string {
  const written = records.map((record) => ({
    project: record.project, scene: record.scene, measured_by: record.measuredBy, arm: record.arm, backend_version: record.backendVersion,
    machine_class: record.machineClass, reward_version: record.rewardVersion, source_id: record.sourceId,
    source_sequence: Number(record.sourceSequence), alpha_increment: record.alphaIncrement, beta_increment: record.betaIncrement,
    window_count: Number(record.windowCount), bail_out_count: Number(record.bailOutCount), build: record.build,
    unix_last_seen_s: Number(record.unixLastSeenS),
  }));
  return `${JSON.stringify({ format: 'sweepstake-priors', version: 1, records: written }, null, 1)}\n`;
}
