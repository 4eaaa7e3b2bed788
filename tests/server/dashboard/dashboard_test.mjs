// Tests the dashboard with a real daemon and real games in Chromium.
//
//   node dashboard_test.mjs SWEEPSTAKED SWEEPSTAKE PICTURES
//
// Writes pictures of all views into the folder PICTURES.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { assertAccessible, assertNoTrouble, AWAY, chromiumPath, expecting, judge, launch, openPage, refusalOf, refused, rowsOf, useTheme } from './browser.mjs';
import { Game, pause, RealDaemon, until, watched } from './real_daemon.mjs';

const [sweepstaked, sweepstake, pictures] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'sweepstake_dashboard_'));
const MAX_FIRST_LOAD = 60_000;
const HOSTILE = '<img src=x onerror=alert(1)>\u202Egnp'.padEnd(126, 'W');  // 128 bytes, the longest allowed name
const SHOWN_HOSTILE = HOSTILE.replace('\u202E', '⟨U+202E⟩');
assert.equal(Buffer.byteLength(HOSTILE), 128);

function skip(why) {
  rmSync(folder, { recursive: true, force: true });
  console.log(`skipped: ${why}`);
  process.exit(process.env.REQUIRE_REPORT_PAGE ? 1 : 77);
}

const daemonIn = (name, flags) => new RealDaemon(sweepstaked, join(folder, name), flags);
const badge = (page) => page.locator('.badge').getAttribute('data-status');
const isBadge = (page, status, patienceMs) => until(`the badge says ${status}`, async () => await badge(page) === status, patienceMs);
const rowOf = (page, scene) => page.locator('section[aria-labelledby=scenes-heading] tbody tr[data-key]', { has: page.getByRole('link', { name: scene, exact: true }) });
const cellsOf = async (page, scene) => {
  const titles = await page.locator('section[aria-labelledby=scenes-heading] thead th').allInnerTexts();
  const cells = await rowOf(page, scene).locator('th, td').allInnerTexts();
  return Object.fromEntries(titles.map((title, i) => [title.replace(/ [▲▼]$/, '').trim(), (cells[i] ?? '').trim()]));
};

// ---- The checks. Each ends with an assertion that nothing went wrong on its page.

// The first view is smaller than MAX_FIRST_LOAD.
async function checkSize(context, daemon) {
  const page = await context.newPage();
  const sizes = [];
  page.on('response', (response) => {
    const path = new URL(response.url()).pathname;
    if (path === '/' || path.startsWith('/assets/')) sizes.push(Number(response.headers()['content-length']));
  });
  await page.goto(daemon.origin);
  await page.getByRole('heading', { name: 'Scenes' }).waitFor();
  const total = sizes.reduce((sum, size) => sum + size, 0);
  assert.ok(sizes.length >= 3 && total > 10_000 && total < MAX_FIRST_LOAD, `${sizes} bytes`);
  console.log(`first load: ${total} bytes in ${sizes.length} files`);
  await page.close();
}

// Measures how long a browser without a cache takes to its first chart.
async function checkFirstChart(browser, daemon) {
  const context = await browser.newContext();
  await context.addInitScript(() => {
    const look = () => { if (document.querySelector('main figure svg.picture, main figure canvas')) globalThis.firstChartMs ??= performance.now(); };
    new MutationObserver(() => requestAnimationFrame(look)).observe(document, { subtree: true, childList: true });
  });
  const page = await openPage(context, daemon.origin, '/scenes/arcade/arena?class=test&reward=3');
  judge('the first chart without a cache', await until('there is a chart', () => page.evaluate(() => globalThis.firstChartMs)), 1000);
  assertNoTrouble(page, 'the first chart');
  await context.close();
}

