// Tests the views of a scene, a session and the decisions, with a real daemon and real games in Chromium.
//
//   node views_test.mjs SWEEPSTAKED SWEEPSTAKE
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

import { assertAccessible, assertNoTrouble, expecting, judge, openPage, refusalOf, refused, rowsOf, runInBrowser } from './browser.mjs';
import { Game, pause, RealDaemon, until, watched } from './real_daemon.mjs';

const [sweepstaked, sweepstake] = process.argv.slice(2);
const SCENE = '/scenes/arcade/arena?class=test&reward=3';


const chart = (page, id) => page.locator(`figure[data-chart=${id}]`);
const hasPeriods = (figure) => figure.getByRole('group', { name: /, [1-9][\d,]* periods?\./ }).waitFor(); // in the chart of switches
const timeIn = (figure) => figure.locator('.legend time').innerText();
const query = (page) => new URL(page.url()).searchParams;

const sessionsOf = async (daemon) => (await daemon.call('SessionsService/ListSessions')).sessions ?? [];
const liveSession = (daemon) => until('a session is connected', async () => (await sessionsOf(daemon)).find(({ state, scene }) => state === 'SESSION_STATE_CONNECTED' && scene === 'arena'));
const isSession = (daemon, id, what, test) => until(what, async () => (await sessionsOf(daemon)).some((session) => session.sessionId === id && test(session)));

// ---- A scene.

// The view shows the numbers that the command line computes from the same posteriors. No game runs meanwhile.
async function checkNumbers(page, daemon) {
  await page.goto(`${daemon.origin}${SCENE}&arms-columns=all`);
  const scene = watched(sweepstake, daemon).find((each) => each.scene === 'arena');
  assert.equal((await page.locator('.leader-probability').innerText()).trim(), scene.arms.find(({ arm }) => arm === scene.leader_arm).best_probability.toFixed(3));
  assert.ok((await page.locator('main .chip').first().innerText()).includes(scene.verdict));
  const rows = await rowsOf(page, 'Algorithms');
  assert.equal(rows.length, scene.arms.length);
  for (const arm of scene.arms) {
    const row = rows.find(({ Algorithm }) => Algorithm === arm.arm);
    assert.equal(row['P(best)'], arm.best_probability.toFixed(3), arm.arm);
    assert.equal(row.Windows, String(arm.windows), arm.arm);
    assert.equal(row['Shadow measurements'], String(arm.lane_visits), arm.arm);
    const worth = row['Equivalent windows'];
    assert.ok(arm.n > 0 ? Math.abs(Number(worth.replaceAll(',', '')) / arm.n - 1) < 0.006 : worth === '–', `${arm.arm}: ${worth} instead of ${arm.n}`);
    assert.equal(row.Measured, arm.windows + arm.bail_outs > 0 ? 'live' : arm.lane_visits > 0 ? 'lane only' : 'never', arm.arm);
    const [ratio] = row['Cost ÷ leader’s'].split(' ');
    assert.ok(Math.abs(Number(ratio) / arm.cost_ratio - 1) < 0.006, `${arm.arm}: ${ratio} instead of ${arm.cost_ratio}`);
  }
  assert.equal(await chart(page, 'beliefs').locator('svg.picture title').count(), scene.arms.length, 'a ridge for each arm');
}

const activityOf = async (daemon, name) => (await daemon.call('PosteriorsService/ListPosteriors')).scenes?.find(({ scene }) => scene === name)?.activity;
const bestArms = ({ regimes = [] }) => [...new Set(regimes.map(({ bestArm = '' }) => bestArm))].filter(Boolean);

