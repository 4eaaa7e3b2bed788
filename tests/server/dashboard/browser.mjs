// Starts Chromium, opens pages of the dashboard and checks them for errors.
import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const require = createRequire(new URL('../../../server/dashboard/package.json', import.meta.url));
export const chromiumPath = process.env.CHROMIUM ?? '/usr/bin/chromium';

export async function launch() {
  const { chromium } = require('playwright-core');
  return chromium.launch({ executablePath: chromiumPath, args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic',
    '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'] });
}

// Runs `check(browser, folder)` with a temporary folder. `check` returns the reason if it must be skipped.
export async function runInBrowser(name, check) {
  const folder = mkdtempSync(join(tmpdir(), `sweepstake_${name}_`));
  let missing = `${chromiumPath} is missing; deploy/install_packages.sh chromium installs it`;
  if (existsSync(chromiumPath)) {
    const browser = await launch();
    try {
      missing = await check(browser, folder);
    } finally {
      await browser.close();
    }
  }
  rmSync(folder, { recursive: true, force: true });
  if (!missing) return;
  console.log(`skipped: ${missing}`);
  process.exit(process.env.REQUIRE_REPORT_PAGE ? 1 : 77);
}

// Returns the rows of a table; each maps the titles of columns to cells.
export async function rowsOf(page, caption) {
  const table = page.getByRole('region', { name: caption, exact: true });
  const titles = (await table.locator('thead th').allInnerTexts()).map((title) => title.replace(/ [▲▼]$/, '').trim());
  const rows = await table.locator('tbody tr[data-key]').evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.innerText.trim())));
  return rows.map((cells) => Object.fromEntries(titles.map((title, i) => [title, cells[i]])));
}

// Opens a page and records its troubles: errors, violations of the content security policy, and requests to other servers.
// `origin` may include the base path of the dashboard.
export async function openPage(context, origin, path = '/') {
  const page = await context.newPage();
  page.setDefaultTimeout(90_000);  // long enough for a busy machine
  page.troubles = [];
  page.on('console', (message) => message.type() === 'error' && page.troubles.push(`${message.text()} ${message.location().url}`));
  page.on('pageerror', (error) => page.troubles.push(`${error.message}\n${error.stack}`));
  page.on('dialog', (dialog) => page.troubles.push(`a dialog opened: ${dialog.message()}`));
  page.on('request', (request) => /^(blob|data):/.test(request.url()) || request.url().startsWith(`${origin}/`) || page.troubles.push(`a request to another server: ${request.url()}`));
  await page.addInitScript(() => {
    document.addEventListener('securitypolicyviolation', (event) => console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`));
  });
  await page.goto(`${origin}${path}`);
  return page;
}

// Errors that the browser logs itself if the daemon refuses a request or is not running.
export const refused = (...statuses) => new RegExp(`^Failed to load resource: the server responded with a status of (${statuses.join('|')}) `);
export const AWAY = new RegExp(`^Failed to load resource: net::ERR_|${refused(503).source}`); // stopped, or about to stop

// Calls `act` and ignores troubles during it that match `expected`.
export async function expecting(page, expected, act) {
  const before = page.troubles.length;
  const result = await act();
  page.troubles.push(...page.troubles.splice(before).filter((each) => !expected.test(each)));
  return result;
}

// Returns the HTTP status of a call that the page does not offer.
export const refusalOf = (page, method, request, headers = { 'X-Sweepstake': '1' }) => expecting(page, refused(403), () =>
  page.evaluate(async ([name, body, more]) => (await fetch(`${document.querySelector('.brand').getAttribute('href')}api/sweepstake.v1.${name}`,
    { method: 'POST', headers: { 'Content-Type': 'application/json', ...more }, body: JSON.stringify(body) })).status, [method, request, headers]));

// Prints a time in milliseconds. Fails above `limit` if JUDGE_TIMES is set, which needs an idle machine.
export function judge(what, ms, limit) {
  console.log(`${what}: ${ms.toFixed(0)} ms`);
  if (process.env.JUDGE_TIMES) assert.ok(ms <= limit, `${what}: ${ms} ms, more than ${limit}`);
}

export function assertNoTrouble(page, what) {
  assert.deepEqual(page.troubles, [], what);
}

const axeSource = () => readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

// Fails if axe finds a serious accessibility problem on the page.
export async function assertAccessible(page, what) {
  await page.evaluate(axeSource());
  const violations = await page.evaluate(async () => (await globalThis.axe.run(document, { resultTypes: ['violations'] })).violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map(({ html, failureSummary }) => `${html} ${failureSummary}`).join('\n')}`));
  assert.deepEqual(violations, [], what);
}

export async function useTheme(page, theme) {
  const button = page.getByRole('button', { name: /^Theme:/ });
  for (let i = 0; i < 3 && !(await button.innerText()).endsWith(theme); ++i) await button.click();
}