// The overview shows the numbers that the command line computes from the same posteriors.
async function checkNumbers(page, daemon) {
  const scenes = watched(sweepstake, daemon);
  assert.ok(scenes.length >= 2);
  for (const scene of scenes) {
    const name = scene.scene === HOSTILE ? SHOWN_HOSTILE : scene.scene;
    const cells = await until(`the page has the daemon's numbers of ${name}`, async () => {
      const shown = await cellsOf(page, name);
      const evidence = scene.arms.reduce((sum, { windows, lane_visits: visits }) => sum + windows + visits, 0);
      return shown.Measurements?.replaceAll(',', '') === String(evidence) && shown.Sessions === String(scene.active_sessions) && shown;
    });
    assert.equal(cells.Verdict.replace(/^\S+ /, ''), scene.verdict, name);
    if (scene.verdict === 'changing') continue;
    assert.equal(cells.Best, scene.leader_arm || 'none', name);
    const leader = scene.arms.find(({ arm }) => arm === scene.leader_arm);
    if (leader) {
      assert.equal(cells['P(best)'], leader.best_probability.toFixed(3), name);
      const loss = Number.parseFloat(cells.Loss.replaceAll(',', '')) / 100;
      assert.ok(Math.abs(loss - scene.expected_loss_ratio) <= Math.max(0.0051 * loss, 0.000051), `${name}: ${cells.Loss}, ${scene.expected_loss_ratio}`);
    }
  }
}

// The preview of a link in a chat program names the scene, and names are escaped.
async function checkUnfurls(daemon) {
  const titleOf = async (path) => /<meta property="og:title" content="([^"]*)">/.exec(await (await fetch(`${daemon.origin}${path}`)).text())[1];
  assert.equal(await titleOf('/scenes/arcade/arena?class=test&reward=3'), 'arcade / arena · Sweepstake');
  assert.equal(await titleOf('/'), 'Sweepstake');
  assert.equal(await titleOf(`/scenes/arcade/${encodeURIComponent('"><script>')}`), 'arcade / &quot;&gt;&lt;script&gt; · Sweepstake');
}

async function checkHostileNames(page) {
  const link = page.locator('section[aria-labelledby=scenes-heading]').getByRole('link', { name: SHOWN_HOSTILE, exact: true });
  assert.equal(await link.count(), 1);
  assert.equal(await page.locator('main img').count(), 0, 'a name became markup');
  await link.click();
  await page.getByRole('heading', { level: 1 }).waitFor();
  assert.ok((await page.title()).includes(SHOWN_HOSTILE));
  assert.ok((await page.locator('main').innerText()).includes(SHOWN_HOSTILE));
  await page.goBack();
  await link.waitFor();
}

const SHOWS_ALL = ['--allow-orders', '--allow-box-view'];

// A scene is on the page within a second after the API has it.
async function checkLive(page, daemon) {
  const game = new Game(sweepstake, daemon, 'arcade', 'late', { more: SHOWS_ALL });
  const find = async () => (await daemon.call('PosteriorsService/ListPosteriors')).scenes?.find(({ scene, activeSessionCount }) => scene === 'late' && activeSessionCount === 1);
  await until('the API knows the new scene', find);
  const start = Date.now();
  await rowOf(page, 'late').waitFor();
  judge('a new scene is on the page', Date.now() - start, 1000);
  return game;
}

const SAMPLES = 20;
const numberIn = (text) => Number(text?.replaceAll(',', '') ?? NaN);

// Measures the longest time from a change of a posterior in the API to the page. In the end the page has the same figures as the API.
async function checkUpdates(context, daemon) {
  const game = new Game(sweepstake, daemon, 'arcade', 'changing');
  const armsOf = () => watched(sweepstake, daemon).find(({ scene }) => scene === 'changing')?.arms ?? [];
  const evidence = () => armsOf().reduce((sum, { windows, lane_visits: visits }) => sum + windows + visits, 0);
  const page = await openPage(context, daemon.origin, '/?columns=all');
  const measure = async (view, shown) => {
    await until(`${view} has figures`, async () => await shown() > 0);
    let worst = 0;
    let told = 0;
    for (let i = 0; i < SAMPLES; ++i) {
      const before = told;
      told = await until('the posterior changes', () => { const now = evidence(); return now > before && now; });
      const start = Date.now();
      await until('the page has the change', async () => await shown() >= told);
      worst = Math.max(worst, Date.now() - start);
    }
    judge(`a changed posterior is on ${view}`, worst, 1000);
  };
  await measure('the overview', async () => numberIn((await cellsOf(page, 'changing')).Measurements));
  await page.goto(`${daemon.origin}/scenes/arcade/changing?class=test&reward=3&arms-columns=all`);
  await measure('the page of the scene', async () => (await rowsOf(page, 'Algorithms')).reduce((sum, row) => sum + numberIn(row.Windows) + numberIn(row['Shadow measurements']), 0));
  await game.quit();
  const said = armsOf().map(({ arm, best_probability: best, alpha, beta }) => [arm, best.toFixed(3), Number(alpha.toPrecision(5)), Number(beta.toPrecision(5))].join());
  await until('the page has the figures of gRPC', async () => (await rowsOf(page, 'Algorithms'))
    .map((row) => [row.Algorithm, row['P(best)'], numberIn(row['α']), numberIn(row['β'])].join()).sort().join('\n') === said.sort().join('\n'));
  assertNoTrouble(page, 'updates');
  await page.close();
}

