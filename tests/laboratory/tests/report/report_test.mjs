// The reports as a reader sees them: made by the program, opened from a file in Chromium, without network.
//
//   node report_test.mjs SWEEPSTAKE_LAB
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { runInBrowser } from '../../../server/dashboard/browser.mjs';
import { bench, benchOfSets, degenerateBenches, degenerateExperiments, degenerateReplays, EVIL, fullBench, judgedReplay, partialExperiment } from './handmade.mjs';

const program = process.argv[2];
let folder;  // of the reports
const file = (name) => join(folder, name);

const laboratory = (...words) => execFileSync(program, words, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'], maxBuffer: 1e9 });

// Makes the report of what a command prints with --json.
function makeReport(name, ...words) {
  writeFileSync(file(`${name}.json`), laboratory(...words, '--json'));
  laboratory('report', file(`${name}.json`), '--out', file(`${name}.html`));
}

function makeReports() {
  makeReport('sets', 'bench', '--scene', 'suite-b', '--objects', '100,300', '--frames', '10', '--arms', 'SAP,Grid', '--simd', 'all');
  makeReport('bench', 'bench', '--scene', 'suite-b,suite-g', '--objects', '100,300', '--frames', '10', '--arms', 'all');
  makeReport('experiment', 'experiment', '--scenes', 'brownian', '--objects', '60', '--time-scale', '1000', '--window', '3m', '--runs', '2',
    '--trace-frames', '64', '--replay-seeds', '2', '--out', file('out'));
  makeReport('replay', 'replay', '--costs', file('out/traces/brownian-60-1.costs'), '--policy', 'default,paper,fixed,oracle', '--seeds', '3',
    '--run', '1m');
}

const DOCUMENTS = /(?<=id="documents">).*?(?=<\/script>)/s;
const documentsOf = (html) => JSON.parse(DOCUMENTS.exec(html)[0]);
const documentOf = (name) => documentsOf(readFileSync(file(`${name}.html`), 'utf8'))[0];

// Writes the report of documents that no program made.
function writeReport(name, ...documents) {
  const content = JSON.stringify(documents).replaceAll('<', '\\u003c');
  writeFileSync(file(`${name}.html`), readFileSync(file('bench.html'), 'utf8').replace(DOCUMENTS, () => content));
}

// Opens a report and hands its page and its document to `check`; nothing may be loaded and nothing may go wrong.
async function inBrowser(context, name, check) {
  const page = await context.newPage();
  const troubles = [];
  page.on('console', (message) => message.type() === 'error' && troubles.push(message.text()));
  page.on('pageerror', (error) => troubles.push(error.message));
  page.on('request', (request) => request.url().startsWith('file:') || troubles.push(`asked for ${request.url()}`));
  await page.goto(`file://${file(`${name}.html`)}`);
  const documents = documentsOf(readFileSync(file(`${name}.html`), 'utf8'));
  await check(page, documents[0]);
  assert.deepEqual(troubles, [], name);
  await page.close();
  console.log(`${name}: passed`);
}

const count = (page, selector) => page.locator(selector).count();
const rowsOf = (page, id) => count(page, `#${id} tbody tr:not(.heading)`);

// The marks with a text of their own, which the browser shows under the pointer.
const marks = (page, figure) => count(page, `${figure} svg g title`);

async function checkMark(page, figure, expected) {
  assert.match(await page.locator(`${figure} svg g title`).first().textContent(), expected);
}

async function checkBench(page, { rows }) {
  assert.equal(await count(page, 'figure svg.picture'), 2, 'a chart per scene');
  assert.equal(await marks(page, 'figure'), rows.length);
  assert.equal(await rowsOf(page, 'rows'), rows.length);
  assert.equal(await rowsOf(page, 'times'), 7);
  assert.equal(await count(page, '#times .best'), 4, 'the fastest of each cell is marked');
  assert.equal(await count(page, '#chart-1 .leader'), 7, 'a dotted line leads to each name');
  await checkMark(page, '#chart-1', /objects: .* ms/);
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

async function checkExperiment(page, { rows, runs, truths, arms, over_cells, paper, worth_text }) {
  assert.equal(paper.length, 9, 'the cells of the paper’s grid');
  assert.equal(rows.length, 2);
  assert.equal(await count(page, '.panel svg'), runs.length, 'a panel of posteriors per run');
  assert.equal(await marks(page, '#timeline-1'), runs.reduce((sum, { periods, bail_outs }) => sum + periods.length + bail_outs.length, 0));
  assert.equal(await marks(page, '#regret-over-cells'), truths[0].players.length);
  assert.equal(await rowsOf(page, 'regret-table'), truths[0].players.length);
  assert.equal(await rowsOf(page, 'worth-table'), truths.length);
  assert.ok((await page.locator('main').innerText()).includes(worth_text), 'the first paragraph says what choosing is worth');
  assert.equal(await count(page, '#ranking tbody .chip'), arms.length);
  const compared = await page.locator('#comparisons tbody').first().locator('tr:not(.heading)').count();
  assert.equal(compared, over_cells.length);
  for (const table of ['table-3', 'table-4', 'time-table']) assert.equal(await rowsOf(page, table), rows.length, table);
  for (const chart of ['active-shares', 'verdict-shares', 'time-shares', 'agreement-regret', 'agreement-share']) {
    assert.ok(await marks(page, `#${chart}`) >= rows.length, chart);
  }
  const wide = arms.filter((arm) => runs.some((run) => run.active_shares[run.arms.indexOf(arm)] > 0.5));
  for (const arm of wide) assert.match(await page.locator('#active-shares svg').first().textContent(), new RegExp(`${arm} [0-9]`), 'areas are named');
  await checkMark(page, '#active-shares', /%/);
}

async function checkReplay(page, { rows, scenes, calibration }) {
  assert.equal(await marks(page, '#regret-1'), rows.length);
  assert.equal(await rowsOf(page, 'rows'), rows.length);
  assert.equal(await rowsOf(page, 'scenes'), scenes.length);
  const afterStart = await page.locator('#rows tbody tr:not(.heading) > :nth-child(3)').allTextContents();
  assert.equal(afterStart.filter((text) => text === '–').length, rows.filter(({ regret_after_start }) => regret_after_start === null).length);
  await checkMark(page, '#regret-1', /after start-up/);
  assert.equal(await rowsOf(page, 'milliseconds'), rows.length);
  await checkTexts(page, '#milliseconds', '60 objects, best fixed algorithm');
  const detection = await page.locator('#milliseconds tbody tr:not(.heading) > :nth-child(2)').allInnerTexts();
  rows.forEach(({ ms_per_frame: ms }, i) => assert.equal(Number(detection[i]), Number(ms.detection.toPrecision(3))));
  const bins = calibration.reduce((sum, each) => sum + each.bins.length, 0);
  assert.equal(await marks(page, '#reliability'), bins);
  assert.equal(await rowsOf(page, 'calibration'), bins);
  await checkMark(page, '#reliability', /stated .* %, was the fastest in .* %/);
}

const textOf = (page, selector) => page.locator(selector).innerText();

async function checkTexts(page, selector, ...expected) {
  const content = await textOf(page, selector);
  for (const each of expected) assert.ok(content.includes(each), `${selector} lacks “${each}”:\n${content}`);
}

async function checkFullBench(page, { rows }) {
  await checkTexts(page, '#results', '1.67–16.7×', '99.0× the speed of the best library that did not run here', '✗ Not all pairs were right',
    'Wrong in suite-b, 1,000 objects: frame 3: (1, 2) is missing', '✓ met (≥ 5×)', '✗ missed (≥ 5×)', 'Published peer, through Bullet DBVT');
  await page.locator('#results summary').click();
  await checkTexts(page, '#results', 'ODE: libode-dev', 'Capped in suite-b, 10,000 objects: stopped by the cap of 5 s', 'would take longer than 5 s');
  await checkTexts(page, '#judged', '✗ 2 of 3 met', '✓ 1 of 1 met', '✗ 0 of 1 met');
  assert.equal(await rowsOf(page, 'goals'), 5);
  await checkTexts(page, '#spikes', '✗ missed (≤ 2×)');
  await checkTexts(page, '#growth', '✓ met (≤ 2×)', '1.00× that at 1,000');
  await checkTexts(page, '#memory', '✓ met (≤ 12 MB)');
  await checkTexts(page, '#families', 'Bullet DBVT', '✓ met (≥ 7×)');
  await checkTexts(page, '#threads', 'Grid (2 threads)', '1.50×');
  await checkTexts(page, '#times', '✗ wrong pairs');
  await checkTexts(page, '#machine', 'Some <CPU> & Co', "sweepstake-lab bench --scene '<x>&'");
  assert.ok(await count(page, '#chart-1 .leader') > 3, 'several counts are lines');
  assert.equal(await count(page, '#chart-2 .leader'), 0, 'one count is a ranking');
  assert.equal(await marks(page, '#chart-2'), 2);
  await checkTexts(page, '#chart-2', EVIL.split('/').at(-1));
  await page.locator('#raw summary').click();
  await checkTexts(page, '#rows', '✗ wrong pairs: frame 3: (1, 2) is missing', 'would take longer than 5 s');
  assert.equal(await rowsOf(page, 'rows'), rows.length, 'rows of those that were left out, too');
}

async function checkSmallBench(page) {
  await checkTexts(page, '#results', 'No peers took part in this run');
  for (const absent of ['threads', 'goals', 'families', 'overall']) assert.equal(await count(page, `#${absent}`), 0, absent);
  assert.equal(await count(page, '#results .verdict'), 0, 'no warning');
}

// What the program measured with the instruction sets of this machine: lines of their own, which name them where there are several.
async function checkMeasuredSets(page, { rows, simd }) {
  assert.equal(await count(page, '#chart-1 .leader'), 2 * simd.length);
  assert.equal(await rowsOf(page, 'times'), 2 * simd.length);
  assert.equal(await marks(page, '#chart-1'), rows.length);
  assert.equal(await count(page, '#sets'), simd.length > 1 ? 1 : 0);
  if (simd.length > 1) await checkTexts(page, '#times', ...simd.map((each) => `SAP ${each}`));
}

async function checkSets(page, { rows }) {
  await checkTexts(page, '#results', 'in each scene, with avx512, against', 'Grid avx512', 'Grid avx2', '✓ met (≥ 8×)',
    'Best published, through Embree', 'Named peer, through Embree', '✓ met (≥ 4×)');
  await checkTexts(page, '#chart-1', 'Grid avx512', 'Grid avx2', 'SAP avx2', 'Embree');
  assert.equal(await marks(page, '#chart-1'), 5, 'a bar per instruction set, and the peer');
  await checkTexts(page, '#sets', 'SAP avx2', '2.00×', '✗ missed (≤ 1.7×)', '1.50×', '✓ met (1× to 2×)', 'that with avx512');
  assert.equal(await rowsOf(page, 'sets'), 2, 'the better one has nothing to be compared with');
  await checkTexts(page, '#families', 'Grid avx2', '6.00×');
  await checkTexts(page, '#threads', 'Grid avx512 (2 threads)', '2.00×', 'Grid avx2 (2 threads)', '1.25×');
  await checkTexts(page, '#judged', 'Instruction sets', '✗ 1 of 2 met');
  await page.locator('#goals summary').click();
  await checkTexts(page, '#goals', 'Grid avx2 in suite-b, 1,000 objects: 2.00× (avx512), goal ≤ 1.7×');
  await checkTexts(page, '#method', 'Instruction sets: avx512, avx2.', 'Before each frame the caches were evicted');
  await page.locator('#raw summary').click();
  assert.equal(await rowsOf(page, 'rows'), rows.length);
}

async function checkPartial(page, { runs }) {
  await checkTexts(page, '#summary', '✗ Partial: 5 of 8 planned runs are in.', '✗ The machine was disturbed.', 'Brownian 1,000');
  for (const absent of ['regret', 'tests', 'live-replay']) assert.equal(await count(page, `#${absent}`), 0, absent);
  await checkTexts(page, '#table-3', 'KDTree 1/2; SAP 1/2', 'AxisSweep 5/5', 'Stable sweep-based preference.');
  await checkTexts(page, '#table-4', '20.2±0.8', '45.5±6.3', '0.977±0.007', '196.4±27.5');
  assert.equal(await page.locator('#table-4 small', { hasText: '196.4±27.5' }).count(), 1, 'only beside the paper’s own policy');
  assert.equal(await count(page, '.panel svg'), runs.length);
  const texts = await page.locator('#timeline-1 svg g title').allTextContents();
  assert.equal(texts.filter((text) => text.startsWith(`bail-out from ${runs[0].arms[1]}`)).length, 1);
  assert.equal(await count(page, '#timeline-1 [aria-label=tick] line'), 2 * runs.length, 'a stroke for each candidate held back');
}

// Checks that the page is drawn with all sections, even if values are missing, and that no picture contains NaN or undefined.
async function checkDrawn(page) {
  assert.ok(await count(page, 'section') > 2, await textOf(page, 'main'));
  for (const wrong of ['NaN', 'Infinity', 'undefined', 'null']) {
    assert.ok(!(await textOf(page, 'main')).includes(wrong), wrong);
    assert.equal(await count(page, `svg [d*="${wrong}"], svg [transform*="${wrong}"], svg [width*="${wrong}"], svg [x1*="${wrong}"]`), 0, wrong);
  }
}

// The elements of several documents have ids of their own, and each document's links lead to its own sections.
async function checkApart(page) {
  const ids = await page.locator('[id]').evaluateAll((elements) => elements.map(({ id }) => id));
  assert.deepEqual(ids.filter((id, i) => ids.indexOf(id) !== i), [], 'ids that occur twice');
  const articles = await page.locator('article').evaluateAll((all) => all.map((article) =>
    [...article.querySelectorAll('nav a')].every((link) => article.querySelector(link.getAttribute('href')) !== null)));
  assert.deepEqual(articles, [true, true]);
}

// On a phone the page is not wider than the screen, and no picture is scaled so that its letters become too small.
async function checkNarrow(page) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.equal(wide, 0, 'the page can be scrolled sideways');
  const pictures = await page.locator('figure .plot > svg.picture').evaluateAll((all) => all.map((svg) => ({
    id: svg.closest('figure').id, scale: svg.getBoundingClientRect().width / svg.viewBox.baseVal.width,
    lost: [...svg.querySelectorAll('text')].filter((text) => text.textContent.trim() && !text.closest('[aria-label*=title]')).filter((text) => {
      const [outer, inner] = [svg.getBoundingClientRect(), text.getBoundingClientRect()];
      return inner.left < outer.left - 1 || inner.right > outer.right + 1;
    }).map((text) => text.textContent) })));
  assert.ok(pictures.length > 0);
  for (const { id, scale, lost } of pictures) {
    assert.ok(scale > 0.9, `${id} is scaled by ${scale}`);
    assert.deepEqual(lost, [], `${id} cuts texts off`);
  }
}

async function handmadeInBrowser(context) {
  const show = async (name, document, check) => {
    writeReport(name, document);
    await inBrowser(context, name, check);
  };
  const [experiment, replay] = [documentOf('experiment'), documentOf('replay')];
  await show('full bench', fullBench, checkFullBench);
  await show('bench of sets', benchOfSets, checkSets);
  await show('small bench', bench(fullBench.rows.filter(({ kind, threads }) => kind === 'arm' && threads === 1)), checkSmallBench);
  await show('partial experiment', partialExperiment(experiment), checkPartial);
  await show('undisturbed experiment', { ...experiment, truths: experiment.truths.map((truth) => ({ ...truth, control_ratio: 1 })) },
    async (page) => assert.ok(!(await textOf(page, '#summary')).includes('disturbed.')));
  await show('judged replay', judgedReplay(replay), (page) => checkTexts(page, '#goals', '✗ missed', 'no data for this goal', '0 of 1, worst storms'));
  writeReport('two benches', fullBench, fullBench);
  await inBrowser(context, 'two benches', checkApart);
  const degenerate = { bench: degenerateBenches, experiment: degenerateExperiments(experiment), replay: degenerateReplays(replay) };
  for (const [command, documents] of Object.entries(degenerate)) {
    for (const [name, document] of Object.entries(documents)) await show(`${command}, ${name}`, document, checkDrawn);
  }
}

// Why there are no reports to look at, or nothing.
function makeReportsOrSay() {
  try {
    makeReports();
  } catch (error) {
    if (error.status === 3 && /without the page/.test(error.stderr)) return error.stderr.trim();
    throw error;
  }
}

await runInBrowser('report', async (browser, itsFolder) => {
  folder = itsFolder;
  const missing = makeReportsOrSay();
  if (missing) return missing;
  const context = await browser.newContext({ offline: true, viewport: { width: 1240, height: 900 } });
  await inBrowser(context, 'bench', checkBench);
  await inBrowser(context, 'sets', checkMeasuredSets);
  await inBrowser(context, 'experiment', checkExperiment);
  await inBrowser(context, 'replay', checkReplay);
  const phone = await browser.newContext({ offline: true, viewport: { width: 390, height: 844 } });
  for (const name of ['bench', 'experiment', 'replay']) await inBrowser(phone, name, checkNarrow);
  await handmadeInBrowser(context);
});
