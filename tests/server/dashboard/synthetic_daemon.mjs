// An HTTP server that behaves like a daemon with many scenes and sessions at any speed, which real games on one machine cannot reach. For
// soak.mjs and page_test.mjs.
import { readdirSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';

const ARMS = ['BruteForce', 'Grid', 'SAP', 'AxisSweep', 'DBVT', 'Tracy', 'KDTree'];
const OUTCOMES = ['KEPT', 'KEPT', 'KEPT', 'HELD_COOLDOWN', 'HELD_GATE', 'SWITCHED', 'HELD_SETTLING'];
const TICK_MS = 250;
const WINDOW_MS = 2000;
// The log of a real game: the row of the setup and one of a decision.
const [SETUP, TICK] = JSON.parse(readFileSync(new URL('../../engine_client/decider/audit/logs/adaptive.jsonl', import.meta.url), 'utf8').split('\n')[0]).rows;
const MAX_LOG_ROWS = 6000; // the number of rows that a daemon keeps of an endless session
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };

// Returns a deterministic generator of numbers from 0 to 1.
export function randomOf(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

// Returns two regimes of a scene with different best arms, and both together.
function regimesOf() {
  const armsOf = (best) => ARMS.map((_, i) => ({ costUs: 100 + 20 * Math.abs(i - best), lowUs: 90, highUs: 120 + 20 * i, bestProbability: i === best ? 0.9 : 0.1 / (ARMS.length - 1) }));
  const regimeOf = (best, more) => ({ arms: armsOf(best), bestArm: ARMS[best], ranUs: 105, savedAgainstSingleUs: 12.5, savedAgainstReferenceUs: 40, savedAgainstInitialUs: 30, ...more });
  return { total: regimeOf(2, { frameShare: 1 }),
    regimes: [regimeOf(2, { frameShare: 0.75, objectCount: 2000, speedMean: 0.1 }), regimeOf(4, { frameShare: 0.25, objectCount: 2000, speedMean: 0.001, staticRatio: 0.9, isPresent: true })] };
}

const histogramOf = (random, from) => ({ bucketSteps: [from, 1, 1, 2], counts: [3, 60 + Math.floor(random() * 40), 20, 2] });

export class SyntheticDaemon {
  // `speed` is the number of decisions of a session per WINDOW_MS.
  constructor({ sceneCount, sessionCount, speed, folder, seed = 1 }) {
    this.random = randomOf(seed);
    this.speed = speed;
    this.folder = folder;
    this.boot = '00000000000000b0';
    this.sequence = 0;
    this.watchers = new Set();
    this.logs = new Map(); // by session
    this.decisionCount = 0;
    this.scenes = Array.from({ length: sceneCount }, (_, i) => this.newScene(i));
    this.sessions = Array.from({ length: sessionCount }, (_, i) => this.newSession(i));
    this.server = createServer((request, response) => this.answer(request, response));
  }

  async listen() {
    await new Promise((resolve) => { this.server.listen(0, '127.0.0.1', resolve); });
    this.timer = setInterval(() => this.tick(), TICK_MS);
    this.origin = `http://127.0.0.1:${this.server.address().port}`;
    return this;
  }

  close() {
    clearInterval(this.timer);
    this.server.closeAllConnections();
    this.server.close();
  }

  newScene(i) {
    const best = 0.7 + 0.1 * this.random();
    const evidence = 10 ** (1 + 5 * this.random());
    return { project: `project-${i % 7}`, scene: `scene-${i}`, machineClass: 'desktop', rewardVersion: 3, sourceCount: String(1 + i % 40),
      verdict: 'VERDICT_AMBIGUOUS', leaderArm: ARMS[0], expectedLossRatio: 0.01, valueRemainingRatio: 0.008,
      arms: ARMS.map((arm, j) => {
        const mean = best - 0.004 * this.random() * j;
        const reach = 2 * Math.sqrt(mean * (1 - mean) / evidence);
        return { arm, backendVersion: 1,
          posterior: { alpha: mean * evidence, beta: (1 - mean) * evidence, low95: mean - reach, low50: mean - reach / 3, high50: mean + reach / 3, high95: mean + reach },
          windowCount: String(Math.floor(evidence / 9)), visitCount: String(j * 3),
          effectiveWindowCount: evidence / 9, bestProbability: j === 0 ? 0.4 : 0.6 / (ARMS.length - 1),
          costRatio: { median: 1 + 0.1 * j, low: 1, high: 1 + 0.2 * j } };
      }) };
  }

  newSession(i) {
    const played = this.scenes[i % this.scenes.length];
    const { project, scene } = played;
    const sessionId = `5e55${i.toString(16).padStart(28, '0')}`;
    played.activeSessionCount = 1;
    played.activity = { sessionId, activeArm: ARMS[i % ARMS.length], unixActiveSinceMs: String(Date.now()), recentSwitchCount: 6, isChanging: true, arms: ARMS, initialArm: 'Grid', ...regimesOf() };
    return { sessionId, project, scene, build: `build-${i % 3}`, clientAddress: 'ipv4:127.0.0.1:5', state: 'SESSION_STATE_CONNECTED',
      machineClass: played.machineClass, activeArm: ARMS[i % ARMS.length], initialArm: 'Grid', takesOrders: true, showsBoxes: true, mode: 'MODE_AI', unixStartMs: String(Date.now() - 60_000 * i), unixLastMessageMs: String(Date.now()) };
  }

  stamp() {
    return { boot: '176', sequence: String(++this.sequence), unixMs: String(Date.now()) };
  }

  decide(session, scene) {
    const candidate = ARMS[Math.floor(this.random() * ARMS.length)];
    const outcome = OUTCOMES[Math.floor(this.random() * OUTCOMES.length)];
    const weights = ARMS.map(() => this.random() ** 4);
    const sum = weights.reduce((total, each) => total + each, 0);
    const decision = { sessionId: session.sessionId, project: scene.project, scene: scene.scene, machineClass: scene.machineClass, policy: 'adaptive', rewardVersion: 3,
      decisionId: String(++this.decisionCount), unixMs: String(Date.now()), activeArm: session.activeArm, candidateArm: candidate, outcome: `DECISION_OUTCOME_${outcome}`,
      reward: 0.7 + 0.1 * this.random(), bestProbability: weights.map((each) => each / sum), expectedLossRatio: 0.01 * this.random(),
      verdict: 'VERDICT_AMBIGUOUS', arms: ARMS,
      standings: ARMS.map((_, i) => ({ liveWindowCount: String(i * 10), laneVisitCount: String(i * 20), effectiveWindowCount: 12.5, bestProbability: weights[i] / sum, costRatio: { median: 1.1, low: 0.9, high: 1.4 } })),
      measurements: { frameTimeNs: histogramOf(this.random, 190), detectionTimeNs: histogramOf(this.random, 165), nativeBytes: histogramOf(this.random, 150) } };
    this.keep(session, [decision.decisionId, Date.now(), session.activeArm, candidate]);
    if (outcome === 'SWITCHED') {
      decision.reason = 'SWITCH_REASON_POLICY';
      session.activeArm = candidate;
      if (scene.activity.sessionId === session.sessionId) Object.assign(scene.activity, { activeArm: candidate, unixActiveSinceMs: String(Date.now()) });
    }
    return decision;
  }

  // One tick: publishes new decisions of each session and the posterior of its scene.
  tick() {
    for (const [i, session] of this.sessions.entries()) {
      const scene = this.scenes[i % this.scenes.length];
      const count = Math.floor(this.speed * TICK_MS / WINDOW_MS + this.random());
      const decisions = Array.from({ length: count }, () => this.decide(session, scene));
      for (const arm of scene.arms) {
        arm.posterior.alpha += count * this.random();
        arm.posterior.beta += count * 0.3 * this.random();
        arm.windowCount = String(Number(arm.windowCount) + count);
      }
      const leaderProbability = 0.3 + 0.5 * this.random();
      for (const [j, arm] of scene.arms.entries()) arm.bestProbability = j === 0 ? leaderProbability : (1 - leaderProbability) / (ARMS.length - 1);
      if (count > 0) this.publish('WatchPosteriors', { posterior: scene, decisions: decisions.slice(-100), stamp: this.stamp() });
    }
    this.publish('WatchSessions', { sessions: this.sessions.slice(0, 5), stamp: this.stamp() });
  }

  publish(method, message) {
    const text = `id: ${this.boot}:${this.sequence}\ndata: ${JSON.stringify(message)}\n\n`;
    for (const watcher of this.watchers) if (watcher.method === method && watcher.response.writableLength < 1e6) watcher.response.write(text);
  }

  watch(method, response) {
    response.writeHead(200, { 'Content-Type': 'text/event-stream' });
    response.write('event: snapshot-begin\ndata: {}\n\n');
    const messages = method === 'WatchPosteriors' ? this.scenes.map((posterior) => ({ posterior, stamp: this.stamp() })) : [{ sessions: this.sessions, stamp: this.stamp() }];
    for (const message of messages) response.write(`id: ${this.boot}:${this.sequence}\ndata: ${JSON.stringify(message)}\n\n`);
    response.write(`event: snapshot-end\nid: ${this.boot}:${this.sequence}\ndata: {}\n\n`);
    const watcher = { method, response };
    this.watchers.add(watcher);
    response.on('close', () => this.watchers.delete(watcher));
  }

  records() {
    return this.scenes.slice(0, 200).flatMap((scene, i) => scene.arms.map(({ arm }, j) => ({ project: scene.project, scene: scene.scene, arm, backendVersion: 1,
      machineClass: scene.machineClass, rewardVersion: 3, sourceId: this.sessions[i % this.sessions.length]?.sessionId ?? 'imported', sourceSequence: '3', measuredBy: j % 2 ? 'lane' : '',
      alphaIncrement: 10 + j, betaIncrement: 3, windowCount: '12' })));
  }

  keep({ sessionId }, decision) {
    const log = this.logs.get(sessionId) ?? { decisions: [], droppedCount: 0 };
    this.logs.set(sessionId, log);
    log.decisions.push(decision);
    if (log.decisions.length < 2 * MAX_LOG_ROWS) return;
    log.decisions = log.decisions.slice(-MAX_LOG_ROWS);
    log.droppedCount += MAX_LOG_ROWS;
  }

  // Returns a page of a session's log, newest first. Row 1 is the setup; each decision is one row.
  list({ filter: { sessionId } = {}, pageSize = 100, olderThan, newerThan }) {
    const session = this.sessions.find((each) => each.sessionId === sessionId);
    const { decisions, droppedCount } = this.logs.get(sessionId) ?? { decisions: [], droppedCount: 0 };
    if (!session) return JSON.stringify({ olderToken: '1.1', newerToken: '0.0' });
    const setup = { ...SETUP.setup, unixStartMs: session.unixStartMs };
    const [oldest, newest] = [droppedCount + 2, droppedCount + decisions.length + 1];
    const numberOf = (token) => Number(token.split('.')[1]);
    const first = newerThan ? Math.max(numberOf(newerThan) + 1, oldest) : Math.max((olderThan ? numberOf(olderThan) : newest + 1) - pageSize, oldest);
    const last = Math.min(first + pageSize - 1, olderThan ? numberOf(olderThan) - 1 : newest);
    const rows = decisions.slice(first - oldest, last - oldest + 1).map(([id, unixMs, activeArm, candidate], i) => ({
      ...TICK, session: sessionId, row: first + i, timeNs: String(Number(setup.startNs) + 1e6 * (unixMs - Number(session.unixStartMs))), decision: { ...TICK.decision, id, activeArm, candidate },
    })).reverse();
    return JSON.stringify({ rows, setups: rows.length > 0 ? [{ sessionId, segment: 1, setup }] : [], olderToken: `1.${first}`, newerToken: `1.${Math.max(last, first - 1)}`, hasMore: newerThan ? last < newest : first > oldest });
  }

  // Returns points for each scene that is played: 1,000 frames in which the choice saved 30 µs each against Grid and 40 µs against KDTree.
  history({ kind, scene, maxPoints }) {
    if (kind !== 'HISTORY_KIND_SCENE') return '{}';
    const starts = maxPoints === 1 ? [0] : [60_000, 0];
    const series = this.scenes.filter((each) => each.activity && (!scene || each.scene === scene)).map(({ project, scene: name, machineClass, rewardVersion, activity }) => ({
      project, scene: name, machineClass, rewardVersion, points: starts.map((ago) => ({ unixMs: String(Date.now() - 60_000 - ago), endUnixMs: String(Date.now() - ago), frameCount: '1000', ranUs: 105_000, initialUs: 135_000, initialKnownFrameCount: '1000', switchCount: '6',
        arms: [['Grid', 135_000], ['KDTree', 145_000], ['SAP', 117_500]].map(([arm, wouldTakeUs]) => ({ arm, wouldTakeUs, frameCount: '1000', knownFrameCount: '990', activeFrameCount: arm === 'SAP' ? '1000' : '0' })),
        frameTimeNs: { bucketSteps: [190], counts: [1000] }, detectionTimeNs: { bucketSteps: [133], counts: [1000] }, activity })) }));
    return JSON.stringify({ series });
  }

  file(path) {
    const name = readdirSync(this.folder, { recursive: true }).includes(path.slice(1)) ? path : '/index.html';
    const bytes = readFileSync(join(this.folder, name));
    return [TYPES[extname(name)], extname(name) === '.html' ? bytes.toString().replaceAll('"./', '"/') : bytes]; // URLs from the root, as the daemon does
  }

  async answer(request, response) {
    const { pathname } = new URL(request.url, 'http://daemon');
    const method = pathname.split('/').at(-1);
    const send = (type, body) => response.writeHead(200, { 'Content-Type': type }).end(body);
    if (pathname.startsWith('/events/')) return this.watch(method, response);
    if (method === 'whoami') return send('application/json', '{"version":"0","asksForTokens":false,"loggedIn":false,"name":"","role":"admin","stableProbability":0.8,"tieLossRatio":0.005,"projects":[]}');
    if (method === 'ExportPriors') return send('application/x-ndjson', `${JSON.stringify({ records: this.records() })}\n`);
    if (method === 'ListDecisions') return send('application/json', this.list(JSON.parse((await request.toArray()).join(''))));
    if (method === 'GetHistory') return send('application/json', this.history(JSON.parse((await request.toArray()).join(''))));
    if (pathname.startsWith('/api/')) return send('application/x-ndjson', '{}\n');
    if (pathname === '/metrics') return send('text/plain', `sweepstake_sessions ${this.sessions.length}\nsweepstake_decisions_total ${this.decisionCount}\n`);
    if (/^\/(livez|readyz)$/.test(pathname)) return send('text/plain', '[+]decision-loop ok\n[+]store ok\n[+]tls ok\nreadyz check passed\n');
    return send(...this.file(pathname));
  }
}