const FIGURES = { 'Streams of games': 'sweepstake_open_streams', 'Sessions in memory': 'sweepstake_sessions', Watchers: 'sweepstake_open_watchers',
  'Refused switches': 'sweepstake_refused_switches_total', 'Frames that games dropped': 'sweepstake_dropped_frames_total',
  'Resumed sessions': 'sweepstake_resumed_sessions_total', 'Queued updates': 'sweepstake_store_queued_commits' };

// The health view shows the figures of /metrics.
async function checkHealth(page, daemon) {
  await page.goto(`${daemon.origin}/health`);
  const metrics = async () => new Map((await (await fetch(`${daemon.origin}/metrics`)).text()).split('\n').map((line) => line.split(' ')));
  const shown = async () => new Map(await page.locator('.figures-table tr').evaluateAll((rows) => rows.map(({ cells: [name, value] }) => [name.innerText, value.innerText])));
  await until('the figures are those of /metrics', async () => {
    const [exported, figures] = [await metrics(), await shown()];
    return Object.entries(FIGURES).every(([name, metric]) => numberIn(figures.get(name)) === Number(exported.get(metric)));
  });
  const [exported, figures] = [await metrics(), await shown()];
  for (const name of ['Streams of games', 'Sessions in memory', 'Watchers']) assert.ok(numberIn(figures.get(name)) > 0, name);
  assert.ok(figures.get('Open files').endsWith(` ${Number(exported.get('process_max_fds')).toLocaleString('en')}`), figures.get('Open files'));
  await until('decisions are counted', async () => Number.parseFloat((await shown()).get('Decisions')) > 0);
  await page.goBack();
}

// An update moves no row while the pointer is over the table.
async function checkRowsStay(page, daemon) {
  const names = () => page.locator('section[aria-labelledby=scenes-heading] tbody th').allInnerTexts();
  await page.locator('section[aria-labelledby=scenes-heading] thead').getByRole('button', { name: 'Changed' }).click();
  const before = await names();
  await page.locator('section[aria-labelledby=scenes-heading] tbody tr').first().hover();
  const game = new Game(sweepstake, daemon, 'arcade', 'a new one');
  await until('the new row is there', async () => (await names()).length > before.length);
  assert.deepEqual((await names()).slice(0, before.length), before, 'rows moved under the pointer');
  await page.keyboard.press('/');
  await page.keyboard.type('a new one');
  await until('the filter applies, under the pointer too', async () => (await names()).length === 1);
  await page.mouse.move(0, 0);
  await page.getByRole('searchbox').fill('');
  await game.quit();
}

// The daemon is restarted, then suspended.
async function checkReconnect(page, daemon) {
  await page.evaluate(() => { globalThis.marker = 'the same page'; });
  await isBadge(page, 'live');
  await expecting(page, AWAY, async () => {
    await daemon.stop();
    await isBadge(page, 'offline');
    assert.ok(await rowOf(page, 'arena').count(), 'the last known rows are still shown');
    await daemon.start();
    await isBadge(page, 'live');
  });
  await checkNumbers(page, daemon);
  daemon.freeze();
  await isBadge(page, 'stale');
  assert.equal(await page.locator('main.old').count(), 1, 'stale data is not marked');
  daemon.thaw();
  await isBadge(page, 'live');
  assert.equal(await page.evaluate(() => globalThis.marker), 'the same page', 'the page was reloaded');
}