// The headline of a scene, its regimes and its verdict are those of the daemon, and do not contradict one another.
async function checkRegimes(page, daemon) {
  const game = new Game(sweepstake, daemon, 'arcade', 'seasons', { plays: 'rest-and-motion' });
  await until('the scene has regimes', async () => (await activityOf(daemon, 'seasons'))?.regimes?.length > 1, 180_000);
  await page.goto(`${daemon.origin}/scenes/arcade/seasons?class=test&reward=3`);
  await page.getByRole('region', { name: 'Best algorithm of each regime', exact: true }).waitFor();
  const shown = () => page.evaluate(() => ({ text: document.querySelector('main').innerText, chip: document.querySelector('main .chip').innerText }));
  // The daemon and the page are read at different times, so a reading may be between two events.
  await until('the page has the daemon\'s figures', async () => {
    const activity = await activityOf(daemon, 'seasons');
    const [{ text, chip }, rows] = [await shown(), await rowsOf(page, 'Best algorithm of each regime')];
    const isChanging = bestArms(activity).length > 1;
    assert.equal(/would gain/.test(text) && /changing/.test(chip), false, 'a changing scene has the verdict of a constant one');
    assert.equal(/changing/.test(chip), /depends on the regime|A session has switched more than four times/.test(text), chip);
    return text.includes(`${activity.activeArm} runs now`) && (!isChanging || /changing/.test(chip)) && rows.length === activity.regimes.length + 1
      && activity.regimes.every(({ bestArm = 'none', isPresent = false }, i) => rows.some((row) => row.Regime === `${i + 1}${isPresent ? ' (now)' : ''}` && row['Best algorithm'] === bestArm));
  });
  await assertAccessible(page, 'regimes');
  await game.quit();
  await page.getByText('No session is connected.').waitFor();
}

// An arm that never ran in a game is marked.
async function checkNeverRan(page) {
  const arms = await rowsOf(page, 'Algorithms');
  const unseen = arms.filter(({ Measured }) => Measured !== 'live');
  const titles = await chart(page, 'beliefs').locator('svg.picture title').allTextContents();
  for (const { Algorithm, Measured } of unseen) assert.ok(titles.some((title) => title.startsWith(`${Algorithm}: `) && /never/.test(title)), `${Algorithm} is ${Measured}`);
  await page.getByRole('button', { name: 'Show evidence by source' }).click();
  await chart(page, 'measured').locator('svg.picture').waitFor();
  const measured = await chart(page, 'measured').locator('svg.picture title').allTextContents();
  assert.ok(measured.some((title) => / live: /.test(title)), measured.join('\n'));
  // A machine without a core to spare has no shadow lane.
  const hasLane = arms.some((row) => row['Shadow measurements'] !== '0');
  assert.equal(measured.some((title) => / lane: /.test(title)), hasLane, measured.join('\n'));
}

async function checkFiles(page) {
  const figure = chart(page, 'beliefs');
  const [csv] = await Promise.all([page.waitForEvent('download'), figure.getByRole('link', { name: /CSV/ }).click()]);
  assert.match(csv.suggestedFilename(), /^sweepstake_arcade_arena_beliefs\.csv$/);
  const lines = readFileSync(await csv.path(), 'utf8').split('\r\n');
  assert.match(lines[0], /^project,scene,machines,reward version,/);
  assert.ok(lines.slice(1, -1).length > 1 && lines.slice(1, -1).every((line) => line.startsWith('arcade,arena,')), 'the CSV file has other scenes');
  const [png] = await Promise.all([page.waitForEvent('download'), figure.getByRole('button', { name: /PNG/ }).click()]);
  const picture = readFileSync(await png.path());
  assert.equal(picture.subarray(1, 4).toString(), 'PNG');
  assert.ok(picture.length > 5000, `${picture.length} bytes`);
  await figure.getByRole('button', { name: 'Table' }).click();
  assert.ok(await figure.locator('tbody tr').count() > 1, 'the table has no values');
}

