// Compares the builds of a game: frame time, detection time and memory, from the decisions received since the page was opened.
import { useComputed } from '@preact/signals';
import { bytes, significant } from '../../../format';
import type { SessionInfo } from '../../../gen/sweepstake/v1/sessions_pb';
import { bucketsOf, type Buckets, countOf, type LogHistogram, merged, type Percentiles, percentiles } from '../../numbers/histogram';
import { type Column, Table } from '../../parts/table';
import type { SceneName } from '../../state/scenes';
import { isConnected, sessions, type SessionState } from '../../state/sessions';

export interface BuildRow {
  build: string; // '': unknown
  sessionCount: number;
  onlineCount: number;
  droppedCount: number;
  frameCount: number; // frames in the percentiles
  frameNs: Percentiles | undefined;
  detectionNs: Percentiles | undefined;
  nativeBytes: Percentiles | undefined;
}

type Part = 'frameTimeNs' | 'detectionTimeNs' | 'nativeBytes';

function bucketsIn(all: readonly SessionState[], part: Part): Buckets {
  const histograms = all.flatMap(({ decisions }) => decisions.map(({ measurements }) => measurements?.[part]));
  return merged(histograms.filter((each): each is NonNullable<typeof each> => each !== undefined).map((each: LogHistogram) => bucketsOf(each)));
}

export function buildRows(all: readonly SessionState[]): BuildRow[] {
  return [...new Set(all.map(({ info }) => info.build))].map((build) => {
    const own = all.filter(({ info }) => info.build === build);
    const frames = bucketsIn(own, 'frameTimeNs');
    return {
      build,
      sessionCount: own.length,
      onlineCount: own.filter(isConnected).length,
      droppedCount: own.reduce((sum, { info }) => sum + Number(info.droppedFrameCount), 0),
      frameCount: countOf(frames),
      frameNs: percentiles(frames),
      detectionNs: percentiles(bucketsIn(own, 'detectionTimeNs')),
      nativeBytes: percentiles(bucketsIn(own, 'nativeBytes')),
    };
  });
}

/** Returns when the first session of each build began. */
export function buildStarts(all: readonly SessionInfo[]): { build: string; fromMs: number }[] {
  const starts = new Map<string, number>();
  for (const { build, unixStartMs } of all) {
    if (build) starts.set(build, Math.min(starts.get(build) ?? Number.POSITIVE_INFINITY, Number(unixStartMs)));
  }
  return [...starts].map(([build, fromMs]) => ({ build, fromMs })).sort((a, b) => a.fromMs - b.fromMs || a.build.localeCompare(b.build));
}

const ms = (ns: number) => `${significant(ns / 1e6)} ms`;
const PLACES = [['p50', 0], ['p95', 1], ['p99', 2]] as const;
const three = (id: string, title: string, values: (row: BuildRow) => Percentiles | undefined, text: (value: number) => string): Column<BuildRow>[] =>
  PLACES.map(([name, place]) => ({
    id: `${id}-${name}`, title: `${title} ${name}`, sort: (row: BuildRow) => values(row)?.[place],
    cell: (row: BuildRow) => { const value = values(row)?.[place]; return value === undefined ? '–' : text(value); },
  }));

const COLUMNS: readonly Column<BuildRow>[] = [
  { id: 'build', title: 'Build', sort: ({ build }) => build },
  { id: 'sessions', title: 'Sessions', sort: ({ sessionCount }) => sessionCount, cell: ({ sessionCount, onlineCount }) => `${sessionCount}, ${onlineCount} online` },
  ...three('frame', 'Frame', ({ frameNs }) => frameNs, ms),
  ...three('detection', 'Detection', ({ detectionNs }) => detectionNs, ms),
  ...three('memory', 'Memory', ({ nativeBytes }) => nativeBytes, bytes).slice(1, 2),
  { id: 'frames', title: 'Frames', hint: 'Number of frames in the percentiles', sort: ({ frameCount }) => frameCount },
  { id: 'dropped', title: 'Dropped', hint: 'Frames that games measured but could not send', sort: ({ droppedCount }) => droppedCount },
];

export function Builds({ name: { project, scene } }: { name: SceneName }) {
  const own = useComputed(() => [...sessions.value.values()].filter(({ info }) => info.project === project && info.scene === scene)).value;
  if (own.length === 0) return <p class="soft">The daemon has no session of this scene in memory.</p>;
  return <Table caption="Builds" columns={COLUMNS} rows={buildRows(own)} keyOf={({ build }) => build} sort="build" sortParameter="builds" />;
}