// The URL contains filter and view, and opening it restores them.
async function checkAddress(page, daemon) {
  await page.goto(`${daemon.origin}/?q=aren`);
  await rowOf(page, 'arena').waitFor();
  assert.equal(await page.getByRole('searchbox').inputValue(), 'aren');
  assert.equal(await rowOf(page, SHOWN_HOSTILE).count(), 0, 'the filter leaves out other scenes');
  await page.getByLabel('Sessions').selectOption('online');
  assert.match(page.url(), /online=yes/);
  await page.goBack();
  assert.doesNotMatch(page.url(), /online/);
  await rowOf(page, 'arena').getByRole('link').click();
  await page.getByRole('heading', { level: 1 }).waitFor();
  assert.match(page.url(), /\/scenes\/arcade\/arena\?class=test&reward=3/);
  await page.goBack();
  await rowOf(page, 'arena').waitFor();
  assert.match(page.url(), /q=aren/);
  await page.goForward();
  assert.match(page.url(), /\/scenes\//);
}

async function checkKeys(page, daemon) {
  await page.goto(daemon.origin);
  await rowOf(page, 'arena').waitFor();
  await page.keyboard.press('?');
  await page.getByRole('dialog').getByText('Go to health').waitFor();
  await page.keyboard.press('Escape');
  assert.equal(await page.getByRole('dialog').count(), 0);
  await page.keyboard.press('/');
  await page.keyboard.type('arena');
  assert.match(page.url(), /q=arena/);
  await page.keyboard.press('Escape');
  await page.keyboard.press('g');
  await page.keyboard.press('h');
  await page.getByRole('heading', { name: 'Health of the daemon' }).waitFor();
  await page.goto(`${daemon.origin}/?sort=scene`);
  await rowOf(page, 'arena').getByRole('link').focus();
  const focused = () => page.evaluate(() => document.activeElement.closest('tr')?.getAttribute('aria-rowindex'));
  const first = Number(await focused());
  await page.keyboard.press('ArrowDown');
  await until('the next row has the focus', async () => Number(await focused()) === first + 1);
}

// Columns can be chosen with the keyboard. The URL has the choice, and the next visit shows the same columns.
async function checkColumns(page, daemon) {
  const titles = async () => (await page.locator('section[aria-labelledby=scenes-heading] thead th').allInnerTexts()).map((title) => title.trim());
  const has = (title, isThere) => until(`the column ${title}`, async () => (await titles()).includes(title) === isThere, 5000);
  await page.goto(`${daemon.origin}/?sort=scene`);
  await rowOf(page, 'arena').waitFor();
  const usual = await titles();
  const button = page.locator('section[aria-labelledby=scenes-heading]').getByRole('button', { name: /^Columns/ });
  await button.press('Enter');
  await page.getByRole('checkbox', { name: /^Loss/ }).press('Space');
  await has('Loss', true);
  await page.getByRole('checkbox', { name: /^Verdict/ }).uncheck();
  await has('Verdict', false);
  await assertAccessible(page, 'the list of columns');
  await page.keyboard.press('Escape');
  await until('the list is closed', async () => await page.getByRole('checkbox').count() === 0, 5000);
  assert.match(page.url(), /columns=scene%2Cruns%2C.*loss/);
  await page.goto(`${daemon.origin}/?sort=scene`);
  await has('Loss', true);
  await page.goto(`${daemon.origin}/?sort=scene&columns=sessions`);
  await has('Sessions', true);
  assert.deepEqual((await titles()).map((title) => title.replace(/ [▲▼]$/, '')), ['Scene', 'Sessions']);
  await button.click();
  await page.getByRole('button', { name: 'Usual columns' }).click();
  await until('the usual columns', async () => (await titles()).join() === usual.join(), 5000);
  assert.doesNotMatch(page.url(), /columns/);
  await page.keyboard.press('Escape');
}

async function checkDownload(page, daemon) {
  await page.goto(`${daemon.origin}/?sort=scene`);
  await rowOf(page, 'arena').waitFor();
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('link', { name: 'Scenes as CSV' }).click()]);
  const lines = readFileSync(await download.path(), 'utf8').split('\r\n');
  assert.match(lines[0], /^project,scene,machines,reward version,verdict,leader,/);
  assert.ok(lines.some((line) => line.startsWith('arcade,arena,')));
  assert.ok(lines.some((line) => line.includes(`,${HOSTILE},`)), 'the CSV file has names unchanged');
  assert.ok(lines.some((line) => line.includes(",'=1+2")), 'the CSV file has no formulas');
}