// While a game runs, charts grow, dragging zooms, pausing keeps the figures, and arms can be hidden. The URL contains all of this.
async function checkTime(page, daemon) {
  await page.goto(`${daemon.origin}${SCENE}`);
  const arms = async () => JSON.stringify((await daemon.call('PosteriorsService/ListPosteriors')).scenes.find(({ scene }) => scene === 'arena').arms);
  const before = await arms();
  await until('the game has added evidence', async () => await arms() !== before, 120_000);
  await chart(page, 'best').scrollIntoViewIfNeeded();
  // A redrawn chart, as after the first measurement of an arm, has no position for a moment and ends a drag. Therefore this is repeated.
  await until('the range is in the address', async () => {
    const { x, y, width, height } = await until('the chart is drawn', () => chart(page, 'best').locator('.u-over').boundingBox());
    await page.mouse.move(x + width * 0.3, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width * 0.7, y + height / 2, { steps: 5 });
    await page.mouse.up();
    await pause(500);
    return query(page).has('from') && query(page).has('to');
  });
  assert.ok(Number(query(page).get('from')) < Number(query(page).get('to')));
  await page.getByRole('button', { name: 'Show all' }).click();
  assert.ok(!query(page).has('from'));
  await chart(page, 'best').locator('.plot').focus();
  await page.keyboard.press('ArrowLeft');
  await until('the status has the values at the crosshair', async () => /\d\.\d{3}/.test(await chart(page, 'best').locator('[role=status]').innerText()), 3000);
  const crosshair = await timeIn(chart(page, 'best'));
  assert.match(crosshair, /\d/);
  await until('the other chart has the crosshair', async () => await timeIn(chart(page, 'costs')) === crosshair, 3000);
  await chart(page, 'costs').locator('.u-cursor-x:not(.u-off)').waitFor();
  const arm = chart(page, 'costs').locator('button.entry').first();
  await arm.click();
  assert.equal(await arm.getAttribute('aria-pressed'), 'false');
  assert.ok(query(page).has('hide'));
  await page.getByRole('button', { name: 'Pause' }).click();
  assert.ok(query(page).has('pause'));
  const counts = async () => (await rowsOf(page, 'Algorithms')).map(({ Windows, 'Shadow measurements': visits }) => `${Windows} ${visits}`).join();
  const held = await counts();
  for (let i = 0; i < 5; ++i) {
    const learnt = await arms();
    await until('the game adds evidence', async () => await arms() !== learnt);
  }
  assert.equal(await counts(), held, 'figures change during a pause');
  await page.getByRole('button', { name: 'Resume' }).click();
  await until('figures change again', async () => await counts() !== held);
}

// ---- A session.

async function checkWhy(page, daemon, { sessionId }) {
  await page.goto(`${daemon.origin}/sessions/${sessionId}`);
  await hasPeriods(chart(page, 'timeline'));
  const why = page.getByRole('button', { name: 'Why this algorithm?' });
  await until('there are decisions', () => why.isEnabled());
  await why.click();
  const panel = page.locator('section.why');
  await panel.waitFor();
  await panel.getByText('More', { exact: true }).click();
  assert.match(await panel.innerText(), /is the best algorithm with a probability of (over )?\d/);
  assert.ok(Number(query(page).get('decision')) > 0);
  await panel.getByText('Audit row', { exact: true }).click(); // the page reads it automatically, a moment after the decision
  assert.equal(await panel.locator('dt', { hasText: /^decision[.]id$/ }).locator('+ dd').innerText(), query(page).get('decision'));
  await page.reload();
  await panel.waitFor();
  await panel.getByRole('button', { name: 'Close' }).click();
  assert.ok(!query(page).has('decision'));
  await page.goto(`${daemon.origin}/sessions/${sessionId}?decision=999999999`);
  await page.getByText('The log does not have the decision in the URL.').waitFor();
  await page.goto(`${daemon.origin}/sessions/${sessionId}?decision=2`); // an old decision, which the first screen does not have
  await panel.getByRole('heading', { name: /^Decision 2,/ }).waitFor();
}

const numberIn = (text) => Number.parseInt(text.replaceAll(',', ''), 10);

