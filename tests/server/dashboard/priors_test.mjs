// Tests the view of the priors as an operator uses it, with a real daemon and real games of two builds in Chromium.
//
//   node priors_test.mjs SWEEPSTAKED SWEEPSTAKE
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { assertAccessible, assertNoTrouble, expecting, openPage, refusalOf, refused, rowsOf, runInBrowser } from './browser.mjs';
import { Game, RealDaemon, until } from './real_daemon.mjs';

const [sweepstaked, sweepstake] = process.argv.slice(2);
const HOSTILE = '<b>1.3</b>\u202E';
const SHOWN_HOSTILE = '<b>1.3</b>⟨U+202E⟩';
const shownName = (name) => name.replaceAll('\u202E', '⟨U+202E⟩');
const IMPORTED = 'from a file';

const query = (page) => new URL(page.url()).searchParams;
const number = (text) => Number(text.replaceAll(',', ''));
const dialog = (page) => page.getByRole('dialog');
const button = (place, name) => place.getByRole('button', { name, exact: true });
const revokeOf = (page, name) => button(page, `Revoke ${name}`);

// Runs `sweepstake priors`, whose numbers the page must show.
class Commands {
  constructor(daemon, folder) {
    this.daemon = daemon;
    this.folder = folder;
  }

  run(...words) { return JSON.parse(execFileSync(sweepstake, ['priors', ...words, '--json'], { encoding: 'utf8' })); }
  ask(...words) { return this.run(...words, '--daemon', this.daemon.address); }

  exported() {
    const file = join(this.folder, 'priors.json');
    this.ask('export', '--out', file);
    return { file, records: JSON.parse(readFileSync(file, 'utf8')).records };
  }

  // Imports the records of one source as records of another daemon.
  importOne() {
    const { records } = this.exported();
    const theirs = records.filter(({ source_id: id }) => id === records[0].source_id).map((record) => ({ ...record, source_id: IMPORTED, build: '0.9' }));
    const file = join(this.folder, 'theirs.json');
    writeFileSync(file, JSON.stringify({ format: 'sweepstake-priors', version: 1, records: theirs }));
    assert.equal(this.ask('import', '--in', file).applied, theirs.length);
    return file;
  }
}

const waits = ({ is_quarantined: isWaiting }) => isWaiting === true;
const sum = (records, field) => records.reduce((total, record) => total + record[field], 0);
const seen = (records) => Math.max(...records.map((record) => record.unix_last_seen_s));

// Returns a local time as fields for times have it.
function fieldTime(unixS) {
  const date = new Date(1000 * unixS);
  return new Date(date.getTime() - 60_000 * date.getTimezoneOffset()).toISOString().slice(0, 19);
}
const shownTime = (unixS) => new Date(1000 * unixS).toLocaleString('en-GB', { dateStyle: 'medium', timeStyle: 'medium' });

