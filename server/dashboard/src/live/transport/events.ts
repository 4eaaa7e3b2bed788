// Follows an RPC that does not end, over server-sent events, for as long as the page is open: what was missed while the connection
// was away comes afterwards, or a new snapshot does. The events are read with fetch and not with EventSource, which neither says why a
// daemon refused nor lets on that it is alive.
import type { DescMessage, DescMethodServerStreaming, MessageInitShape, MessageShape } from '@bufbuild/protobuf';
import { type ApiError, asApiError, HEADERS, errorOfResponse, jsonOf, linesOf, messageOf, parseError, pathOf } from './calls';

const FIRST_DELAY_MS = 500;
const MAX_DELAY_MS = 30_000;
const MAX_SILENCE_MS = 40_000;  // the daemon says something at least every 15 s

export type LinkStatus = 'connecting' | 'live' | 'offline' | 'denied';

export interface Listener<Message> {
  // What follows is all there is, up to snapshotEnded; what was known before and is not in it is gone.
  snapshotBegan(): void;
  message(message: Message): void;
  snapshotEnded(): void;
  status(status: LinkStatus, error?: ApiError): void;
  // The daemon said something, if only that it is there.
  heard(): void;
}

interface ServerEvent {
  name: string;
  id: string | undefined;
  data: string;
}

// The events of a stream; undefined for a comment, which is a sign of life.
export async function* eventsOf(lines: AsyncIterable<string>): AsyncGenerator<ServerEvent | undefined> {
  let event: ServerEvent = { name: 'message', id: undefined, data: '' };
  for await (const line of lines) {
    const text = line.endsWith('\r') ? line.slice(0, -1) : line;
    if (text === '') {
      if (event.data || event.id !== undefined) yield event;
      event = { name: 'message', id: undefined, data: '' };
      continue;
    }
    const colon = text.indexOf(':');
    const field = colon < 0 ? text : text.slice(0, colon);
    const value = colon < 0 ? '' : text.slice(colon + 1).replace(/^ /, '');
    if (field === '') yield undefined;
    else if (field === 'event') event.name = value;
    else if (field === 'id') event.id = value;
    else if (field === 'data') event.data += event.data ? `\n${value}` : value;
  }
}

// Twice as long after each failure, and by chance, so that a thousand pages do not come back at the same moment.
export const delayAfter = (failures: number, random: number) =>
  Math.min(MAX_DELAY_MS, FIRST_DELAY_MS * 2 ** Math.min(failures, 10)) * (0.5 + 0.5 * random);

export class Watch<Input extends DescMessage, Output extends DescMessage> {
  private lastId = '';  // what to go on after; empty: begin with a snapshot
  private isWhole = false;  // no part of a snapshot is missing
  private failures = 0;
  private attempt: AbortController | undefined;
  private isClosed = false;
  private wake: () => void = () => undefined;

  constructor(
    private readonly method: DescMethodServerStreaming<Input, Output>,
    private readonly request: MessageInitShape<Input>,
    private readonly listener: Listener<MessageShape<Output>>,
  ) {
    void this.run();
  }

  // Connects now if it is waiting to, as after a login.
  retry(): void {
    this.wake();
  }

  close(): void {
    this.isClosed = true;
    this.attempt?.abort();
    this.wake();
  }

  private async run(): Promise<void> {
    this.listener.status('connecting');
    while (!this.isClosed) {
      const error = await this.listen().catch(asApiError);
      if (this.isClosed) return;
      const isDenied = error.needsLogin || error.code === 'PERMISSION_DENIED';
      this.listener.status(isDenied ? 'denied' : 'offline', error);
      await this.pause(isDenied ? MAX_DELAY_MS : delayAfter(this.failures++, Math.random()));
    }
  }

  private pause(ms: number): Promise<void> {
    return new Promise((resolve) => {
      const timer = setTimeout(resolve, ms);
      this.wake = () => {
        clearTimeout(timer);
        resolve();
      };
    });
  }

  // Returns why it ended.
  private async listen(): Promise<ApiError> {
    const attempt = new AbortController();
    this.attempt = attempt;
    let silence = setTimeout(() => attempt.abort(), MAX_SILENCE_MS);
    try {
      const response = await fetch(this.url(), { signal: attempt.signal, cache: 'no-store',
        headers: { ...HEADERS, Accept: 'text/event-stream', ...(this.lastId && { 'Last-Event-ID': this.lastId }) } });
      if (!response.ok) throw await errorOfResponse(response);
      this.listener.status('live');
      for await (const event of eventsOf(linesOf(response.body!))) {
        clearTimeout(silence);
        silence = setTimeout(() => attempt.abort(), MAX_SILENCE_MS);
        this.listener.heard();
        if (event) this.take(event);
        if (this.isWhole) this.failures = 0;  // not before: a snapshot that never ends is not to be asked for again and again
      }
      return asApiError(undefined);
    } finally {
      clearTimeout(silence);
      attempt.abort();
    }
  }

  private url(): string {
    return `/events/${pathOf(this.method)}?request=${encodeURIComponent(jsonOf(this.method.input, this.request))}`;
  }

  private take({ name, id, data }: ServerEvent): void {
    if (name === 'error') throw parseError(data, 'the daemon ended the stream');
    if (name === 'snapshot-begin') {
      this.isWhole = false;
      this.lastId = '';
      this.listener.snapshotBegan();
    } else if (name === 'snapshot-end') {
      this.isWhole = true;
      this.listener.snapshotEnded();
    } else if (name === 'message') {
      this.listener.message(messageOf(this.method.output, data));
    }
    if (id !== undefined && this.isWhole) this.lastId = id;
  }
}
