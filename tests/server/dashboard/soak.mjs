// How the dashboard bears being left open: 1,000 scenes and 50 sessions, whose games play a hundred times as fast.
//
//   node soak.mjs FOLDER [MINUTES [SPEED]]
//
// FOLDER is a built page (`npx vite build --mode dashboard`). A simulated week takes MINUTES = 101 at SPEED = 100. Prints a line a
// minute, and ends with 1 if less than 30 frames were drawn in a second, if a row moved under the pointer, or if memory grew by more than
// 5 % after the first tenth.
import { launch, openPage } from './browser.mjs';
import { pause, until } from './real_daemon.mjs';
import { SyntheticDaemon } from './synthetic_daemon.mjs';

const [folder, minutes = '5', speed = '100'] = process.argv.slice(2);
const MIN_FRAMES = 30;
const MAX_GROWTH = 1.05;

const daemon = await new SyntheticDaemon({ sceneCount: 1000, sessionCount: 50, speed: Number(speed), folder }).listen();
const browser = await launch();

// The page's memory after everything that can be freed is freed.
async function heapOf(session) {
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  return usedSize;
}

const framesPerSecond = (page, ms) => page.evaluate((duration) => new Promise((resolve) => {
  const start = performance.now();
  let count = 0;
  const frame = (now) => {
    ++count;
    if (now - start < duration) requestAnimationFrame(frame);
    else resolve((1000 * count) / (now - start));
  };
  requestAnimationFrame(frame);
}), ms);

async function soak() {
  const page = await openPage(await browser.newContext({ viewport: { width: 1440, height: 900 } }), daemon.origin);
  const session = await page.context().newCDPSession(page);
  await until('all scenes are there', async () => (await page.locator('main').innerText()).includes('Scenes: 1,000'));
  await page.locator('.scroll tbody tr').nth(3).hover();
  const names = () => page.locator('.scroll tbody th').allInnerTexts();
  const order = (await names()).slice(0, 10).join('\n');
  const heaps = [];
  const rates = [];
  for (const end = Date.now() + 60_000 * Number(minutes); Date.now() < end;) {
    rates.push(await framesPerSecond(page, 10_000));
    heaps.push(await heapOf(session));
    console.log(`${new Date().toISOString()} ${rates.at(-1).toFixed(1)} frames/s, ${(heaps.at(-1) / 1e6).toFixed(1)} MB, ${daemon.decisionCount} decisions`);
    await pause(Math.max(0, Math.min(50_000, end - Date.now())));
  }
  const settled = Math.max(...heaps.slice(0, Math.max(1, Math.ceil(heaps.length / 10))));
  return {
    'frames are drawn': Math.min(...rates) >= MIN_FRAMES,
    'no row moved under the pointer': (await names()).slice(0, 10).join('\n') === order,
    'memory stays': heaps.at(-1) <= MAX_GROWTH * settled,
    'nothing went wrong': page.troubles.length === 0 || page.troubles.join('\n'),
  };
}

try {
  const verdict = await soak();
  console.log(verdict);
  process.exitCode = Object.values(verdict).every((each) => each === true) ? 0 : 1;
} finally {
  await browser.close();
  daemon.close();
}