// Imported records are listed at the top, and no prior uses them. Promoting them needs a confirmed preview; cancelling changes nothing.
async function checkPromote(page, daemon, commands) {
  await page.goto(`${daemon.origin}/priors`);
  await page.getByRole('region', { name: 'Quarantine' }).waitFor();
  assert.equal(await page.getByRole('heading', { level: 2 }).first().innerText(), 'Waiting in quarantine');
  const before = commands.exported().records;
  const waiting = before.filter(waits);
  assert.ok(waiting.length > 0 && waiting.length < before.length);
  const [row, ...more] = await rowsOf(page, 'Quarantine');
  assert.equal(more.length, 0);
  assert.deepEqual([row.Build, row.Sources, number(row.Windows)], ['0.9', '1', sum(waiting, 'window_count')]);
  const columnOf = async (caption, column) => (await rowsOf(page, caption)).map((each) => each[column]);
  assert.ok(!(await columnOf('Builds', 'Build')).includes('0.9') && !(await columnOf('Sources', 'Source')).includes(IMPORTED));
  await assertAccessible(page, 'the quarantine');
  const preview = commands.ask('promote', '--project', 'arcade', '--build', '0.9');
  assert.deepEqual([preview.sources, preview.records, preview.scenes], [1, waiting.length, 1]);
  const ask = async () => {
    await button(page, 'Promote build 0.9').click();
    await previewIs(page, preview, /would be promoted\./);
    assert.match(await dialog(page).getByRole('status').innerText(), / for 1 scene would be promoted/);
  };
  await ask();
  await assertAccessible(page, 'the dialog of a promotion');
  await button(dialog(page), 'Cancel').click();
  assert.deepEqual(commands.exported().records, before, 'a cancelled promotion changes nothing');
  await ask();
  await button(dialog(page), 'Promote').click();
  const toast = await page.locator('.toast', { hasText: 'Promoted' }).innerText();
  for (const part of countsText(preview)) assert.ok(toast.replaceAll(',', '').includes(part), toast);
  await until('the source counts', async () => (await columnOf('Sources', 'Source')).includes(IMPORTED));
  assert.equal(await page.getByRole('region', { name: 'Quarantine' }).count(), 0);
  const after = commands.exported().records;
  assert.deepEqual([after.length, after.filter(waits).length], [before.length, 0]);
  await page.goto(`${daemon.origin}/decisions?session=admin`);
  await page.getByText(/ promoted [0-9]/).first().waitFor();
}

// Returns the highest weight of each source's records in a new session, from the API.
async function weightsOf(daemon) {
  const response = await fetch(`${daemon.origin}/api/sweepstake.v1.PriorsService/ExportPriors`, { method: 'POST', body: '{"withWeights":true}',
    headers: { 'Content-Type': 'application/json', 'X-Sweepstake': '1' } });
  const weights = new Map();
  for (const { sourceId, weight = 0 } of (await response.text()).trim().split('\n').flatMap((line) => JSON.parse(line).records ?? [])) {
    weights.set(sourceId, Math.max(weight, weights.get(sourceId) ?? 0));
  }
  return weights;
}

// The tables show the builds and sources of an export.
async function checkTables(page, daemon, commands) {
  await page.goto(`${daemon.origin}/priors`);
  await page.getByRole('region', { name: 'Sources' }).waitFor();
  const { records } = commands.exported();
  const groups = { Builds: ['Build', (record) => (record.build === HOSTILE ? SHOWN_HOSTILE : record.build)], Sources: ['Source', (record) => record.source_id] };
  for (const [caption, [title, nameOf]] of Object.entries(groups)) {
    const rows = await rowsOf(page, caption);
    assert.deepEqual(rows.map((row) => row[title]).sort(), [...new Set(records.map(nameOf))].sort(), caption);
    for (const row of rows) {
      const own = records.filter((record) => nameOf(record) === row[title]);
      assert.equal(number(row.Windows), sum(own, 'window_count'), row[title]);
      assert.equal(row['Last seen'], shownTime(seen(own)), row[title]);
      assert.equal(row.Machines, 'test', row[title]);
      if (row.Sources) assert.equal(number(row.Sources), new Set(own.map((record) => record.source_id)).size, row[title]);
      else assert.equal(row.Origin, row[title] === IMPORTED ? 'import' : 'session', row[title]);
    }
  }
  const weights = await weightsOf(daemon);
  const shown = (await rowsOf(page, 'Sources')).map(({ Source, Weight }) => [Source, number(Weight)]);
  assert.ok(shown.some(([, weight]) => weight > 0), 'some source counts');
  for (const [id, weight] of shown) assert.ok(Math.abs(weight - weights.get(id)) <= 0.006 * weights.get(id), `${id}: ${weight} instead of ${weights.get(id)}`);
  assert.equal(await page.locator('main b', { hasText: /^1\.3$/ }).count(), 0, 'a name became markup');
  await assertAccessible(page, 'priors');
}

