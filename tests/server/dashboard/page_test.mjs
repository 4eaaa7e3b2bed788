// Tests parts of the page with a simulated daemon in Chromium, which takes seconds.
//
//   node page_test.mjs FOLDER
//
// FOLDER is a built page.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { join } from 'node:path';

import { assertAccessible, assertNoTrouble, expecting, openPage, runInBrowser } from './browser.mjs';
import { until } from './real_daemon.mjs';
import { SyntheticDaemon } from './synthetic_daemon.mjs';

const [built] = process.argv.slice(2);
const SCENE = '/scenes/project-0/scene-0?class=desktop&reward=3';
const ABORTED = /Failed to load resource|dynamically imported/;

const buttonOf = (page, name) => page.getByRole('button', { name, exact: true });
const stateOf = async (page, names) => Object.fromEntries(await Promise.all(names.map(async (name) => [name, await buttonOf(page, name).isEnabled()])));
const ORDERS = ['AI decides', 'Pin this algorithm', 'Reconnect', 'End session'];

// A game that takes no orders has no buttons for them. The daemon can still end its connection.
async function checkGameWithoutOrders(page, daemon) {
  const [, session] = daemon.sessions;
  Object.assign(session, { takesOrders: false, showsBoxes: false, mode: 'MODE_MANUAL' });
  await page.goto(`${daemon.origin}/sessions/${session.sessionId}?boxes=on`);
  await page.getByText('This game takes no orders: its setting allow_operator_orders is off.').waitFor();
  await page.getByText('This game does not send its boxes: its setting allow_box_view is off.').waitFor();
  assert.deepEqual(await stateOf(page, [...ORDERS, 'Show boxes']), { 'AI decides': false, 'Pin this algorithm': false, Reconnect: true, 'End session': true, 'Show boxes': false });
  assert.ok(await page.getByLabel('Keep').isDisabled());
  assert.equal(await page.locator('.boxes, [role=alert]').count(), 0, 'boxes are requested');
  await assertAccessible(page, 'a game without orders');
  await page.goto(`${daemon.origin}/sessions/${daemon.sessions[0].sessionId}`);
  await until('another game has the buttons', () => buttonOf(page, 'Pin this algorithm').isEnabled());
  assert.equal(await page.getByText('takes no orders').count(), 0);
}

// While an order waits for its answer, no other order can be given.
async function checkWaitingOrder(page, daemon) {
  const [{ sessionId }] = daemon.sessions;
  await page.goto(`${daemon.origin}/sessions/${sessionId}`);
  let answer;
  const held = new Promise((resolve) => { answer = resolve; });
  await page.route('**/OrderSession', async (route) => {
    await held;
    await route.fulfill({ contentType: 'application/x-ndjson', body: '{"mode":"MODE_MANUAL","activeArm":"SAP"}\n' });
  });
  await page.getByLabel('Keep').selectOption('SAP');
  await buttonOf(page, 'Pin this algorithm').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Keep this algorithm' }).click();
  await page.getByText('Ordering that the game keeps SAP …').waitFor();
  assert.deepEqual(await stateOf(page, ORDERS), { 'AI decides': false, 'Pin this algorithm': false, Reconnect: false, 'End session': false });
  answer();
  await page.locator('.toast', { hasText: 'Done: the game keeps SAP.' }).waitFor();
  await until('the buttons work again', () => buttonOf(page, 'Pin this algorithm').isEnabled());
  await page.unroute('**/OrderSession');
}

// The headline names the algorithm that the game begins with.
async function checkSavings(page, daemon) {
  await page.goto(`${daemon.origin}${SCENE}`);
  const text = await until('the savings are there', async () => (await page.locator('.savings').innerText()).includes('of the frame time') && page.locator('.savings').innerText());
  const saves = (us) => `saves ${us} µs \\([\\d.]+ % of the frame time\\) per frame against`;
  assert.match(text, new RegExp(`${saves('30.0')} Grid, the algorithm that the game begins with; it ${saves('12.5')} the best single choice; it ${saves('40.0')} KDTree`));
  await page.goto(daemon.origin);
  await page.getByText('saved per frame against the algorithm that each game begins with').waitFor();
  assert.equal(await page.locator('.figure.main b').innerText(), '30.0 µs');
}

