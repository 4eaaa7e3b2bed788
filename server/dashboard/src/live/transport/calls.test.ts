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

it('reads a stream line by line, and throws the error at its end', async () => {
  answerWith(() => pieces('{"records":[{"scene":"ä', '"}]}\n{"records":[{"scene":"b"}]}', '\n{"error":{"code":"UNAVAILABLE","reason":"STORE_BUSY","message":"busy"}}\n'));
  const parts = stream(PriorsService.method.exportPriors, {});
  for (const scene of ['ä', 'b']) expect((await parts.next()).value!.records[0]!.scene).toBe(scene);
  await expect(parts.next()).rejects.toMatchObject({ code: 'UNAVAILABLE', reason: 'STORE_BUSY', message: 'busy' });
});
