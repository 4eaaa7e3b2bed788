// Takes the pictures of the dashboard for the READMEs: runs the demo of deploy/quickstart.sh for PLAY_MS, then saves the overview and the
// first scene.
//
//   node picture.mjs BIN FOLDER    writes FOLDER/overview.png and FOLDER/scene.png
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

import { launch, openPage, useTheme } from './browser.mjs';
import { pause } from './real_daemon.mjs';

const [bin, folder] = process.argv.slice(2);
const MAX_BYTES = 200_000;
const PLAY_MS = 120_000;
const quickstart = fileURLToPath(new URL('../../../deploy/quickstart.sh', import.meta.url));

async function originOf(demo) {
  for await (const line of createInterface(demo.stdout)) {
    const found = /http:\/\/127\.0\.0\.1:\d+/.exec(line);
    if (found) return found[0];
  }
  throw new Error('deploy/quickstart.sh ended before it printed an address');
}

async function draw(page, name) {
  await page.mouse.move(0, 0);
  await page.evaluate(() => document.activeElement.blur());
  const path = join(folder, `${name}.png`);
  await page.screenshot({ path });
  const { size } = statSync(path);
  if (size > MAX_BYTES) throw new Error(`${path} has ${size} bytes, more than ${MAX_BYTES}`);
}

const data = mkdtempSync(join(tmpdir(), 'sweepstake_picture_'));
const demo = spawn(quickstart, ['--stay', '--bin', bin, '--data', data], { stdio: ['ignore', 'pipe', 'inherit'] });
const ended = new Promise((resolve) => { demo.once('exit', resolve); });
const browser = await launch();
try {
  const page = await openPage(await browser.newContext({ viewport: { width: 1400, height: 640 }, reducedMotion: 'reduce' }), await originOf(demo));
  await useTheme(page, 'light');
  await pause(PLAY_MS);
  await draw(page, 'overview');
  await page.setViewportSize({ width: 1400, height: 960 });
  await page.locator('tbody tr[data-key] a').first().click();
  await page.locator('figure.chart svg.picture').first().waitFor();
  await draw(page, 'scene');
} finally {
  await browser.close();
  demo.kill('SIGTERM');
  await ended;
  rmSync(data, { recursive: true, force: true });
}
