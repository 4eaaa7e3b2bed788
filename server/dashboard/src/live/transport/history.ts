// Reads the history of scenes, builds and sessions from the daemon while a view shows it.
import { useEffect, useState } from 'preact/hooks';
import { HistoryService, type HistoryKind, type HistorySeries } from '../../gen/sweepstake/v1/history_pb';
import { pausedMs, period, type Period, periodKey, PERIODS, range, timesOf } from '../charts/view_state';
import type { SceneName } from '../state/scenes';
import { type ApiError, asApiError, call } from './calls';

export interface HistorySelection { kind: HistoryKind; project?: string; scene?: string; machineClass?: string; rewardVersion?: number; sessionId?: string }

/** Selects the history of a scene or of its builds. */
export const selectionOf = (kind: HistoryKind, { project, scene, machineClass, rewardVersion }: SceneName): HistorySelection =>
  ({ kind, project, scene, machineClass, rewardVersion });

export interface HistoryReading {
  series: readonly HistorySeries[];
  wasRead: boolean; // whether the history was read once
  error?: ApiError;
}

interface Options {
  maxPoints: number; // per series; 1: the sum over the period
  period?: Period; // instead of the period of the view
  everyMs?: number;
}

/** Reads one point per series, with everything that was ever measured. */
export const WHOLE_LIFE: Options = { maxPoints: 1, period: PERIODS.at(-1)!, everyMs: 60_000 };

const STEP_MS = 15_000; // the daemon's finest points
const MAX_SERIES = 2_000;

async function readAll(selection: HistorySelection, { maxPoints, period: own }: Options): Promise<HistorySeries[]> {
  const times = own ? timesOf(own, undefined, Date.now()) : timesOf(period.peek(), range.peek(), Date.now());
  const all: HistorySeries[] = [];
  let pageToken = '';
  do {
    const page = await call(HistoryService.method.getHistory,
      { ...selection, maxPoints, pageToken, fromUnixMs: BigInt(times.fromUnixMs), untilUnixMs: BigInt(times.untilUnixMs) });
    all.push(...page.series);
    pageToken = page.nextPageToken;
  } while (pageToken && all.length < MAX_SERIES);
  return all;
}

/** Returns the selected series in the period of the view. Reads them again while time passes, unless the view is paused. */
export function useHistory(selection: HistorySelection, options: Options): HistoryReading {
  const { everyMs = STEP_MS } = options;
  const key = JSON.stringify([selection, options, options.period ? '' : periodKey.value]);
  const [{ of, ...reading }, setReading] = useState<HistoryReading & { of: string }>({ of: '', series: [], wasRead: false });
  useEffect(() => {
    let isOver = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const later = () => { timer = setTimeout(document.hidden || pausedMs.peek() !== undefined ? later : () => void read(), everyMs); };
    const read = async () => {
      const next = await readAll(selection, options).then((series) => ({ series, wasRead: true }), (error: unknown) => ({ error: asApiError(error) }));
      if (isOver) return;
      setReading(({ series, wasRead }) => ({ of: key, series, wasRead, ...next }));
      later();
    };
    void read();
    return () => {
      isOver = true;
      clearTimeout(timer);
    };
  }, [key]);
  return of === key ? reading : { ...reading, wasRead: false };
}
