// The daemon's evidence, while the view of the priors is open. The tables show it in groups: by scene and arm, by source, by build.
import type { PriorRecord } from '../../gen/sweepstake/v1/priors_pb';
import { once } from './once';
import { groupedBy } from './scenes';

export const MAX_RECORDS = 200_000;  // maximum number of records that `sweepstake priors import` accepts

// Records that are equal in some fields. `example` is one of the records, from which these fields are read.
export interface Group { key: string; example: PriorRecord; records: readonly PriorRecord[] }

export const groupsOf = (records: readonly PriorRecord[], ...fields: readonly (keyof PriorRecord)[]): Group[] =>
  [...groupedBy(records, (record) => fields.map((field) => record[field]).join('\n'))].map(([key, own]) => ({ key, example: own[0]!, records: own }));

// sumOf, mostOf and namesOf return functions of a group: the sum of a field, its highest value, and its distinct values.
export const sumOf = (field: 'windowCount' | 'bailOutCount' | 'alphaIncrement' | 'betaIncrement') =>
  once(({ records }: Group) => records.reduce((sum, record) => sum + Number(record[field]), 0));
export const mostOf = (field: 'weight' | 'unixLastSeenS') =>
  once(({ records }: Group) => records.reduce((most, record) => Math.max(most, Number(record[field])), 0));
export const namesOf = (field: 'sourceId' | 'scene' | 'arm' | 'machineClass') =>
  once(({ records }: Group) => [...new Set(records.map((record) => record[field]))]);

// Returns a file that `sweepstake priors import` and games can read.
export function priorsFile(records: readonly PriorRecord[]): string {
  const written = records.map((record) => ({
    project: record.project, scene: record.scene, measured_by: record.measuredBy, arm: record.arm, backend_version: record.backendVersion,
    machine_class: record.machineClass, reward_version: record.rewardVersion, source_id: record.sourceId,
    source_sequence: Number(record.sourceSequence), alpha_increment: record.alphaIncrement, beta_increment: record.betaIncrement,
    window_count: Number(record.windowCount), bail_out_count: Number(record.bailOutCount), build: record.build,
    unix_last_seen_s: Number(record.unixLastSeenS), ...(record.regime ? { regime: record.regime } : {}), ...(record.isQuarantined ? { is_quarantined: true } : {}),
  }));
  return `${JSON.stringify({ format: 'sweepstake-priors', version: 1, records: written }, null, 1)}\n`;
}
