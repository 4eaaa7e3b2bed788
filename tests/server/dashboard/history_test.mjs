// Tests that the page does not contradict itself, the daemon or its past, with a real daemon and nine real games whose scenes change
// regime: in each sample headline, active algorithm, verdict and list of switches agree, and the first figure is that of the history.
// The history survives a reload and a restart of the daemon.
//
//   node history_test.mjs SWEEPSTAKED SWEEPSTAKE [MINUTES]      default: 10 minutes
import assert from 'node:assert/strict';
import { join } from 'node:path';

import { assertAccessible, assertNoTrouble, AWAY, expecting, openPage, rowsOf, runInBrowser } from './browser.mjs';
import { Game, pause, RealDaemon, until } from './real_daemon.mjs';

const [sweepstaked, sweepstake, minutes = '10'] = process.argv.slice(2);
const SAMPLES = 30;
const SCENES = ['rest-and-motion', 'waves', 'storms', 'gather-and-scatter', 'day-and-night', 'arrivals'];
const GAMES = 9;
const PROJECT = 'history';
const MOST_SWITCHES = 4; // per minute in a stable scene

const nameOf = (i) => `${SCENES[i % SCENES.length]} ${i + 1}`;
const sceneUrl = (daemon, name) => `${daemon.origin}/scenes/${PROJECT}/${encodeURIComponent(name)}?class=test&reward=3`;

async function historyOf(daemon, kind, more = {}) {
  const answers = await daemon.responses('HistoryService/GetHistory', { kind: `HISTORY_KIND_${kind}`, maxPoints: 1, ...more });
  return answers.flatMap(({ series = [] }) => series);
}

// Reads everything in one task of the browser, so that all texts belong to one moment.
const readMoment = (page) => page.evaluate(() => ({
  active: document.querySelector('.runs-now bdi')?.innerText,
  runs: document.querySelector('.runs-now')?.innerText ?? '',
  verdict: document.querySelector('.runs-now + p .chip')?.innerText.replace(/^\W+/, '') ?? '',
  headline: document.querySelector('.runs-now + p')?.innerText ?? '',
  leader: document.querySelector('.runs-now + p b bdi')?.innerText,
  regimes: [...document.querySelectorAll('section[aria-labelledby=regimes-heading] tbody tr')].map(({ cells }) => [cells[0].innerText, cells[3]?.innerText.trim()]),
}));

// Fails if the texts of a scene's page contradict one another.
function checkMoment(name, { active, runs, verdict, headline, leader, regimes }) {
  const what = `${name}: ${runs} ${headline} ${JSON.stringify(regimes)}`;
  assert.ok(active, what);
  const switches = Number(/switched (\d+) time/.exec(runs)?.[1]);
  assert.ok(Number.isInteger(switches), what);
  const best = new Set(regimes.filter(([regime]) => regime !== 'all').map(([, arm]) => arm));
  if (best.size > 1) assert.equal(verdict, 'changing', `regimes have different best algorithms. ${what}`);
  if (verdict === 'stable') assert.ok(switches <= MOST_SWITCHES, `a stable scene does not switch. ${what}`);
  if (verdict === 'stable' && best.size === 1) assert.ok(best.has(leader), `the leader is the best algorithm of the only regime. ${what}`);
  return verdict;
}

// The page shows the algorithm that the daemon reports, at most a few seconds after a switch.
async function checkActive(page, daemon, name) {
  await until(`the page of ${name} shows the algorithm that runs`, async () => {
    const sessions = (await daemon.responses('SessionsService/ListSessions')).flatMap(({ sessions: all }) => all);
    return sessions.find(({ scene }) => scene === name).activeArm === (await readMoment(page)).active;
  }, 10_000);
}

// The active algorithm of each session becomes that of its latest switch in the audit log, which is written a little later.
async function checkSwitches(daemon) {
  const sessions = async () => (await daemon.responses('SessionsService/ListSessions')).flatMap(({ sessions: all }) => all);
  for (const { sessionId, scene } of await sessions()) {
    await until(`the session of ${scene} runs the algorithm of its latest switch`, async () => {
      const [{ rows = [] }] = await daemon.responses('AuditService/ListDecisions', { filter: { sessionId, kinds: ['AUDIT_KIND_SWITCH'] }, pageSize: 1 });
      return rows.length === 0 || rows[0].arm === (await sessions()).find((each) => each.sessionId === sessionId).activeArm;
    }, 20_000);
  }
}