// The charts of a scene come from the history of the daemon, for the chosen period.
async function checkHistory(page, daemon) {
  await page.goto(`${daemon.origin}${SCENE}`);
  const shown = async (id) => (await page.locator(`[data-chart=${id}] .legend`).innerText()).replace(/\s+/g, ' ');
  assert.match(await shown('saved'), /against the first algorithm 30.0 µs against the best single one 12.5 µs against KDTree 40.0 µs/);
  assert.match(await shown('ran'), /SAP 100 %/);
  assert.match(await shown('best'), /DBVT 0.900/, 'P(best) of the present regime');
  await page.locator('label', { hasText: 'Regime' }).getByRole('combobox').selectOption('all together');
  assert.match(await shown('best'), /SAP 0.900/);
  const asked = page.waitForRequest((request) => request.url().endsWith('GetHistory') && request.postDataJSON().kind === 'HISTORY_KIND_SCENE');
  await page.locator('label', { hasText: 'Period' }).getByRole('combobox').selectOption('last week');
  const { fromUnixMs } = (await asked).postDataJSON();
  assert.ok(Math.abs(Date.now() - Number(fromUnixMs) - 7 * 86_400_000) < 60_000, fromUnixMs);
  assert.equal(new URL(page.url()).searchParams.get('period'), 'week');
}

// A view whose file could not be loaded can be loaded later. While the daemon is away, the page stays.
async function checkFailedView(page, daemon) {
  await page.goto(daemon.origin);
  await page.getByRole('heading', { name: 'Scenes' }).waitFor();
  await page.evaluate(() => { globalThis.marker = 'the same page'; });
  await expecting(page, ABORTED, async () => {
    let tries = 0;
    await page.route('**/livez', (route) => route.abort());
    await page.route('**/assets/health*', (route) => { ++tries; return route.abort(); });
    await page.getByRole('link', { name: 'Health', exact: true }).click();
    await page.getByText('The view cannot be shown').waitFor();
    await buttonOf(page, 'Try again').click();
    await until('the file is requested again', () => tries === 2);
    await page.getByText('The view cannot be shown').waitFor();
    assert.equal(await page.evaluate(() => globalThis.marker), 'the same page', 'the page was reloaded while the daemon is away');
    for (const pattern of ['**/assets/health*', '**/livez']) await page.unroute(pattern);
  });
  await buttonOf(page, 'Try again').click();
  await page.getByRole('heading', { name: 'Health of the daemon' }).waitFor();
}

// Escape closes explanations, wherever the focus is.
async function checkEscape(page, daemon) {
  const [{ sessionId }] = daemon.sessions;
  const why = page.locator('section.why');
  await page.goto(`${daemon.origin}/sessions/${sessionId}`);
  await until('there are decisions', () => buttonOf(page, 'Why this algorithm?').isEnabled());
  await buttonOf(page, 'Why this algorithm?').click();
  await why.waitFor();
  await page.keyboard.press('Escape');
  assert.equal(await why.count(), 0, 'after its button');
  const chart = page.locator('figure[data-chart=timeline] .plot');
  await until('a decision is explained', async () => {
    await chart.focus();
    await page.keyboard.press('Home');
    await page.keyboard.press('Enter');
    return await why.count() > 0;
  });
  await page.keyboard.press('Escape');
  assert.equal(await why.count(), 0, 'after Enter in a chart');
  await page.goto(`${daemon.origin}/decisions?session=${sessionId}`);
  await page.getByRole('region', { name: 'Rows' }).locator('tbody th a').first().click();
  await why.waitFor();
  await page.keyboard.press('Escape');
  await until('the row is closed', async () => await why.count() === 0);
  await page.goto(daemon.origin);
  await page.getByText('Terms on this page').click();
  assert.equal(await page.locator('details[open]').count(), 1);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('details[open]').count(), 0, 'the terms');
}