// The page has each row of the log a moment after the daemon.
async function checkLog(page, daemon, { sessionId }) {
  const stored = async () => (await daemon.responses('AuditService/ListAuditSegments', { sessionId })).flatMap(({ segments }) => segments).reduce((sum, { rowCount }) => sum + Number(rowCount), 0);
  const shown = async () => numberIn(await page.locator('.row-count').innerText());
  await page.goto(`${daemon.origin}/sessions/${sessionId}`);
  await until('the log is there', async () => await page.locator('.row-count').count());
  let worst = 0;
  const [firstShown, firstStored] = [await shown(), await stored()];
  for (let i = 0; i < 10; ++i) {
    const before = await shown() - firstShown;
    const told = await until('the session has decided something', async () => { const now = await stored() - firstStored; return now > before && now; });
    const start = Date.now();
    await until('the page has its row', async () => await shown() - firstShown >= told);
    worst = Math.max(worst, Date.now() - start);
  }
  judge('a row of the log is on the page of its session', worst, 1000);
}

// A failed read of the log does not move the charts. The rows read before stay, and the page tries again.
async function checkLogAway(page) {
  const rows = async () => numberIn(await page.locator('.row-count').innerText());
  const place = async () => (await page.locator('figure[data-chart=detection]').boundingBox()).y + await page.evaluate(() => scrollY);
  const before = { y: await place(), rows: await rows() };
  await expecting(page, /ListDecisions|Failed to load resource/, async () => {
    await page.route('**/ListDecisions', (route) => route.abort());
    await page.getByText('the daemon cannot be reached; the page tries again').waitFor();
    assert.ok(Math.abs(await place() - before.y) < 1, 'a chart was moved');
    assert.equal(await page.getByText('cannot be shown').count(), 0);
    await page.unroute('**/ListDecisions');
  });
  await until('new rows are read', async () => await rows() > before.rows);
  assert.equal(await page.getByText('the page tries again').count(), 0);
}

// Percentiles appear with the first live decision, and the log adds checks and objects.
async function checkCosts(page) {
  await until('percentiles of frames', async () => /p99\s*\d/.test(await chart(page, 'frame-time').locator('.legend').innerText()));
  assert.match(await chart(page, 'memory').locator('.legend').innerText(), /[kM]?B/);
  await until('checks of the log', async () => /checks\s*\d/.test(await chart(page, 'checks').locator('.legend').innerText()));
  await until('objects of the log', async () => /objects\s*100\b/.test(await chart(page, 'objects').locator('.legend').innerText()));
}

const hover = async (figure, share) => {
  await figure.scrollIntoViewIfNeeded();
  const { width, height } = await until('the chart is drawn', () => figure.locator('.u-over').boundingBox());
  await figure.locator('.u-over').hover({ position: { x: width * share, y: height / 2 } });
};
// The page fits the width of a phone.
async function isNarrow(page, what) {
  const size = page.viewportSize();
  await page.setViewportSize({ width: 320, height: 640 });
  await until(`${what} fits a narrow page`, () => page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 10_000); // charts follow the width
  await assertAccessible(page, `${what}, narrow`);
  await page.setViewportSize(size);
}

