// The daemon's evidence by scene, arm, source and build, while the view of the priors is open. The records of an export are summed as
// they arrive, so that many sources need little memory.
import type { ExportPriorsResponse, PriorRecord } from '../../gen/sweepstake/v1/priors_pb';

export const MAX_SOURCES = 20_000;
const MAX_SUMS = 50_000;
const MAX_KEPT_RECORDS = 200_000;  // the largest file that `sweepstake priors import` accepts

interface Counts {
  windowCount: number;
  bailOutCount: number;
}

// The evidence of all sources of one build about one scene, class of machines, version of the reward, arm and backend, measured either
// on the frame thread or in the shadow lane.
export interface EvidenceSum extends Counts {
  key: string;
  example: PriorRecord;  // one of the records, for the names
  sourceCount: number;
  alpha: number;
  beta: number;
}

interface Teacher extends Counts {
  project: string;
  build: string;  // '': unknown
  scenes: Set<string>;
  arms: Set<string>;
  machineClasses: Set<string>;
  lastSeenS: number;  // by the daemon's clock; 0: unknown
}

// The evidence of one source.
export interface SourceSum extends Teacher {
  sourceId: string;
  isImported: boolean;
  weight: number;  // the highest of its records' weights
}

// The evidence of the sources of one build of a project.
export interface BuildSum extends Teacher {
  key: string;
  sourceIds: Set<string>;
}

export interface Evidence {
  sums: Map<string, EvidenceSum>;  // up to MAX_SUMS
  sources: Map<string, SourceSum>;  // up to MAX_SOURCES
  builds: Map<string, BuildSum>;  // sums over `sources`
  waiting: Map<string, BuildSum>;  // quarantined evidence by build, which no prior uses; up to MAX_SOURCES
  waitingCount: number;  // number of quarantined records
  records: PriorRecord[];  // up to MAX_KEPT_RECORDS
  isCut: boolean;  // records were left out because a bound was reached
  recordCount: number;  // number of records that are not in quarantine
}

export const noEvidence = (): Evidence => ({ sums: new Map(), sources: new Map(), builds: new Map(), waiting: new Map(), waitingCount: 0, records: [], isCut: false,
  recordCount: 0 });

const keyOf = (record: PriorRecord) => [record.project, record.scene, record.machineClass, record.rewardVersion, record.build, record.arm,
  record.backendVersion, record.measuredBy].join('\n');

// Returns the value at the key, creating it unless the map has `max` entries already.
function entry<Value>(map: Map<string, Value>, key: string, max: number, make: () => Value): Value | undefined {
  const known = map.get(key);
  if (known || map.size >= max) return known;
  const made = make();
  map.set(key, made);
  return made;
}

const noCounts = () => ({ windowCount: 0, bailOutCount: 0 });
const teacher = ({ project, build }: PriorRecord): Teacher =>
  ({ project, build, scenes: new Set(), arms: new Set(), machineClasses: new Set(), lastSeenS: 0, ...noCounts() });

function learn(from: Teacher, { scene, arm, machineClass, unixLastSeenS }: PriorRecord): void {
  from.scenes.add(scene);
  from.arms.add(arm);
  from.machineClasses.add(machineClass);
  from.lastSeenS = Math.max(from.lastSeenS, Number(unixLastSeenS));
}

function count(counts: Counts, { windowCount, bailOutCount }: PriorRecord): void {
  counts.windowCount += Number(windowCount);
  counts.bailOutCount += Number(bailOutCount);
}

const buildKeyOf = ({ project, build }: PriorRecord) => `${project}\n${build}`;
const buildSum = (key: string, record: PriorRecord): BuildSum => ({ key, sourceIds: new Set(), ...teacher(record) });

function addWaiting(evidence: Evidence, record: PriorRecord): void {
  const key = buildKeyOf(record);
  const build = entry(evidence.waiting, key, MAX_SOURCES, () => buildSum(key, record));
  evidence.isCut ||= !build;
  if (!build) return;
  build.sourceIds.add(record.sourceId);
  learn(build, record);
  count(build, record);
}

function add(evidence: Evidence, record: PriorRecord): void {
  const { sourceId, isImported } = record;
  const key = keyOf(record);
  const sum = entry(evidence.sums, key, MAX_SUMS, () => ({ key, example: record, sourceCount: 0, alpha: 0, beta: 0, ...noCounts() }));
  if (sum) {
    ++sum.sourceCount;
    sum.alpha += record.alphaIncrement;
    sum.beta += record.betaIncrement;
  }
  const source = entry(evidence.sources, sourceId, MAX_SOURCES, () => ({ sourceId, isImported, weight: 0, ...teacher(record) }));
  if (source) source.weight = Math.max(source.weight, record.weight);
  const buildKey = buildKeyOf(record);
  const build = source && entry(evidence.builds, buildKey, MAX_SOURCES, () => buildSum(buildKey, record));
  build?.sourceIds.add(sourceId);
  for (const each of [source, build]) if (each) learn(each, record);
  for (const each of [sum, source, build]) {
    if (each) count(each, record);
  }
  evidence.isCut ||= !sum || !source;
}

export function addPart(evidence: Evidence, { records }: ExportPriorsResponse): void {
  const waiting = records.filter(({ isQuarantined }) => isQuarantined);
  for (const record of records) (record.isQuarantined ? addWaiting : add)(evidence, record);
  const kept = records.slice(0, MAX_KEPT_RECORDS - evidence.records.length);
  evidence.records.push(...kept);
  evidence.isCut ||= kept.length < records.length;
  evidence.recordCount += records.length - waiting.length;
  evidence.waitingCount += waiting.length;
}

// Returns a file that `sweepstake priors import` and games can read.
export function priorsFile(records: readonly PriorRecord[]): string {
  const written = records.map((record) => ({
    project: record.project, scene: record.scene, measured_by: record.measuredBy, arm: record.arm, backend_version: record.backendVersion,
    machine_class: record.machineClass, reward_version: record.rewardVersion, source_id: record.sourceId,
    source_sequence: Number(record.sourceSequence), alpha_increment: record.alphaIncrement, beta_increment: record.betaIncrement,
    window_count: Number(record.windowCount), bail_out_count: Number(record.bailOutCount), build: record.build,
    unix_last_seen_s: Number(record.unixLastSeenS), ...(record.isQuarantined ? { is_quarantined: true } : {}),
  }));
  return `${JSON.stringify({ format: 'sweepstake-priors', version: 1, records: written }, null, 1)}\n`;
}