// Returns a .aabbs file in which two boxes move towards each other (engine_client/scene/README.md).
function recordingOf(frameCount) {
  const file = Buffer.alloc(304 + 64 * frameCount);
  file.write('duel\0', 0, 'latin1');
  [2, frameCount - 1, 0, 0].forEach((value, i) => file.writeInt32LE(value, 256 + 4 * i));
  const put = (numbers, at) => numbers.forEach((value, i) => file.writeFloatLE(value, at + 4 * i));
  put([0, 0, 0, 0, 10, 10, 10, 0], 272);
  for (let frame = 0; frame < frameCount; ++frame) {
    const x = 4 * frame / (frameCount - 1);
    put([x, 4, 4, 0, x + 2, 6, 6, 0], 304 + 64 * frame);
    put([8 - x, 4, 4, 0, 10 - x, 6, 6, 0], 336 + 64 * frame);
  }
  return file;
}

// A recording that is chosen or dropped is played, step by step or to its end. A bad file gives the reason.
async function checkRecording(page, daemon) {
  await page.goto(daemon.origin);
  await page.getByRole('link', { name: 'Play a recording' }).click();
  const choose = (name, buffer) => page.getByLabel('File').setInputFiles({ name, mimeType: 'application/octet-stream', buffer });
  await choose('notes.aabbs', Buffer.from('no recording'));
  await page.getByText('notes.aabbs cannot be played: the file is shorter than the header of a recording.').waitFor();
  await choose('duel.aabbs', recordingOf(30));
  await page.getByRole('heading', { name: 'Recording of duel' }).waitFor();
  const says = (text) => page.locator('.box-count', { hasText: text }).waitFor();
  await says('Frame 0: 2 objects, 0 of them in 0 overlapping pairs.');
  await buttonOf(page, 'Next frame').click();
  await says('Frame 1: ');
  await buttonOf(page, 'Previous frame').click();
  await says('Frame 0: ');
  assert.ok(await buttonOf(page, 'Previous frame').isDisabled());
  await page.getByLabel('Speed').selectOption('120');
  await buttonOf(page, 'Play').click();
  await says('Frame 29: 2 objects, 2 of them in 1 overlapping pair.');
  await buttonOf(page, 'Play').waitFor(); // it stops at the end
  await page.getByLabel('Frame 29 of 29').fill('10');
  await says('Frame 10: ');
  await assertAccessible(page, 'a recording');
  const dropped = await page.evaluateHandle((bytes) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([Uint8Array.from(bytes)], 'dropped.aabbs'));
    return transfer;
  }, [...recordingOf(7)]);
  await page.locator('section.recording').dispatchEvent('drop', { dataTransfer: dropped });
  await page.getByLabel('Frame 0 of 6').waitFor();
}

async function checkAll(browser) {
  if (!existsSync(join(built, 'index.html'))) return `${built} has no built page`;
  const daemon = await new SyntheticDaemon({ sceneCount: 5, sessionCount: 3, speed: 1, folder: built }).listen();
  try {
    const page = await openPage(await browser.newContext({ viewport: { width: 1440, height: 900 } }), daemon.origin);
    for (const check of [checkGameWithoutOrders, checkWaitingOrder, checkSavings, checkHistory, checkFailedView, checkEscape, checkRecording]) {
      await check(page, daemon);
      assertNoTrouble(page, check.name);
      console.log(`${check.name}: passed`);
    }
  } finally {
    daemon.close();
  }
  return '';
}

await runInBrowser('page', checkAll);
