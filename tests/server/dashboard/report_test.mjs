// The reports as a reader sees them: made by the program, opened from a file in Chromium, without network.
//
//   node report_test.mjs PROGRAM
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const program = process.argv[2];
const chromiumPath = process.env.CHROMIUM ?? '/usr/bin/chromium';
const require = createRequire(new URL('../../../server/dashboard/package.json', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'sweepstake_report_'));
const file = (name) => join(folder, name);

function skip(why) {
  rmSync(folder, { recursive: true });
  console.log(`skipped: ${why}`);
  process.exit(process.env.SWEEPSTAKE_REQUIRE_PAGE ? 1 : 77);
}

function sweepstake(...words) {
  try {
    return execFileSync(program, words, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'], maxBuffer: 1e9 });
  } catch (error) {
    if (error.status === 3 && /without the page/.test(error.stderr)) skip(error.stderr.trim());
    throw error;
  }
}

function makeReports() {
  sweepstake('bench', '--scene', 'suite-b,suite-g', '--objects', '100,300', '--frames', '10', '--arms', 'all', '--report', file('bench.html'));
  sweepstake('experiment', '--scenes', 'brownian', '--objects', '60', '--time-scale', '1000', '--window', '3m', '--runs', '2',
    '--trace-frames', '64', '--replay-seeds', '2', '--out', file('out'), '--report', file('experiment.html'));
  sweepstake('replay', '--costs', file('out/traces/brownian-60.costs'), '--policy', 'default,paper,fixed,oracle', '--seeds', '3',
    '--run', '1m', '--report', file('replay.html'));
}

const documentsOf = (html) => JSON.parse(/id="documents">(.*?)<\/script>/s.exec(html)[1]);

// Opens a report and hands its page and its document to `check`; nothing may be loaded and nothing may go wrong.
async function inBrowser(context, name, check) {
  const page = await context.newPage();
  const troubles = [];
  page.on('console', (message) => message.type() === 'error' && troubles.push(message.text()));
  page.on('pageerror', (error) => troubles.push(error.message));
  page.on('request', (request) => request.url().startsWith('file:') || troubles.push(`asked for ${request.url()}`));
  await page.goto(`file://${file(`${name}.html`)}`);
  const documents = documentsOf(readFileSync(file(`${name}.html`), 'utf8'));
  assert.equal(documents.length, 1);
  await check(page, documents[0]);
  await checkTheme(page);
  assert.deepEqual(troubles, [], name);
  await page.close();
  console.log(`${name}: passed`);
}

const count = (page, selector) => page.locator(selector).count();
const rowsOf = (page, id) => count(page, `#${id} tbody tr:not(.heading)`);

async function checkTheme(page) {
  const background = () => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
  await page.getByLabel('Light').check({ force: true });
  const light = await background();
  await page.getByLabel('Dark').check({ force: true });
  assert.notEqual(await background(), light, 'the switch changes the theme');
}

// A chart answers to the pointer and to the arrow keys.
async function checkTip(page, figure, expected) {
  await page.locator(`${figure} .point`).first().hover();
  assert.match(await page.locator(`${figure} .tip`).innerText(), expected);
  await page.mouse.move(0, 0);
  await page.locator(`${figure} svg`).first().focus();
  await page.keyboard.press('ArrowRight');
  assert.match(await page.locator(`${figure} .tip`).innerText(), expected);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator(`${figure} .tip`).isHidden(), true);
}

async function checkBench(page, { rows }) {
  assert.equal(await count(page, 'figure svg.picture'), 2, 'a chart per scene');
  assert.equal(await count(page, 'figure .point'), rows.length);
  assert.equal(await rowsOf(page, 'rows'), rows.length);
  assert.equal(await rowsOf(page, 'times'), 7);
  assert.equal(await rowsOf(page, 'fastest'), 4);
  const fastest = Math.min(...rows.filter(({ scene, objects }) => scene === 'suite-b' && objects === 100).map((row) => row.ms_median));
  assert.equal(Number(await page.locator('#fastest tbody tr:not(.heading) td').nth(1).innerText()), Number(fastest.toPrecision(3)));
  await checkTip(page, '#chart-1', /objects: .* ms/);
  await page.locator('#chart-1 .legend input').first().uncheck();
  assert.equal(await count(page, '#chart-1 .point'), rows.length / 2 - 2, 'a line that is hidden is gone');
  await checkSorting(page);
}

async function checkSorting(page) {
  await page.locator('#raw summary').click();
  const medians = async () => (await page.locator('#rows tbody').first().locator('tr:not(.heading) td:nth-child(5)').allInnerTexts()).map(Number);
  await page.locator('#rows thead button', { hasText: 'Median' }).click();
  const sorted = await medians();
  assert.deepEqual(sorted, [...sorted].sort((a, b) => a - b));
  assert.equal(await count(page, '#rows [aria-sort=ascending]'), 1);
}

async function checkExperiment(page, { rows, runs, truths, arms, over_cells }) {
  assert.equal(rows.length, 2);
  assert.equal(await count(page, '.panel svg'), runs.length, 'a panel of posteriors per run');
  assert.equal(await count(page, '#timeline-1 .point'), runs.reduce((sum, { periods, bail_outs }) => sum + periods.length + bail_outs.length, 0));
  assert.equal(await count(page, '#regret-over-cells .point'), truths[0].players.length);
  assert.equal(await rowsOf(page, 'regret-table'), truths[0].players.length);
  assert.equal(await count(page, '#ranking tbody .chip'), arms.length);
  const compared = await page.locator('#comparisons tbody').first().locator('tr:not(.heading)').count();
  assert.equal(compared, over_cells.length);
  for (const table of ['table-3', 'table-4', 'time-table', 'rows']) assert.equal(await rowsOf(page, table), rows.length, table);
  for (const chart of ['active-shares', 'verdict-shares', 'time-shares', 'agreement-regret', 'agreement-share']) {
    assert.ok(await count(page, `#${chart} .point`) >= rows.length, chart);
  }
  await checkTip(page, '#active-shares', /%/);
}

async function checkReplay(page, { rows, scenes }) {
  assert.equal(await count(page, '#regret-1 .point'), rows.length);
  assert.equal(await rowsOf(page, 'rows'), rows.length);
  assert.equal(await rowsOf(page, 'scenes'), scenes.length);
  await checkTip(page, '#regret-1', /after start-up/);
}

if (!existsSync(chromiumPath)) skip(`there is no ${chromiumPath}; deploy/install_packages.sh chromium installs it`);
makeReports();
const { chromium } = require('playwright-core');
const context = await chromium.launchPersistentContext(file('profile'), {
  executablePath: chromiumPath, offline: true, viewport: { width: 1240, height: 900 },
  args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync'],
});
try {
  await inBrowser(context, 'bench', checkBench);
  await inBrowser(context, 'experiment', checkExperiment);
  await inBrowser(context, 'replay', checkReplay);
} finally {
  await context.close();
  rmSync(folder, { recursive: true, force: true });
}
