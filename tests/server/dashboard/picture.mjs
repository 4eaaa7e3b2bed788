// The picture of the dashboard in the READMEs: games play seven scenes for a while, and the overview is drawn.
//
//   node picture.mjs SWEEPSTAKED SWEEPSTAKE PICTURE.png
import { mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { launch, openPage, useTheme } from './browser.mjs';
import { Game, pause, RealDaemon } from './real_daemon.mjs';

const [sweepstaked, sweepstake, picture] = process.argv.slice(2);
const MAX_BYTES = 200_000;
const PLAY_MS = 60_000;
const SCENES = [['arcade', 'asteroid belt'], ['arcade', 'boss arena'], ['arcade', 'debris'], ['racing', 'city at night'], ['racing', 'dust storm'],
  ['racing', 'start grid'], ['strategy', 'siege of 3,000']];

const folder = mkdtempSync(join(tmpdir(), 'sweepstake_picture_'));
const daemon = await new RealDaemon(sweepstaked, folder).start();
const browser = await launch();
try {
  const page = await openPage(await browser.newContext({ viewport: { width: 1280, height: 640 }, reducedMotion: 'reduce' }), daemon.origin);
  const games = SCENES.map(([project, scene], i) => new Game(sweepstake, daemon, project, scene, { scale: 10 + 20 * i }));
  await pause(PLAY_MS);
  await useTheme(page, 'light');
  await page.mouse.move(0, 0);
  await page.evaluate(() => document.activeElement.blur());
  await pause(1000);
  await page.screenshot({ path: picture });
  await Promise.all(games.map((game) => game.quit()));
} finally {
  await browser.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
}
const { size } = statSync(picture);
if (size > MAX_BYTES) throw new Error(`${picture} has ${size} bytes, more than ${MAX_BYTES}`);