// ---- All views: with data, empty, and with errors; in both themes, from 320 px to 4K.

const SIZES = { wide: { width: 1440, height: 900 }, narrow: { width: 390, height: 844 }, small: { width: 320, height: 640 }, large: { width: 2560, height: 1440 } };

// A selector for each view that matches when the view shows data.
const ROWS = 'main tbody tr[data-key]';
const CURVE = 'main td.curve svg'; // figures of a rate need two readings
const FRAMES = 'figure[data-chart=frame-time] .u-over';
const SHOWN = { overview: ROWS, scene: 'figure[data-chart=best] .u-over', scenes: '.beside > div:nth-child(2) figure[data-chart=beliefs] svg.picture',
  session: FRAMES, sessions: `.beside > div:nth-child(2) ${FRAMES}`, why: 'section.why', boxes: '.boxes canvas', question: FRAMES, decisions: ROWS, rows: ROWS, row: '.why', priors: ROWS, health: CURVE };

async function viewsOf(daemon) {
  const { sessions = [] } = await daemon.call('SessionsService/ListSessions');
  const [session, other] = [0, 1].map((i) => sessions[i]?.sessionId ?? 'none');
  const scene = '/scenes/arcade/late?class=test&reward=3';
  return { overview: '/', scene, scenes: `${scene}&with=${encodeURIComponent('arcade\narena\ntest\n3')}`, session: `/sessions/${session}`,
    sessions: `/sessions/${session}?with=${other}`,
    why: `/sessions/${session}?decision=1`, boxes: `/sessions/${session}?boxes=on`, question: `/sessions/${session}`, decisions: '/decisions', rows: `/decisions?session=${session}`,
    row: `/decisions?session=${session}&row=${session}.1.3`, priors: '/priors', health: '/health' };
}

// Takes a picture of the whole page. The event for printing makes charts outside the screen redraw.
async function drawWhole(page, path) {
  await page.evaluate(() => new Promise((resolve) => {
    dispatchEvent(new Event('beforeprint'));
    requestAnimationFrame(() => setTimeout(resolve));
  }));
  await page.screenshot({ path, fullPage: true });
}