const number = (text) => Number(text.replaceAll(',', '').split(' ')[0]);

// The first figure is the saving of the history, computed here from its sums.
async function checkSaving(page, daemon) {
  await page.goto(daemon.origin);
  await until('the first figure', async () => /\d/.test(await page.locator('.figure.main b').innerText()));
  const isLoss = (await page.locator('.figure.main span').innerText()).startsWith('lost per frame');
  const shown = (isLoss ? -1 : 1) * number(await page.locator('.figure.main b').innerText());
  let [saved, frames] = [0, 0];
  for (const { points: [point] } of await historyOf(daemon, 'SCENE', { fromUnixMs: String(Date.now() - 86_400_000) })) {
    saved += point.initialUs - point.ranUs;
    frames += Number(point.frameCount);
  }
  assert.ok(Math.abs(shown - saved / frames) <= 0.05 * Math.abs(saved / frames) + 0.1, `the page shows ${shown} µs, and the history has ${saved / frames}`);
}

// Fails unless the charts of a scene have the past.
async function checkPast(page, daemon, name, startMs) {
  await page.goto(sceneUrl(daemon, name));
  const figure = page.locator('[data-chart=ran]');
  await figure.getByRole('button', { name: 'Table' }).click();
  const first = await until('the table of the chart', () => figure.locator('tbody tr').first().innerText());
  const firstMs = new Date(first.split('\t')[0].trim()).getTime();
  assert.ok(Math.abs(firstMs - startMs) < 60_000, `the history begins at ${first}, and the games at ${new Date(startMs).toISOString()}`);
}

async function check(browser, folder) {
  const daemon = await new RealDaemon(sweepstaked, join(folder, 'daemon')).start();
  const startMs = Date.now();
  const games = Array.from({ length: GAMES }, (_, i) => new Game(sweepstake, daemon, PROJECT, nameOf(i),
    { plays: SCENES[i % SCENES.length], scale: 4, more: ['--seed', String(i + 1), '--build', String(1 + (i % 2))] }));
  const page = await openPage(await browser.newContext(), daemon.origin);
  await until('all scenes are shown', async () => (await rowsOf(page, 'Scenes')).length === GAMES);
  const verdicts = [];
  for (let sample = 0; sample < SAMPLES; ++sample) {
    await pause((Number(minutes) * 60_000) / SAMPLES);
    const name = nameOf(sample % GAMES);
    await page.goto(sceneUrl(daemon, name));
    await page.locator('.runs-now').waitFor();
    verdicts.push(checkMoment(name, await readMoment(page)));
    await checkActive(page, daemon, name);
    await checkSwitches(daemon);
  }
  console.log(`verdicts: ${verdicts.join(' ')}`);
  assert.ok(verdicts.includes('changing'), 'no scene is changing');
  await checkSaving(page, daemon);
  await checkPast(page, daemon, nameOf(0), startMs);
  await assertAccessible(page, 'a scene with a history');
  await page.reload();
  await checkPast(page, daemon, nameOf(0), startMs);
  const before = await historyOf(daemon, 'BUILD');
  await expecting(page, AWAY, async () => {
    await daemon.stop();
    await daemon.start();
    await page.waitForTimeout(3000);
  });
  await checkPast(page, daemon, nameOf(0), startMs);
  const after = await historyOf(daemon, 'BUILD');
  assert.equal(after.length, before.length);
  for (const [i, { build, points: [point] }] of before.entries()) {
    assert.equal(after[i].build, build);
    assert.ok(Number(after[i].points[0].frameCount) >= Number(point.frameCount), 'the restart lost frames');
  }
  assertNoTrouble(page, 'the page');
  await Promise.all(games.map((game) => game.quit()));
  await daemon.stop();
}

await runInBrowser('history', check);