// Compares two live sessions. The second one began later, and is drawn from the start of the first.
async function checkCompare(page, daemon, { sessionId }) {
  const hasDecidedMuch = async (id) => {
    await page.goto(`${daemon.origin}/sessions/${id}`);
    await until('it has decided much', async () => Number.parseInt((await page.getByText(/^[\d,]+ decisions$/).innerText()).replace(',', ''), 10) > 300);
  };
  await hasDecidedMuch(sessionId);
  const rival = new Game(sweepstake, daemon, 'arcade', 'arena');
  const { sessionId: other } = await until('another session is connected', async () => (await sessionsOf(daemon)).find((each) => each.sessionId !== sessionId));
  await hasDecidedMuch(other);
  await page.goto(`${daemon.origin}/sessions/${sessionId}?from=1&to=2`);
  await page.getByLabel('Compare with').selectOption(other);
  await page.getByRole('heading', { name: 'Comparison', exact: true }).waitFor();
  assert.deepEqual([query(page).get('with'), query(page).get('from')], [other, null]);
  for (const [i, id] of [sessionId, other].entries()) {
    assert.equal(await page.getByRole('heading', { level: 2 }).nth(i).innerText(), `Session ${id}`);
    await hasPeriods(chart(page, 'timeline').nth(i));
  }
  await page.getByRole('button', { name: 'Pause' }).click(); // so that the charts do not move
  const [first, second] = [0, 1].map((i) => chart(page, 'frame-time').nth(i));
  const hasMean = async (figure) => /window mean\s*\d/.test(await figure.locator('.legend').innerText());
  const hasBoth = async (pointed, seen, share) => {
    await hover(pointed, share);
    return await hasMean(pointed) && await hasMean(seen) && await timeIn(seen) === await timeIn(pointed) && share;
  };
  // Not every window has a mean, so several positions are tried. Without the shift, the second session would have no values there.
  const share = await until('both have the values at one crosshair', async () =>
    await hasBoth(first, second, 0.02) || await hasBoth(first, second, 0.05) || hasBoth(first, second, 0.1));
  const at = await timeIn(first);
  assert.match(at, /\d/);
  await until('the same place is the same time', async () => await hasBoth(second, first, share) && await timeIn(second) === at);
  const [file] = await Promise.all([page.waitForEvent('download'), second.getByRole('link', { name: /CSV/ }).click()]);
  const firstMs = Date.parse(readFileSync(await file.path(), 'utf8').split('\r\n')[1].split(',')[0]);
  const { unixStartMs } = (await sessionsOf(daemon)).find((each) => each.sessionId === other);
  assert.ok(firstMs >= Number(unixStartMs) - 1000, 'the CSV file has shifted times');
  await isNarrow(page, 'two sessions');
  await page.reload();
  await hasPeriods(chart(page, 'timeline').nth(1));
  const theirs = chart(page, 'timeline').nth(1);
  await until('the status describes the last decision', async () => {
    await theirs.locator('.plot').focus();
    await page.keyboard.press('End'); // the page may have dropped the first one from its log
    return /\d/.test(await theirs.getByRole('status').innerText());
  });
  await page.keyboard.press('Enter');
  await page.locator('.why').waitFor();
  assert.equal(new URL(page.url()).pathname, `/sessions/${other}`, 'a decision of the second session is not explained on the page of that session');
  await page.goBack();
  await page.getByRole('button', { name: 'Show only the first one' }).click();
  await page.getByRole('heading', { name: `Session ${sessionId}` }).waitFor();
  await rival.quit();
}

// Comparing with an unknown session or scene shows nothing for it, and its name is escaped.
async function checkUnknown(page, daemon, { sessionId }) {
  const nobody = '<img src=x>\u202Egnp';
  await page.goto(`${daemon.origin}/sessions/${sessionId}?with=${encodeURIComponent(nobody)}`);
  await hasPeriods(chart(page, 'timeline').first());
  await chart(page, 'timeline').nth(1).getByText('The log of this session is empty.').waitFor();
  await page.getByRole('heading', { name: 'Session <img src=x>⟨U+202E⟩gnp' }).waitFor();
  assert.equal(await page.locator('main img').count(), 0, 'a name became markup');
  await isNarrow(page, 'an unknown session');
  await page.goto(`${daemon.origin}${SCENE}&with=${encodeURIComponent(nobody)}`);
  await page.getByText('The daemon does not know the other scene').waitFor();
  await page.getByRole('button', { name: 'Show only the first one' }).click();
  await page.getByRole('region', { name: 'Algorithms' }).waitFor();
}

// Returns a hash of the canvas; 0 if nothing is drawn.
const pictureOf = (page) => page.locator('.boxes canvas').evaluate((canvas) => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data
  .reduce((sum, value, i) => (value ? (31 * sum + value + i) % 1_000_003 : sum), 0));

