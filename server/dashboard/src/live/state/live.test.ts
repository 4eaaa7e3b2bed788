import { create, toJsonString } from '@bufbuild/protobuf';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { WatchPosteriorsResponseSchema } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionState, WatchSessionsResponseSchema } from '../../gen/sweepstake/v1/sessions_pb';

// The daemon's two streams, to which a test writes events, and the browser's animation frames.
const bodies = new Map<string, ReadableStreamDefaultController<Uint8Array>>();
let frames: (() => void)[] = [];
let whoami = '{"version":"1","asksForTokens":false,"loggedIn":false,"name":"","role":"admin","projects":[]}';

const fetch = vi.fn((url: string) => {
  if (url === '/api/whoami') return Promise.resolve(new Response(whoami));
  const name = /Watch\w+/.exec(url)![0];
  return Promise.resolve(new Response(new ReadableStream({ start: (body) => { bodies.set(name, body); } })));
});

beforeEach(() => {
  vi.useFakeTimers();
  vi.resetModules();
  bodies.clear();
  frames = [];
  fetch.mockClear();
  const target = { addEventListener: () => undefined };
  vi.stubGlobal('document', { ...target, hidden: false });
  vi.stubGlobal('window', target);
  vi.stubGlobal('fetch', fetch);
  vi.stubGlobal('BroadcastChannel', class { postMessage() { /* no other page */ } });
  vi.stubGlobal('requestAnimationFrame', (frame: () => void) => frames.push(frame));
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const settle = () => vi.advanceTimersByTimeAsync(0);
const draw = () => frames.splice(0).forEach((frame) => frame());
async function send(stream: string, ...events: string[]) {
  bodies.get(stream)!.enqueue(new TextEncoder().encode(events.join('')));
  await settle();
}
const posterior = (scene: string, alpha = 2, decisionIds: number[] = []) => `data: ${toJsonString(WatchPosteriorsResponseSchema, create(WatchPosteriorsResponseSchema, {
  posterior: { project: 'p', scene, rewardVersion: 3, arms: [{ arm: 'SAP', backendVersion: 1, posterior: { alpha, beta: 2 } }] },
  decisions: decisionIds.map((id) => ({ project: 'p', scene, sessionId: 's1', policy: 'adaptive', decisionId: BigInt(id) })),
  stamp: { boot: 1n, sequence: 1n, unixMs: 5n } }))}\n\n`;
const session = (sessionId: string) => `data: ${toJsonString(WatchSessionsResponseSchema, create(WatchSessionsResponseSchema,
  { sessions: [{ sessionId, state: SessionState.CONNECTED }] }))}\n\n`;
const BEGIN = 'event: snapshot-begin\ndata: {}\n\n';
const END = 'event: snapshot-end\nid: a:1\ndata: {}\n\n';

async function started() {
  const live = await import('./live');
  const { scenes } = await import('./scenes');
  const { sessions } = await import('./sessions');
  const { connection } = await import('./connection');
  live.startLive();
  await settle();
  const alphas = () => Object.fromEntries([...scenes.value.values()].map(({ posterior: { scene, arms } }) => [scene, arms[0]!.posterior!.alpha]));
  return { ...live, scenes, sessions, connection, alphas };
}

it('shows a snapshot when it is complete, and later changes once per frame', async () => {
  const { scenes, alphas, connection, isKnown } = await started();
  expect(connection.value.status).toBe('live');
  await send('WatchPosteriors', BEGIN, posterior('a'));
  draw();
  expect(scenes.value.size).toBe(0);
  await send('WatchPosteriors', posterior('b'), END);
  draw();
  expect(alphas()).toEqual({ a: 2, b: 2 });
  expect(isKnown.value).toEqual({ scenes: true, sessions: false });
  let changes = -1;
  scenes.subscribe(() => { ++changes; });
  await send('WatchPosteriors', posterior('a', 3, [1]), posterior('c', 7), posterior('a', 4, [2]));
  expect(changes).toBe(0);
  draw();
  expect(changes).toBe(1);
  expect(alphas()).toEqual({ a: 4, b: 2, c: 7 });
  expect([...scenes.value.values()][0]!.decisions.map(({ decisionId }) => decisionId)).toEqual([1n, 2n]);
});

it('applies changes after a snapshot to that snapshot, in the same frame too', async () => {
  const { alphas } = await started();
  await send('WatchPosteriors', posterior('a', 3), BEGIN, posterior('a', 5), posterior('b', 5), END, posterior('b', 6));
  draw();
  expect(alphas()).toEqual({ a: 5, b: 6 });
});

it('adds decisions to their sessions', async () => {
  const { sessions } = await started();
  await send('WatchSessions', BEGIN, session('s1'), session('s2'), END);
  await send('WatchPosteriors', BEGIN, END, posterior('a', 3, [1, 2]));
  draw();
  expect(sessions.value.get('s1')!.decisions).toHaveLength(2);
  expect(sessions.value.get('s2')!.decisions).toHaveLength(0);
});

it('is offline while one of its streams is', async () => {
  const { connection } = await started();
  bodies.get('WatchSessions')!.close();
  await settle();
  expect(connection.value.status).toBe('offline');
  await vi.advanceTimersByTimeAsync(600);
  expect(connection.value.status).toBe('live');
});

it('opens no stream before the login', async () => {
  whoami = '{"version":"1","asksForTokens":true,"loggedIn":false,"name":"","role":"ingest","projects":[]}';
  await started();
  expect(fetch.mock.calls.map(([url]) => url)).toEqual(['/api/whoami']);
});