// The differences of two builds are those that the command line computes from an export. The comparison is in the URL.
async function checkChanges(page, daemon, commands) {
  await page.getByLabel('From build').selectOption('1.1');
  await page.getByLabel('to build').selectOption('1.2');
  await page.getByRole('region', { name: 'Changes' }).waitFor();
  const chosen = () => Promise.all(['From build', 'to build'].map((label) => page.getByLabel(label).inputValue()));
  assert.deepEqual(await chosen(), ['1.1', '1.2']);
  const { file } = commands.exported();
  const { scenes } = commands.run('diff', file, file, '--build', '1.1', '--other-build', '1.2');
  const expected = scenes.flatMap(({ scene, regime, leader_changed: isOther, arms }) => arms.map(({ arm, before, after }) =>
    [scene, regime || '–', arm, before?.toFixed(2) ?? '–', after?.toFixed(2) ?? '–', isOther].join()));
  const shown = async () => (await rowsOf(page, 'Changes')).map((row) =>
    [row.Scene, row.Regime, row.Algorithm, row['Cost before'], row['Cost after'], row['Cheapest algorithm'] === 'another'].join()).sort().join('\n');
  assert.ok(expected.some((row) => row.startsWith('cave,')), 'only one build has played the cave');
  await until('the page has the differences', async () => await shown() === expected.sort().join('\n'));
  await assertAccessible(page, 'changes');
  await page.goBack();
  await page.goForward();
  await page.getByRole('region', { name: 'Changes' }).waitFor();
  await page.reload();
  await page.getByRole('region', { name: 'Changes' }).waitFor();
  assert.deepEqual(await chosen(), ['1.1', '1.2']);
  await page.getByLabel('to build').selectOption('1.1');
  await page.getByText('The builds agree on every scene').waitFor();
  await page.goto(`${daemon.origin}/priors?before=1.1&after=7`);
  await page.getByText('There is no evidence of build 7 here').waitFor();
}

async function valuesOf(figure) {
  const [header, ...rows] = await figure.getByRole('region').locator('tr').evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.innerText.trim())));
  return rows.map((cells) => Object.fromEntries(header.map((title, i) => [title, cells[i]])));
}

// The chart of a build shows its evidence on top of the evidence of other builds, as sums of the exported records. The build is in the URL.
async function checkPriorOfBuild(page, daemon, commands) {
  const records = commands.exported().records.filter(({ scene, reward_version: version }) => scene === 'arena' && version === 3);
  await page.goto(`${daemon.origin}/scenes/arcade/arena?class=${encodeURIComponent(records[0].machine_class)}&reward=3`);
  await button(page, 'Show evidence by source').click();
  const figure = page.locator('figure[data-chart=build]');
  await figure.getByRole('combobox').selectOption('1.2');
  assert.equal(query(page).get('build'), '1.2');
  await figure.getByText('including build 1.2').waitFor();
  await button(figure, 'Table').click();
  const rows = await valuesOf(figure);
  assert.deepEqual(rows.map(({ algorithm }) => algorithm), [...new Set(records.map(({ arm }) => arm))].sort());
  assert.ok(records.every(({ measured_by: by }) => !by), 'the arena has lane visits, so its figures are not sums');
  for (const row of rows) {
    const own = records.filter(({ arm }) => arm === row.algorithm);
    const others = own.filter(({ build }) => build !== '1.2');
    const near = (text, all, field) => assert.ok(Math.abs(number(text) - (1 + sum(all, field))) <= 0.001 * (1 + sum(all, field)), `${row.algorithm}: ${text} of ${field}`);
    near(row.alpha, own, 'alpha_increment');
    near(row.beta, own, 'beta_increment');
    if (others.length > 0) near(row['prior alpha'], others, 'alpha_increment');
  }
  const n = (row, prior) => number(row[`${prior}alpha`]) + number(row[`${prior}beta`]);
  const both = rows.filter((row) => number(row['prior alpha']) > 0);
  assert.ok(both.length > 0, 'other builds knew some arm');
  for (const row of both) assert.ok(n(row, 'prior ') <= n(row, ''), `${row.algorithm}: the build took something away`);
  await assertAccessible(page, 'the prior of a build');
  await page.goBack();
  assert.equal(query(page).get('build'), null);
}