// Boxes are requested only while they are shown. Then the objects are drawn, and keys turn the camera.
async function checkBoxes(page, daemon, { sessionId }) {
  const asked = [];
  page.on('request', (request) => request.url().includes('WatchBoxes') && asked.push(request.url()));
  await page.goto(`${daemon.origin}/sessions/${sessionId}`);
  const show = page.getByRole('button', { name: 'Show boxes' });
  await until('the session is there', () => show.isEnabled());
  assert.deepEqual(asked, [], 'off by default');
  await show.click();
  assert.equal(query(page).get('boxes'), 'on');
  const count = page.locator('.box-count');
  await until('all objects are there', async () => /: 100 objects, \d+ of them in \d+ overlapping pairs?\./.test(await count.innerText()));
  await until('they are drawn', async () => await pictureOf(page) > 0);
  const frame = async () => (await count.innerText()).split(':')[0];
  const before = await frame();
  await until('the next ones come', async () => await frame() !== before);
  await page.getByRole('button', { name: 'Pause' }).click();
  await until('the boxes are paused', async () => { const at = await frame(); const picture = await pictureOf(page); await pause(600); return await frame() === at && await pictureOf(page) === picture; });
  const still = await pictureOf(page);
  await page.locator('.boxes canvas').focus();
  await page.keyboard.press('ArrowLeft');
  await until('the camera turns', async () => await pictureOf(page) !== still);
  await page.keyboard.press('0');
  await until('and back', async () => await pictureOf(page) === still);
  await assertAccessible(page, 'boxes');
  await page.getByRole('button', { name: 'Resume' }).click();
  await show.click();
  assert.ok(!query(page).has('boxes'));
  assert.equal(await page.locator('.boxes').count(), 0);
}

async function order(page, button, confirm) {
  await page.getByRole('button', { name: button, exact: true }).click();
  await page.getByRole('dialog').getByRole('button', { name: confirm, exact: true }).click();
}

async function checkOrders(page, daemon, { sessionId }) {
  await page.getByLabel('Keep').selectOption('SAP');
  await order(page, 'Pin this algorithm', 'Keep this algorithm');
  await isSession(daemon, sessionId, 'the game keeps to SAP', ({ mode, activeArm }) => mode === 'MODE_MANUAL' && activeArm === 'SAP');
  // Not click(): on a busy machine the message disappears before the pointer has reached it.
  await page.locator('.toast', { hasText: 'Done: ' }).getByRole('button', { name: 'Undo' }).dispatchEvent('click');
  await isSession(daemon, sessionId, 'the daemon decides again', ({ mode }) => mode === 'MODE_AI');
  await order(page, 'Pin this algorithm', 'Keep this algorithm');
  await isSession(daemon, sessionId, 'the game keeps to an arm again', ({ mode }) => mode === 'MODE_MANUAL');
  await order(page, 'AI decides', 'Let the daemon decide');
  await isSession(daemon, sessionId, 'the daemon decides', ({ mode }) => mode === 'MODE_AI');
  await until('the order is disabled, because the daemon decides already', () => page.getByRole('button', { name: 'AI decides' }).isDisabled());
  await page.getByRole('button', { name: 'Pin this algorithm', exact: true }).click();
  await page.getByRole('dialog').getByRole('button', { name: 'Cancel' }).click();
  assert.ok((await sessionsOf(daemon)).some((session) => session.sessionId === sessionId && session.mode === 'MODE_AI'), 'a cancelled order was executed');
}

// After "Reconnect" the game connects again, and its session continues.
async function checkReconnect(page, daemon, { sessionId }) {
  const resumed = async () => Number(/^sweepstake_resumed_sessions_total (\d+)$/m.exec(await (await fetch(`${daemon.origin}/metrics`)).text())[1]);
  const before = await resumed();
  await order(page, 'Reconnect', 'Reconnect');
  await page.locator('.toast', { hasText: 'The connection was ended.' }).waitFor();
  await until('a session was resumed', async () => await resumed() === before + 1);
  await isSession(daemon, sessionId, 'it is this one', ({ state }) => state === 'SESSION_STATE_CONNECTED');
  await page.locator('.facts .chip', { hasText: 'connected' }).waitFor();
}

