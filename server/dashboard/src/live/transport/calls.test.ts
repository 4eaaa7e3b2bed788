import { afterEach, expect, it, vi } from 'vitest';
import { PosteriorsService } from '../../gen/sweepstake/v1/posteriors_pb';
import { PriorsService } from '../../gen/sweepstake/v1/priors_pb';
import { call, stream } from './calls';

afterEach(() => vi.unstubAllGlobals());

function answerWith(response: () => Response | Promise<Response>) {
  const fetch = vi.fn((_url: string, _init: RequestInit) => Promise.resolve(response()));
  vi.stubGlobal('fetch', fetch);
  return fetch;
}

const scenes = async () => (await call(PosteriorsService.method.listPosteriors, { project: 'p' })).scenes;

it('sends JSON with the header that other sites cannot set, and reads 64-bit numbers exactly', async () => {
  const fetch = answerWith(() => new Response('{"scenes":[{"scene":"s","sourceCount":"9007199254740993","future":1}]}'));
  expect((await scenes())[0]).toMatchObject({ scene: 's', sourceCount: 9007199254740993n });
  const [url, init] = fetch.mock.calls[0]!;
  expect(url).toBe('/api/sweepstake.v1.PosteriorsService/ListPosteriors');
  expect(init).toMatchObject({ method: 'POST', body: '{"project":"p"}', headers: { 'X-Sweepstake': '1' } });
});

it('throws the error that the daemon sends', async () => {
  answerWith(() => new Response('{"error":{"code":"PERMISSION_DENIED","reason":"NOT_ALLOWED","message":"not yours"}}', { status: 403 }));
  await expect(scenes()).rejects.toMatchObject({ code: 'PERMISSION_DENIED', reason: 'NOT_ALLOWED', message: 'not yours' });
});

it('throws a readable error if the answer is not from the daemon, or there is none', async () => {
  answerWith(() => new Response('<html>', { status: 502, statusText: 'Bad Gateway' }));
  await expect(scenes()).rejects.toThrow('502 Bad Gateway');
  answerWith(() => Promise.reject(new TypeError('Failed to fetch')));
  await expect(scenes()).rejects.toMatchObject({ code: 'UNREACHABLE' });
});

// Returns an answer that arrives in these parts.
function pieces(...texts: string[]): Response {
  const bytes = texts.map((text) => new TextEncoder().encode(text));
  return new Response(new ReadableStream({ start(body) { bytes.forEach((each) => body.enqueue(each)); body.close(); } }));
}

it('reads a stream line by line', async () => {
  answerWith(() => pieces('{"records":[{"scene":"ä', '"}]}\n{"records":[{"scene":"b"}]}', '\n'));
  const parts = [];
  for await (const part of stream(PriorsService.method.exportPriors, {})) parts.push(part);
  expect(parts[0]!.records[0]!.scene).toBe('ä');
  expect(parts[1]!.records[0]!.scene).toBe('b');
});

it('throws the error at the end of a stream, after its messages', async () => {
  answerWith(() => pieces('{"records":[{"scene":"b"}]}\n{"error":{"code":"UNAVAILABLE","reason":"STORE_BUSY","message":"busy"}}\n'));
  const parts = stream(PriorsService.method.exportPriors, {});
  expect((await parts.next()).value!.records[0]!.scene).toBe('b');
  await expect(parts.next()).rejects.toMatchObject({ reason: 'STORE_BUSY' });
});
