// A hook that reads something from the daemon while a component is shown.
import { useEffect, useState } from 'preact/hooks';
import { type ApiError, asApiError, jsonOf, stream } from './calls';
import type { Init, Streaming } from './messages';

export interface Reading<Value> {
  value?: Value; // the result; while reading and after an error, the latest value passed to `show`
  error?: ApiError;
  isReading: boolean;
  atMs: number; // time at which the reading was complete, by the browser's clock
  again: () => void;
}

/** Reads again whenever `key` changes, and when `again` is called. `read` may pass parts of the value to `show`. */
export function useReading<Value>(key: unknown, read: (cancel: AbortSignal, show: (value: Value) => void) => Promise<Value>): Reading<Value> {
  const begun: Omit<Reading<Value>, 'again'> = { isReading: true, atMs: 0 };
  const [{ of, reading }, setReading] = useState({ of: key, reading: begun });
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const cancel = new AbortController();
    let latest = begun;
    const set = (next: Partial<Reading<Value>>) => {
      latest = { ...latest, ...next };
      if (!cancel.signal.aborted) setReading({ of: key, reading: latest });
    };
    set({});
    read(cancel.signal, (value) => set({ value })).then(
      (value) => set({ value, isReading: false, atMs: Date.now() }),
      (error: unknown) => set({ error: asApiError(error), isReading: false }));
    return () => cancel.abort();
  }, [key, turn]);
  return { ...(of === key ? reading : begun), again: () => setTurn((before) => before + 1) };
}

/** Reads all messages of an RPC that answers with a finite stream. */
export function useList<Request, Response>(method: Streaming<Request, Response>, request: NoInfer<Init<Request>>): Reading<Response[]> {
  return useReading(method.path + jsonOf(method.input, request), async (cancel) => {
    const all: Response[] = [];
    for await (const message of stream(method, request, cancel)) all.push(message);
    return all;
  });
}