const counted = (count, one) => `${count} ${one}${count === 1 ? '' : 's'}`;
const countsText = ({ sources, records, windows }) => [counted(sources, 'source'), counted(records, 'record'), counted(windows, 'window')];
async function previewIs(page, result, end = /would be revoked\./) {
  const text = await until('the preview is there', async () => { const shown = await dialog(page).getByRole('status').innerText(); return end.test(shown) && shown; });
  for (const part of countsText(result)) assert.ok(text.replaceAll(',', '').includes(part), `${text} without ${part}`);
  const leaders = result.leader_changes.scenes.map(({ scene, arm, next_arm: next }) => `${shownName(scene)}: ${next || 'none'} in place of ${arm || 'none'}`);
  const items = await dialog(page).getByRole('listitem').allInnerTexts();
  assert.equal(items.length, leaders.length, items.join());
  for (const leader of leaders) assert.ok(items.some((item) => item.replace(/ on \S+(?=:)/, '').replaceAll(/\s+/g, ' ').includes(leader)), `${items.join()} without ${leader}`);
  if (leaders.length === 0) await dialog(page).getByText('The same algorithm would lead in every scene').waitFor();
}

// Revoking a build shows a preview first, changes nothing if cancelled, and removes exactly this build if confirmed.
async function checkRevokeBuild(page, daemon, commands) {
  await page.goto(`${daemon.origin}/priors`);
  await revokeOf(page, 'build 1.2').click();
  const preview = commands.ask('revoke', '--project', 'arcade', '--build', '1.2');
  assert.equal(preview.sources, 2);
  await previewIs(page, preview);
  await assertAccessible(page, 'the dialog');
  const before = commands.exported().records;
  await button(dialog(page), 'Cancel').click();
  assert.deepEqual(commands.exported().records, before, 'a cancelled revocation changes nothing');
  await revokeOf(page, 'build 1.2').click();
  await previewIs(page, preview);
  await button(dialog(page), 'Revoke').click();
  const toast = await page.locator('.toast', { hasText: 'Revoked' }).innerText();
  for (const part of countsText(preview)) assert.ok(toast.replaceAll(',', '').includes(part), toast);
  assert.deepEqual(commands.exported().records, before.filter(({ build }) => build !== '1.2'), 'this build, and nothing else');
  await until('the tables are without it', async () => { const rows = await rowsOf(page, 'Builds'); return rows.length > 0 && rows.every(({ Build }) => Build !== '1.2'); });
  await page.goto(`${daemon.origin}/decisions?session=admin`);
  await page.getByText(/revoke.*, build 1[.]2\b/).first().waitFor();
}

async function checkRevokeSource(page, daemon, commands) {
  await page.goto(`${daemon.origin}/priors`);
  const isThere = () => commands.exported().records.some((record) => record.source_id === IMPORTED);
  assert.ok(isThere());
  await revokeOf(page, `source ${IMPORTED}`).click();
  await previewIs(page, commands.ask('revoke', '--source', IMPORTED));
  await button(dialog(page), 'Revoke').click();
  await page.locator('.toast', { hasText: 'Revoked' }).waitFor();
  assert.ok(!isThere());
}

// The form selects sources; each change of the form needs a new preview.
async function checkRevokeForm(page, daemon, commands) {
  await page.goto(`${daemon.origin}/priors?project=arcade`);
  await button(page, 'Revoke …').click();
  const field = (name) => dialog(page).getByLabel(name);
  const revoke = button(dialog(page), 'Revoke');
  const preview = () => button(dialog(page), 'Preview').click();
  assert.equal(await field('Project').inputValue(), 'arcade');
  await expecting(page, refused(400), async () => {
    await preview();
    await dialog(page).getByText('select the sessions to revoke').waitFor();
  });
  assert.ok(await revoke.isDisabled());
  const { records } = commands.exported();
  await field('Began at or after').fill(fieldTime(seen(records) + 3600));
  await preview();
  await dialog(page).getByText('Nothing would be revoked').waitFor();
  assert.ok(await revoke.isDisabled());
  await field('Began at or after').fill('');
  await field('Began at or before').fill(fieldTime(seen(records) + 3600));
  await preview();
  await previewIs(page, commands.ask('revoke', '--project', 'arcade', '--until', String(seen(records) + 3600)));
  assert.ok(await revoke.isEnabled());
  await field('Number of the token').fill('77');
  assert.ok(await revoke.isDisabled(), 'another scope was not previewed');
  await preview();
  await dialog(page).getByText('Nothing would be revoked').waitFor();
  await page.keyboard.press('Escape');
  assert.equal(await dialog(page).count(), 0);
  assert.deepEqual(commands.exported().records, records);
}

