// A hook that reads something from the daemon while a component is shown.
import { useEffect, useState } from 'preact/hooks';
import { type ApiError, asApiError, jsonOf, stream } from './calls';
import type { Init, Streaming } from './messages';

export interface Reading<Value> {
  value?: Value;
  error?: ApiError;
  isReading: boolean;
  atMs: number; // time at which the reading was complete, by the browser's clock
  again: () => void;
}

const BEGUN = { isReading: true, atMs: 0 };

/** Reads again whenever `key` changes, and when `again` is called. Until the answer there is no value. */
export function useReading<Value>(key: unknown, read: (cancel: AbortSignal) => Promise<Value>): Reading<Value> {
  const [turn, setTurn] = useState(0);
  const [last, setLast] = useState<{ key: unknown; turn: number; reading: Omit<Reading<Value>, 'again'> }>({ key, turn, reading: BEGUN });
  useEffect(() => {
    const cancel = new AbortController();
    const set = (end: Pick<Reading<Value>, 'value' | 'error'>) => {
      if (!cancel.signal.aborted) setLast({ key, turn, reading: { isReading: false, atMs: Date.now(), ...end } });
    };
    read(cancel.signal).then((value) => set({ value }), (error: unknown) => set({ error: asApiError(error) }));
    return () => cancel.abort();
  }, [key, turn]);
  const isLatest = last.key === key && last.turn === turn;
  return { ...(isLatest ? last.reading : BEGUN), again: () => setTurn((before) => before + 1) };
}

/** Reads all messages of an RPC that answers with a finite stream. */
export function useList<Request, Response>(method: Streaming<Request, Response>, request: NoInfer<Init<Request>>): Reading<Response[]> {
  return useReading(method.path + jsonOf(method.input, request), async (cancel) => {
    const all: Response[] = [];
    for await (const message of stream(method, request, cancel)) all.push(message);
    return all;
  });
}