async function checkViews(browser, daemon) {
  for (const [size, viewport] of Object.entries(SIZES)) {
    const context = await browser.newContext({ viewport, reducedMotion: 'reduce' });
    for (const [name, path] of Object.entries(await viewsOf(daemon))) {
      const page = await openPage(context, daemon.origin);
      await page.goto(`${daemon.origin}${path}`);
      // The page has only the newest decisions of a long log, so the decision of the URL may be missing.
      if (name === 'why') await page.getByRole('button', { name: 'Why this algorithm?' }).click();
      await page.locator(SHOWN[name]).first().waitFor();
      for (const theme of ['light', 'dark']) {
        await useTheme(page, theme);
        if (name === 'question') await page.getByRole('button', { name: 'Pin this algorithm', exact: true }).click();
        await drawWhole(page, join(pictures, `${name}-${size}-${theme}.png`));
        await assertAccessible(page, `${name}, ${size}, ${theme}`);
        if (name === 'question') await page.keyboard.press('Escape');
      }
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}, ${size}: the page scrolls sideways`);
      assertNoTrouble(page, `${name}, ${size}`);
      await page.close();
    }
    await context.close();
  }
}

async function checkEmptyViews(context) {
  const daemon = await daemonIn('empty').start();
  const page = await openPage(context, daemon.origin);
  const paths = { ...await viewsOf(daemon), nowhere: '/scenes/one/two/three' };
  for (const [name, path] of Object.entries(paths)) {
    await page.goto(`${daemon.origin}${path}`);
    await isBadge(page, 'live');
    const text = await until(`${name} is empty`, async () => {
      const shown = await page.locator('main').innerText();
      return shown && !shown.includes('Loading') && shown;
    });
    assert.doesNotMatch(text, /NaN|undefined|null|Infinity/, name);
    if (name !== 'health') await page.locator('.state, .empty-chart').first().waitFor();
    await page.screenshot({ path: join(pictures, `${name}-empty.png`) });
    await assertAccessible(page, `${name}, empty`);
  }
  assertNoTrouble(page, 'empty views');
  await page.close();
  await daemon.stop();
}

const REFUSAL = { status: 503, contentType: 'application/json', body: '{"error":{"code":"UNAVAILABLE","reason":"STORE_BUSY","message":"the store has too much to do"}}' };

// The daemon refuses every request of a view, and the view shows the error.
async function checkErrors(context, daemon) {
  const page = await openPage(context, daemon.origin);
  const views = Object.entries(await viewsOf(daemon));
  // The page repeats its requests, between the views too.
  await expecting(page, refused(REFUSAL.status), async () => {
    for (const pattern of ['**/api/sweepstake*/**', '**/events/**', '**/metrics', '**/readyz*']) await page.route(pattern, (route) => route.fulfill(REFUSAL));
    for (const [name, path] of views) {
      await page.goto(`${daemon.origin}${path}`);
      await isBadge(page, 'offline');
      await page.getByText('the store has too much to do').first().waitFor();
      await page.screenshot({ path: join(pictures, `${name}-error.png`) });
      await assertAccessible(page, `${name}, in error`);
    }
    await page.close();
  });
  assertNoTrouble(page, 'views in error');
}

// The page lists an alert of the daemon. An operator mutes it with the keyboard, and ends the silence.
async function checkAlerts(context, daemon) {
  const game = new Game(sweepstake, daemon, 'puzzle', 'fixed', { mode: 'manual', more: ['--arm', 'Grid'] });
  const page = await openPage(context, daemon.origin);
  const item = page.locator('section.attention li', { hasText: 'manual mode' });
  const button = (name) => item.getByRole('button', { name, exact: true });
  await button('Mute fixed').waitFor();
  assert.equal(await item.getByRole('link', { name: 'fixed' }).getAttribute('href'), '/scenes/puzzle/fixed?class=test&reward=3');
  await page.setViewportSize({ width: 320, height: 640 });
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'the list is too wide for 320 px');
  await button('Mute fixed').focus();
  await page.keyboard.press('Enter');
  await page.getByLabel('Comment').fill('a known test');
  await assertAccessible(page, 'muting an alert');
  await page.screenshot({ path: join(pictures, 'mute.png') });
  await page.getByRole('button', { name: '1 hour' }).press('Enter');
  await item.getByText('a known test').waitFor();
  await assertAccessible(page, 'a muted alert');
  const find = async () => (await daemon.call('AlertsService/ListAlerts')).alerts.find(({ rule, scene }) => rule === 'manual' && scene === 'fixed');
  assert.equal((await find()).silence.comment, 'a known test');
  await button('Unmute fixed').press('Enter');
  await button('Mute fixed').waitFor();
  assert.equal((await find()).silence, undefined);
  await page.evaluate(() => document.activeElement.blur());  // the list stays while the focus is in it
  await game.quit();
  await item.waitFor({ state: 'detached' });
  assertNoTrouble(page, 'alerts');
  await page.close();
}

// ---- Login and roles.

// All requests of the page are below the base path.
async function checkLogin(context) {
  const base = '/tools/sweepstake';
  const daemon = daemonIn('tokens', ['--require-tokens', '--http-base', base]);
  const token = daemon.makeToken('reader', 'watch');
  const boss = daemon.makeToken('boss', 'operator');
  await daemon.start();
  const page = await openPage(context, `${daemon.origin}${base}`, '/decisions?q=a');
  await page.getByLabel('Token').fill('wrong');
  await page.screenshot({ path: join(pictures, 'login.png') });
  await assertAccessible(page, 'login');
  await expecting(page, refused(401), async () => {
    await page.getByRole('button', { name: 'Log in' }).click();
    await page.locator('.problem', { hasText: /./ }).waitFor();
  });
  const logIn = async (as) => {
    await page.getByLabel('Token').fill(as);
    await page.getByRole('button', { name: 'Log in' }).click();
    await isBadge(page, 'live');
  };
  await logIn(token);
  const kept = await page.evaluate(() => JSON.stringify([document.cookie, { ...localStorage }, { ...sessionStorage }]));
  assert.ok(!kept.includes(token), 'scripts can read the token in cookies or storage');
  assert.equal(await page.evaluate(() => document.cookie), '', 'scripts can read the cookie');
  assert.deepEqual((await context.cookies()).map(({ path }) => path), [`${base}/`]);
  for (const [link, path] of [['Health', '/health'], ['Sweepstake', '/'], ['Decisions', '/decisions']]) {
    await page.getByRole('link', { name: link, exact: true }).click();
    assert.equal(new URL(page.url()).pathname, `${base}${path}`);
  }
  await page.reload();
  await page.getByRole('heading', { name: 'Decisions', level: 1 }).waitFor();
  const order = ['SessionsService/OrderSession', { sessionId: 'any', mode: 'MODE_AI' }];
  assert.equal(await refusalOf(page, ...order), 403, 'a token with the role watch may give orders');
  await page.evaluate(() => { globalThis.marker = 'the same page'; });
  await expecting(page, new RegExp(`${AWAY.source}|${refused(401).source}`), async () => {
    await daemon.stop();
    await isBadge(page, 'offline');
    await daemon.start();
    await page.getByLabel('Token').waitFor();
  });
  assert.equal(await page.evaluate(() => globalThis.marker), 'the same page', 'the page was reloaded');
  await logIn(token);
  // A stream that connects again at this moment is refused.
  const logOut = (name) => expecting(page, refused(401), async () => {
    await page.getByRole('button', { name }).click();
    await page.getByRole('button', { name: 'Log out' }).click();
    await page.getByLabel('Token').waitFor();
    await pause(500);
  });
  await logOut('reader');
  await logIn(boss);
  assert.equal(await expecting(page, refused(404), () => refusalOf(page, ...order)), 404, 'the operator may order, but the session does not exist');
  assert.equal(await refusalOf(page, ...order, {}), 403, 'a request without the header that other sites cannot set is accepted');
  await logOut('boss');
  assertNoTrouble(page, 'login');
  await page.close();
  await daemon.stop();
}

async function checkAll(browser) {
  const daemon = await daemonIn('main').start();
  const front = await (await fetch(daemon.origin)).text();
  if (/without the dashboard/.test(front)) {
    await daemon.stop();
    return front;
  }
  await Promise.all([['arcade', 'arena'], ['arcade', HOSTILE], ['puzzle', '=1+2']].map(([project, scene]) =>
    new Game(sweepstake, daemon, project, scene, { duration: '4s' }).ended()));
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true });
  await checkSize(context, daemon);
  await checkUnfurls(daemon);
  await checkFirstChart(browser, daemon);
  const page = await openPage(context, daemon.origin, '/?columns=all');
  await checkNumbers(page, daemon);
  await checkUpdates(context, daemon);
  const game = await checkLive(page, daemon);
  const other = new Game(sweepstake, daemon, 'arcade', 'late', { more: ['--build', '1.4.0-rc2', ...SHOWS_ALL] });
  await until('two sessions are connected', async () => (await daemon.call('SessionsService/ListSessions')).sessions?.length >= 2);
  await checkHostileNames(page);
  await checkHealth(page, daemon);
  await checkRowsStay(page, daemon);
  await checkViews(browser, daemon);
  await checkAlerts(context, daemon);
  await game.quit();
  await other.quit();
  for (const check of [checkAddress, checkKeys, checkColumns, checkDownload]) {
    await check(page, daemon);
    console.log(`${check.name}: passed`);
  }
  await page.goto(`${daemon.origin}/?columns=all`);
  await checkReconnect(page, daemon);
  assertNoTrouble(page, 'the dashboard');
  await page.close();
  await checkErrors(context, daemon);
  await daemon.stop();
  await checkEmptyViews(context);
  await checkLogin(context);
  return '';
}

if (!existsSync(chromiumPath)) skip(`there is no ${chromiumPath}; deploy/install_packages.sh chromium installs it`);
mkdirSync(pictures, { recursive: true });
const browser = await launch();
// Takes pictures of the open pages after a failed check.
async function drawFailure(error) {
  const pages = browser.contexts().flatMap((context) => context.pages());
  for (const [i, page] of pages.entries()) {
    console.error(page.url(), page.troubles);
    await page.screenshot({ path: join(pictures, `failure-${i}.png`) }).catch(() => console.error('cannot be drawn'));
  }
  throw error;
}

let missing = '';
try {
  missing = await checkAll(browser).catch(drawFailure);
} finally {
  await browser.close();
}
if (missing) skip(missing);
rmSync(folder, { recursive: true, force: true });