const ROLE_REASON = 'Promoting and revoking need the role operator; yours is watch.';

async function checkRole(context, folder, file) {
  const daemon = new RealDaemon(sweepstaked, join(folder, 'tokens'), ['--require-tokens']);
  const watcher = daemon.makeToken('reader', 'watch');
  daemon.makeToken('player', 'ingest');
  daemon.makeToken('boss', 'operator');
  await daemon.start();
  execFileSync(sweepstake, ['priors', 'import', '--in', file, '--daemon', daemon.address, '--token-file', join(folder, 'tokens', 'boss.token')]);
  await new Game(sweepstake, daemon, 'arcade', 'arena', { duration: '3s', more: ['--build', '1.1', '--token-file', join(folder, 'tokens', 'player.token')] }).ended();
  const page = await openPage(context, daemon.origin, '/priors');
  await page.getByLabel('Token').fill(watcher);
  await button(page, 'Log in').click();
  await page.getByText(ROLE_REASON).waitFor();
  await revokeOf(page, 'build 1.1').waitFor();
  for (const each of [button(page, 'Revoke …'), revokeOf(page, 'build 1.1'), button(page, 'Promote all …'), button(page, 'Promote build 0.9')]) {
    assert.ok(await each.isDisabled());
    assert.equal(await each.evaluate((element) => document.getElementById(element.getAttribute('aria-describedby'))?.textContent),
      ROLE_REASON);
  }
  for (const method of ['RevokePriors', 'PromotePriors']) {
    const status = await refusalOf(page, `PriorsService/${method}`, { sources: { build: '1.1' }, preview: true });
    assert.equal(status, 403, `the daemon refuses ${method}, which the page does not offer`);
  }
  await assertAccessible(page, 'a reader');
  assertNoTrouble(page, 'a reader');
  await page.close();
  await daemon.stop();
}

async function checkAll(browser, folder) {
  const daemon = await new RealDaemon(sweepstaked, join(folder, 'main')).start();
  const front = await (await fetch(daemon.origin)).text();
  if (/without the dashboard/.test(front)) {
    await daemon.stop();
    return front;
  }
  const played = [['arena', '1.1'], ['arena', '1.2'], ['cave', '1.2'], ['arena', HOSTILE]];
  // The arena has no shadow lane, so that its figures are sums of the exported records.
  const lane = (scene) => ['--shadow', scene === 'arena' ? 'off' : 'auto'];
  await Promise.all(played.map(([scene, build]) => new Game(sweepstake, daemon, 'arcade', scene, { duration: '5s', more: ['--build', build, ...lane(scene)] }).ended()));
  const commands = new Commands(daemon, folder);
  await until('all games have added evidence', () => new Set(commands.exported().records.map(({ source_id: id }) => id)).size === played.length);
  const file = commands.importOne();
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await openPage(context, daemon.origin, '/priors');
  for (const check of [checkPromote, checkTables, checkChanges, checkPriorOfBuild, checkRevokeBuild, checkRevokeSource, checkRevokeForm]) {
    await check(page, daemon, commands);
    console.log(`${check.name}: passed`);
  }
  assertNoTrouble(page, 'the priors');
  await page.close();
  await daemon.stop();
  await checkRole(context, folder, file);
  console.log('checkRole: passed');
  return '';
}

await runInBrowser('priors', checkAll);
