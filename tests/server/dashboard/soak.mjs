// Tests a dashboard that stays open for long, with 1,000 scenes and 50 sessions at 100 times the normal speed. Without a reload, the page
// shows the overview for half of each minute, then a scene, then a session.
//
//   node soak.mjs FOLDER [MINUTES [SPEED]]
//
// FOLDER is a built page (`npx vite build`). A simulated week takes MINUTES = 101 at SPEED = 100. Prints three lines a minute. Exits with
// 1 if a view drew fewer than MIN_FRAMES frames per second, a row moved under the pointer, a chart did not change, or the page had an
// error. Also exits with 1 if memory grew: if the median of the last tenth exceeds the maximum of the first tenth by more than 5 %.
import { launch, openPage } from './browser.mjs';
import { pause, until } from './real_daemon.mjs';
import { SyntheticDaemon } from './synthetic_daemon.mjs';

const [folder, minutes = '5', speed = '100'] = process.argv.slice(2);
const MIN_FRAMES = 30;
const MAX_GROWTH = 1.05;

const daemon = await new SyntheticDaemon({ sceneCount: 1000, sessionCount: 50, speed: Number(speed), folder }).listen();
const browser = await launch();

// Returns the page's memory after garbage collection: the minimum of HEAP_MOMENTS measurements. A single one may contain messages and
// pictures in progress, which at this speed are a tenth of all memory.
const HEAP_MOMENTS = 8;
async function heapOf(session) {
  const sizes = [];
  for (let i = 0; i < HEAP_MOMENTS; ++i) {
    await session.send('HeapProfiler.collectGarbage');
    sizes.push((await session.send('Runtime.getHeapUsage')).usedSize);
    await pause(100);
  }
  return Math.min(...sizes);
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

// For each view: its path (with the played scenes on top), how long it is shown per minute, and a selector for a part that changes
// with each decision.
const VIEWS = {
  overview: { path: '/?sort=-sessions', ms: 30_000, live: '.scroll' },
  scene: { path: '/scenes/project-0/scene-0?class=desktop&reward=3', ms: 15_000, live: '.runs-now' },
  session: { path: `/sessions/${daemon.sessions[0].sessionId}`, ms: 15_000, live: 'figure[data-chart=frame-time] .legend' },
};

// Changes the view as a link in the page does.
const follow = (page, path) => page.evaluate((href) => {
  history.pushState(null, '', href);
  dispatchEvent(new PopStateEvent('popstate'));
}, path);

async function soak() {
  const page = await openPage(await browser.newContext({ viewport: { width: 1440, height: 900 } }), daemon.origin);
  const session = await page.context().newCDPSession(page);
  await until('all scenes are there', async () => (await page.locator('main').innerText()).includes('Scenes: 1,000'));
  const order = async () => (await page.locator('.scroll tbody th').allInnerTexts()).slice(0, 10).join('\n');
  const heaps = { overview: [], scene: [], session: [] };
  const rates = [];
  const moved = [];
  const still = [];
  async function visit(view) {
    const { path, ms, live } = VIEWS[view];
    const leave = Date.now() + ms;
    await follow(page, path);
    const shown = page.locator(`main ${live}`).first();
    await shown.waitFor();
    if (view === 'overview') await page.locator('.scroll tbody tr').nth(3).hover();
    const [picture, rows] = [await shown.innerHTML(), view === 'overview' && await order()];
    rates.push(await framesPerSecond(page, 10_000));
    heaps[view].push(await heapOf(session));
    console.log(`${new Date().toISOString()} ${view}: ${rates.at(-1).toFixed(1)} frames/s, ${(heaps[view].at(-1) / 1e6).toFixed(1)} MB, ${daemon.decisionCount} decisions`);
    await pause(Math.max(0, leave - Date.now()));
    if (await shown.innerHTML() === picture) still.push(view);
    if (view === 'overview' && await order() !== rows) moved.push(rows);
  }
  for (const end = Date.now() + 60_000 * Number(minutes); Date.now() < end;) for (const view of Object.keys(VIEWS)) await visit(view);
  const stays = (sizes) => {
    const tenth = Math.ceil(sizes.length / 10);
    const last = sizes.slice(-tenth).sort((a, b) => a - b); // the median, because a single value may include messages in progress
    return last[Math.floor(tenth / 2)] <= MAX_GROWTH * Math.max(...sizes.slice(0, tenth));
  };
  return {
    'frames are drawn': Math.min(...rates) >= MIN_FRAMES,
    'no row moved under the pointer': moved.length === 0,
    'memory stays': Object.values(heaps).every(stays),
    'no chart stood still': still.length === 0 || still.join(),
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
