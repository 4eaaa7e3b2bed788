// Follows an endless RPC over server-sent events while the page is open. After a lost connection it receives the missed events or a
// new snapshot. It uses fetch instead of EventSource, which reports neither the reason of a refusal nor comments (signs of life).
import { type ApiError, asApiError, errorOfResponse, HEADERS, jsonOf, linesOf, messageOf, parseError, urlOf } from './calls';
import type { Init, Streaming } from './messages';

const FIRST_DELAY_MS = 500;
const MAX_DELAY_MS = 30_000;
const MAX_SILENCE_MS = 40_000;  // silence after which the page reconnects; the daemon sends a comment or an event at least every 15 s

// 'denied': the daemon requires a token, or one with more rights.
export type LinkStatus = 'connecting' | 'live' | 'offline' | 'denied';

export interface Listener<Message> {
  // A snapshot is the complete state: whatever the page had before and the snapshot lacks does not exist any more.
  messages(messages: readonly Message[], isSnapshot: boolean): void;
  status(status: LinkStatus, error?: ApiError): void;
  // Called for each event and each sign of life.
  heard?(): void;
}

const newEvent = () => ({ name: 'message', id: undefined as string | undefined, data: '' });
type ServerEvent = ReturnType<typeof newEvent>;

// Returns the events of a stream, and undefined for a comment, which is a sign of life.
export async function* eventsOf(lines: AsyncIterable<string>): AsyncGenerator<ServerEvent | undefined> {
  let event = newEvent();
  for await (const line of lines) {
    const text = line.endsWith('\r') ? line.slice(0, -1) : line;
    if (text === '') {
      if (event.data || event.id !== undefined) yield event;
      event = newEvent();
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

// Doubles the delay after each failure. A random part keeps many pages from reconnecting at the same moment.
export const delayAfter = (failures: number, random: number) =>
  Math.min(MAX_DELAY_MS, FIRST_DELAY_MS * 2 ** Math.min(failures, 10)) * (0.5 + 0.5 * random);

export class Watch<Request, Message> {
  private lastId = '';  // id of the last event; empty: request a snapshot
  private isWhole = false;  // a complete snapshot was received
  private snapshot: Message[] | undefined;  // the messages received so far of a snapshot that is not complete yet
  private failures = 0;
  private attempt: AbortController | undefined;
  private isClosed = false;
  private wake: () => void = () => undefined;

  constructor(
    private readonly method: Streaming<Request, Message>,
    private readonly request: Init<Request>,
    private readonly listener: Listener<Message>,
  ) {
    void this.run();
  }

  // Ends the wait before the next attempt to connect, if there is one, for instance after a login.
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

  // Connects and reads events until the stream ends; returns the reason.
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
        this.listener.heard?.();
        if (event) this.take(event);
        if (this.isWhole) this.failures = 0;  // only after a whole snapshot: if each one breaks off, the delay must still grow
      }
      return asApiError(undefined);
    } finally {
      clearTimeout(silence);
      attempt.abort();
    }
  }

  private url(): string {
    return urlOf(`/events/${this.method.path}?request=${encodeURIComponent(jsonOf(this.method.input, this.request))}`);
  }

  private take({ name, id, data }: ServerEvent): void {
    if (name === 'error') throw parseError(data, 'the daemon ended the stream');
    if (name === 'snapshot-begin') {
      this.isWhole = false;
      this.lastId = '';
      this.snapshot = [];
    } else if (name === 'snapshot-end') {
      this.isWhole = true;
      this.listener.messages(this.snapshot ?? [], true);
      this.snapshot = undefined;
    } else if (name === 'message') {
      const message = messageOf(this.method.output, data);
      if (!this.snapshot?.push(message)) this.listener.messages([message], false);
    }
    if (id !== undefined && this.isWhole) this.lastId = id;
  }
}