async function checkKick(page, daemon, { sessionId }) {
  await order(page, 'End session', 'End session');
  await until('the session has ended', async () => (await sessionsOf(daemon)).every((session) => session.sessionId !== sessionId));
  await page.locator('.chip', { hasText: 'kicked' }).waitFor();
  // The posteriors after its last decision are those of its log.
  const rows = (await daemon.responses('AuditService/ExportDecisions', { filter: { sessionId } })).flatMap((response) => response.rows ?? []);
  const { posteriors } = rows.filter(({ decision }) => decision).at(-1).decision;
  await page.getByRole('button', { name: 'Read again' }).click();
  const figures = async () => {
    const [file] = await Promise.all([page.waitForEvent('download'), chart(page, 'prior').getByRole('link', { name: /CSV/ }).click()]);
    return readFileSync(await file.path(), 'utf8').trim().split('\r\n').slice(-posteriors.length).map((line) => line.split(','));
  };
  await until('the figures are those of the log', async () => JSON.stringify((await figures()).map((cells) => [Number(cells[4]), Number(cells[5])])) === JSON.stringify(posteriors.map(({ alpha, beta }) => [alpha, beta])), 20_000);
  assert.equal(await page.getByRole('button', { name: 'Pin this algorithm' }).count(), 0, 'an ended session has buttons for orders');
}

// ---- The decisions.

async function checkDecisions(page, daemon, { sessionId }) {
  await page.goto(`${daemon.origin}/decisions`);
  await page.getByRole('region', { name: 'Rows' }).waitFor();
  await page.getByRole('button', { name: 'Older' }).click();
  await until('the page is in the URL', () => query(page).has('older'));
  await page.getByRole('button', { name: 'Newest' }).click();
  await page.getByRole('link', { name: 'Sessions with a log' }).click();
  await page.getByRole('link', { name: sessionId }).first().click();
  await page.getByRole('region', { name: 'Rows' }).waitFor();
  const all = await rowsOf(page, 'Rows');
  assert.ok(all.length > 5 && all.every((row) => row['In words'].length > 10));
  await page.getByLabel('Kind').selectOption('order');
  await until('orders only', async () => { const rows = await rowsOf(page, 'Rows'); return rows.length === 4 && rows.every(({ Kind }) => Kind?.includes('order')); });
  assert.match((await rowsOf(page, 'Rows')).map((row) => row['In words']).join(' '), /keep to SAP.*let the daemon decide|let the daemon decide.*keep to SAP/);
  await page.goBack();
  await page.getByRole('region', { name: 'Rows' }).locator('tbody th a').first().click();
  await page.locator('.why').waitFor();
  const address = page.url();
  await page.goto(daemon.origin);
  await page.goto(address);
  await page.locator('.why').waitFor();
}

// Opens a session with some thousand decisions in a new browser context, whose cache is empty, and counts the bytes that arrive until its
// charts are drawn.
async function checkFirstScreen(browser, daemon, { sessionId }) {
  const context = await browser.newContext();
  const page = await context.newPage();
  const client = await context.newCDPSession(page);
  await client.send('Network.enable');
  const received = new Map(); // bytes by request, also of streams that go on
  client.on('Network.dataReceived', ({ requestId, encodedDataLength }) => received.set(requestId, (received.get(requestId) ?? 0) + encodedDataLength));
  client.on('Network.loadingFinished', ({ requestId, encodedDataLength }) => received.set(requestId, encodedDataLength));
  await page.goto(`${daemon.origin}/sessions/${sessionId}`);
  await chart(page, 'frame-time').locator('.u-over').waitFor();
  await hasPeriods(chart(page, 'timeline'));
  const byteCount = [...received.values()].reduce((sum, bytes) => sum + bytes, 0);
  console.log(`the first screen of the session moves ${byteCount} bytes, ${await page.getByText(/^[\d,]+ decisions$/).innerText()}`);
  assert.ok(byteCount <= 200_000, `the first screen moves ${byteCount} bytes`);
  await page.getByRole('button', { name: 'Read older rows' }).click();
  await until('older rows are read', async () => numberIn(await page.locator('.row-count').innerText()) > 1000);
  await context.close();
}

