// The daemon's evidence, while the view of the priors is open. The tables show it in groups: by scene and arm, by source, by build.
import type { PriorRecord } from '../../gen/sweepstake/v1/priors_pb';

export const MAX_RECORDS = 200_000;  // the largest file that `sweepstake priors import` accepts

// Some records, and their sums.
export interface Group {
  key: string;
  example: PriorRecord;  // one of the records, for the fields that are equal in all of them
  sourceIds: Set<string>;
  scenes: Set<string>;
  arms: Set<string>;
  machineClasses: Set<string>;
  windowCount: number;
  bailOutCount: number;
  alpha: number;
  beta: number;
  weight: number;  // the highest weight of a record
  lastSeenS: number;  // by the daemon's clock; 0: unknown
}

const emptyGroup = (key: string, example: PriorRecord): Group => ({ key, example, sourceIds: new Set(), scenes: new Set(), arms: new Set(),
  machineClasses: new Set(), windowCount: 0, bailOutCount: 0, alpha: 0, beta: 0, weight: 0, lastSeenS: 0 });

function add(group: Group, record: PriorRecord): void {
  group.sourceIds.add(record.sourceId);
  group.scenes.add(record.scene);
  group.arms.add(record.arm);
  group.machineClasses.add(record.machineClass);
  group.windowCount += Number(record.windowCount);
  group.bailOutCount += Number(record.bailOutCount);
  group.alpha += record.alphaIncrement;
  group.beta += record.betaIncrement;
  group.weight = Math.max(group.weight, record.weight);
  group.lastSeenS = Math.max(group.lastSeenS, Number(record.unixLastSeenS));
}

// Returns the groups of the records that are equal in these fields.
export function groupsOf(records: readonly PriorRecord[], ...fields: readonly (keyof PriorRecord)[]): Group[] {
  const groups = new Map<string, Group>();
  for (const record of records) {
    const key = fields.map((field) => record[field]).join('\n');
    const group = groups.get(key) ?? emptyGroup(key, record);
    groups.set(key, group);
    add(group, record);
  }
  return [...groups.values()];
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
