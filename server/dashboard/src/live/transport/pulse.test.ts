import { afterEach, beforeEach, expect, it, vi } from 'vitest';

const page = { hidden: false, addEventListener: () => undefined };

beforeEach(() => {
  vi.useFakeTimers();
  vi.resetModules();
  vi.stubGlobal('document', page);
  page.hidden = false;
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

async function begin(answer: () => Promise<Response>) {
  const fetch = vi.fn(answer);
  vi.stubGlobal('fetch', fetch);
  const pulse = await import('./pulse');
  pulse.heard();
  pulse.startPulse();
  return { ...pulse, fetch };
}

it('requests /livez after some silence, and an answer is a sign of life', async () => {
  const { isStale, fetch } = await begin(() => Promise.resolve(new Response('ok')));
  await vi.advanceTimersByTimeAsync(3000);
  expect(fetch).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(17_000);
  expect(fetch.mock.calls.length).toBeGreaterThan(3);
  expect(isStale.value).toBe(false);
});

it('is stale after 5 s of silence, until the next sign of life', async () => {
  const { isStale, heard } = await begin(() => new Promise(() => undefined));
  await vi.advanceTimersByTimeAsync(5000);
  expect(isStale.value).toBe(false);
  await vi.advanceTimersByTimeAsync(1000);
  expect(isStale.value).toBe(true);
  heard();
  expect(isStale.value).toBe(false);
});

it('sends no request while events arrive or while the page is hidden', async () => {
  const { isStale, heard, fetch } = await begin(() => Promise.reject(new TypeError()));
  for (let i = 0; i < 20; ++i) {
    await vi.advanceTimersByTimeAsync(1000);
    heard();
  }
  page.hidden = true;
  await vi.advanceTimersByTimeAsync(60_000);
  expect(fetch).not.toHaveBeenCalled();
  expect(isStale.value).toBe(false);
});