// ---- Roles.

async function checkRoles(context, folder) {
  const daemon = new RealDaemon(sweepstaked, join(folder, 'tokens'), ['--require-tokens']);
  const watcher = daemon.makeToken('reader', 'watch');
  const player = join(folder, 'tokens', 'player.token');
  daemon.makeToken('player', 'ingest');
  await daemon.start();
  const game = new Game(sweepstake, daemon, 'arcade', 'arena', { more: ['--allow-orders', '--allow-box-view', '--token-file', player] });
  const page = await openPage(context, daemon.origin);
  await page.getByLabel('Token').fill(watcher);
  await page.getByRole('button', { name: 'Log in' }).click();
  await page.getByRole('link', { name: 'arena', exact: true }).click();
  await page.getByRole('region', { name: 'Sessions' }).locator('tbody a').first().click();
  await page.getByText('Orders need the role operator; yours is watch.').waitFor();
  assert.equal(await page.getByRole('button', { name: 'Pin this algorithm' }).count(), 0);
  await page.getByText('Viewing boxes needs the role operator; yours is watch.').waitFor();
  assert.ok(await page.getByRole('button', { name: 'Show boxes' }).isDisabled());
  const sessionId = new URL(page.url()).pathname.split('/').at(-1);
  for (const [method, request] of [['OrderSession', { mode: 'MODE_AI' }], ['KickSession', { mayReturn: true }], ['KickSession', {}]]) {
    assert.equal(await refusalOf(page, `SessionsService/${method}`, { sessionId, ...request }), 403, `the daemon refuses ${method}, which the page does not offer`);
  }
  const boxes = await expecting(page, refused(403), () => page.evaluate(async (id) =>
    (await fetch(`/events/sweepstake.v1.SessionsService/WatchBoxes?request=${encodeURIComponent(JSON.stringify({ sessionId: id }))}`)).status, sessionId));
  assert.equal(boxes, 403, 'a reader may watch boxes');
  assertNoTrouble(page, 'a reader');
  await page.close();
  await game.quit();
  await daemon.stop();
}

async function checkAll(browser, folder) {
  const daemon = await new RealDaemon(sweepstaked, join(folder, 'main')).start();
  const front = await (await fetch(daemon.origin)).text();
  if (/without the dashboard/.test(front)) {
    await daemon.stop();
    return front;
  }
  await new Game(sweepstake, daemon, 'arcade', 'arena', { duration: '4s' }).ended();
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true });
  const page = await openPage(context, daemon.origin);
  const passed = (check) => console.log(`${check.name}: passed`);
  for (const check of [checkNumbers, checkNeverRan, checkFiles]) passed((await check(page, daemon), check));
  const game = new Game(sweepstake, daemon, 'arcade', 'arena', { more: ['--allow-orders', '--allow-box-view'] });
  const session = await liveSession(daemon);
  for (const check of [checkTime, checkWhy, checkLog, checkLogAway, checkCosts, checkCompare, checkUnknown, checkBoxes, checkOrders, checkReconnect, checkKick, checkDecisions]) passed((await check(page, daemon, session), check));
  await assertAccessible(page, 'decisions');
  passed((await checkFirstScreen(browser, daemon, session), checkFirstScreen));
  passed((await checkRegimes(page, daemon), checkRegimes));
  assertNoTrouble(page, 'the views');
  await page.close();
  await game.quit();
  await daemon.stop();
  passed((await checkRoles(context, folder), checkRoles));
  return '';
}

await runInBrowser('views', checkAll);
