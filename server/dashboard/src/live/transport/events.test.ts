import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { create, toJsonText } from './messages';
import { PosteriorsService, WatchPosteriorsResponseSchema, type WatchPosteriorsResponse } from '../../gen/sweepstake/v1/posteriors_pb';
import type { ApiError } from './calls';
import { eventsOf, Watch, type Listener } from './events';

const textOf = (scene: string) => toJsonText(WatchPosteriorsResponseSchema, create(WatchPosteriorsResponseSchema, { posterior: { scene } }));
const event = (name: string, id: string, data: string) => `${name && `event: ${name}\n`}id: ${id}\ndata: ${data}\n\n`;

// A fake daemon. A test writes its answers part by part.
class Daemon {
  readonly requests: { url: string; headers: Record<string, string> }[] = [];
  private body: ReadableStreamDefaultController<Uint8Array> | undefined;
  refusal: Response | undefined;

  readonly fetch = (url: string, init: RequestInit): Promise<Response> => {
    this.requests.push({ url, headers: init.headers as Record<string, string> });
    if (this.refusal) return Promise.resolve(this.refusal);
    const stream = new ReadableStream<Uint8Array>({ start: (body) => { this.body = body; } });
    init.signal?.addEventListener('abort', () => { try { this.body?.error(new DOMException('', 'AbortError')); } catch { /* it has ended */ } });
    return Promise.resolve(new Response(stream, { headers: { 'Content-Type': 'text/event-stream' } }));
  };

  async send(text: string, isLast = false): Promise<void> {
    this.body!.enqueue(new TextEncoder().encode(text));
    if (isLast) this.body!.close();
    await vi.advanceTimersByTimeAsync(0);
  }
}

class Heard implements Listener<WatchPosteriorsResponse> {
  readonly said: string[] = [];
  signsOfLife = 0;
  error: ApiError | undefined;
  messages(messages: readonly WatchPosteriorsResponse[], isSnapshot: boolean) {
    this.said.push(`${isSnapshot ? 'snapshot: ' : ''}${messages.map(({ posterior }) => posterior!.scene).join()}`);
  }
  heard() { ++this.signsOfLife; }
  status(status: string, error?: ApiError) {
    this.said.push(`(${status})`);
    this.error = error;
  }
}

describe('Watch', () => {
  let daemon: Daemon;
  let heard: Heard;
  let watch: Watch<never, never> | undefined;
  beforeEach(() => {
    vi.useFakeTimers();
    daemon = new Daemon();
    heard = new Heard();
    vi.stubGlobal('fetch', daemon.fetch);
  });
  afterEach(() => {
    watch?.close();
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });
  const begin = async () => {
    watch = new Watch(PosteriorsService.method.watchPosteriors, { project: 'a&b' }, heard) as unknown as Watch<never, never>;
    await vi.advanceTimersByTimeAsync(0);
  };

  it('calls the method with its request, and passes on the snapshot and later messages', async () => {
    await begin();
    expect(daemon.requests[0]!.url).toBe('/events/sweepstake.v1.PosteriorsService/WatchPosteriors?request=%7B%22project%22%3A%22a%26b%22%7D');
    await daemon.send(event('snapshot-begin', 'b:1', '{}') + event('', 'b:2', textOf('one')));
    await daemon.send(event('snapshot-end', 'b:3', '{}') + event('', 'b:4', textOf('two')));
    expect(heard.said).toEqual(['(connecting)', '(live)', 'snapshot: one', 'two']);
  });

  it('reconnects automatically after the last event that it received', async () => {
    await begin();
    await daemon.send(event('snapshot-begin', 'b:1', '{}') + event('snapshot-end', 'b:3', '{}') + event('', 'b:4', textOf('two')), true);
    expect(heard.said.at(-1)).toBe('(offline)');
    expect(daemon.requests).toHaveLength(1);
    await vi.advanceTimersByTimeAsync(500);
    expect(daemon.requests).toHaveLength(2);
    expect(daemon.requests[1]!.headers['Last-Event-ID']).toBe('b:4');
    expect(heard.said.at(-1)).toBe('(live)');
  });

  it('waits longer and longer before it requests a snapshot that always breaks off', async () => {
    vi.spyOn(Math, 'random').mockReturnValue(1);
    await begin();
    for (const delayMs of [500, 1000, 2000]) {
      const before = daemon.requests.length;
      await daemon.send(event('snapshot-begin', 'b:1', '{}') + event('', 'b:2', textOf('one')), true);
      await vi.advanceTimersByTimeAsync(delayMs - 1);
      expect(daemon.requests).toHaveLength(before);
      await vi.advanceTimersByTimeAsync(1);
      expect(daemon.requests).toHaveLength(before + 1);
      expect(daemon.requests.at(-1)!.headers, 'it requests a new snapshot').not.toHaveProperty('Last-Event-ID');
    }
    vi.restoreAllMocks();
  });

  it('reports why it is refused, and tries again at once after a login', async () => {
    daemon.refusal = new Response('{"error":{"code":"UNAUTHENTICATED","reason":"TOKEN_MISSING","message":"no token"}}', { status: 401 });
    await begin();
    expect(heard.said.at(-1)).toBe('(denied)');
    expect(heard.error).toMatchObject({ code: 'UNAUTHENTICATED', reason: 'TOKEN_MISSING', message: 'no token', needsLogin: true });
    daemon.refusal = undefined;
    watch!.retry();
    await vi.advanceTimersByTimeAsync(0);
    expect(heard.said.at(-1)).toBe('(live)');
  });

  it('counts a comment as a sign of life, and reconnects after long silence', async () => {
    await begin();
    await vi.advanceTimersByTimeAsync(30_000);
    await daemon.send(': still here\n\n');
    expect(heard.signsOfLife).toBe(1);
    await vi.advanceTimersByTimeAsync(39_000);
    expect(daemon.requests).toHaveLength(1);
    await vi.advanceTimersByTimeAsync(3000);
    expect(daemon.requests).toHaveLength(2);
  });
});

describe('eventsOf', () => {
  const all = async (text: string) => {
    async function* lines() { yield* text.split('\n'); }
    const found = [];
    for await (const each of eventsOf(lines())) found.push(each);
    return found;
  };
  it('joins lines of data, and accepts both kinds of line ends', async () => {
    expect(await all('data: a\r\ndata: b\r\n\r\n')).toEqual([{ name: 'message', id: undefined, data: 'a\nb' }]);
  });
  it('ignores unknown fields and unfinished events', async () => {
    expect(await all(':\nretry: 3\n\ndata: half')).toEqual([undefined]);
  });
});
