import { afterEach, expect, it, vi } from 'vitest';
import { readRecording } from './recording_file';

afterEach(() => vi.unstubAllGlobals());

// A daemon whose game has these bytes, and gives at most three at a time.
function gameWith(bytes: string) {
  const asked: string[] = [];
  vi.stubGlobal('fetch', (_url: string, { body }: RequestInit) => {
    const { recordingId, offset = '0' } = JSON.parse(String(body)) as { recordingId: string; offset?: string };
    asked.push(`${recordingId}@${offset}`);
    return Promise.resolve(new Response(JSON.stringify({ data: btoa(bytes.slice(Number(offset), Number(offset) + 3)) })));
  });
  return asked;
}

const read = (sizeBytes: bigint, signal = new AbortController().signal, onProgress: (ratio: number) => void = () => undefined) =>
  readRecording('s', { recordingId: 7n, sizeBytes }, signal, onProgress);

it('asks for one part after the other until it has all bytes', async () => {
  const asked = gameWith('01234567');
  const ratios: number[] = [];
  const file = await read(8n, undefined, (ratio) => ratios.push(ratio));
  expect(await file.text()).toBe('01234567');
  expect(asked).toEqual(['7@0', '7@3', '7@6']);
  expect(ratios).toEqual([3 / 8, 6 / 8, 1]);
});

it('gives no file where the game has less than it said', async () => {
  gameWith('0123');
  await expect(read(8n)).rejects.toMatchObject({ code: 'NOT_FOUND' });
});

it('asks for nothing more where it is stopped', async () => {
  const asked = gameWith('01234567');
  const stop = new AbortController();
  await expect(read(8n, stop.signal, () => stop.abort())).rejects.toMatchObject({ name: 'AbortError' });
  expect(asked).toEqual(['7@0']);
});
