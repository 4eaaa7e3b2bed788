// Runs a real daemon and real games as child processes.
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, openSync, readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';

export const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

// Waits until `condition` returns a truthy value, and returns that. After `patienceMs` throws an error that names `what`.
export async function until(what, condition, patienceMs = 90_000) {
  for (const end = Date.now() + patienceMs; Date.now() < end; await pause(50)) {
    const found = await condition();
    if (found) return found;
  }
  throw new Error(`timed out: ${what}`);
}

const children = new Set();
process.on('exit', () => children.forEach((child) => child.kill('SIGKILL')));

function begin(...command) {
  const child = spawn(...command);
  children.add(child);
  child.once('exit', () => children.delete(child));
  return child;
}

const ended = (child) => new Promise((resolve) => {
  if (child.exitCode !== null || child.signalCode !== null) resolve();
  else child.once('exit', resolve);
});

export class RealDaemon {
  constructor(program, folder, flags = []) {
    this.program = program;
    this.folder = folder;
    this.flags = flags;
    this.ports = [0, 0];
    mkdirSync(folder, { recursive: true });
  }

  // Listens on the same ports at each start.
  async start() {
    const portFile = join(this.folder, 'ports');
    rmSync(portFile, { force: true });
    const log = openSync(join(this.folder, 'log'), 'a');
    this.child = begin(this.program, ['--data', join(this.folder, 'data'), '--listen', `127.0.0.1:${this.ports[0]}`,
      '--http', `127.0.0.1:${this.ports[1]}`, '--port-file', portFile, '--max-time-scale', '1000', ...this.flags],
    { stdio: ['ignore', log, log] });
    await until('the daemon listens', () => {
      if (this.child.exitCode !== null) throw new Error(`the daemon did not start:\n${readFileSync(join(this.folder, 'log'), 'utf8')}`);
      return existsSync(portFile);
    });
    this.ports = readFileSync(portFile, 'utf8').trim().split(/\s+/).map(Number);
    return this;
  }

  get address() { return `127.0.0.1:${this.ports[0]}`; }
  get origin() { return `http://127.0.0.1:${this.ports[1]}`; }

  freeze() { this.child.kill('SIGSTOP'); }
  thaw() { this.child.kill('SIGCONT'); }

  async stop() {
    this.child.kill('SIGCONT');
    this.child.kill('SIGTERM');
    await ended(this.child);
  }

  // Calls an RPC over HTTP as the page does; returns its responses.
  async responses(method, request = {}) {
    const response = await fetch(`${this.origin}/api/sweepstake.v1.${method}`, { method: 'POST', body: JSON.stringify(request),
      headers: { 'Content-Type': 'application/json', 'X-Sweepstake': '1' } });
    const text = await response.text();
    if (!response.ok) throw new Error(`${method}: ${response.status} ${text}`);
    return text.split('\n').filter(Boolean).map((line) => JSON.parse(line));
  }

  // Calls an RPC that returns one response.
  async call(method, request = {}) {
    return (await this.responses(method, request))[0];
  }

  makeToken(name, role) {
    const file = join(this.folder, `${name}.token`);
    execFileSync(this.program, ['token', 'create', name, '--role', role, '--out', file, '--data', join(this.folder, 'data')], { stdio: 'pipe' });
    return readFileSync(file, 'utf8').trim();
  }
}

// A game that plays a scene of a hundred objects at 60 frames per second until quit() or for `duration`. Its clock runs a hundred times
// as fast (--time-scale), so that it has one decision per frame.
export class Game {
  constructor(program, daemon, project, scene, { duration = '1h', mode = 'ai', scale = 100, plays = 'hurricane', more = [] } = {}) {
    this.child = begin(program, ['run', '--scene', plays, '--objects', '100', '--daemon', daemon.address, '--mode', mode,
      '--project', project, '--scene-name', scene, '--duration', duration, '--fps', '60', '--time-scale', String(scale), '--machine-class', 'test', ...more],
    { stdio: ['ignore', 'ignore', 'pipe'] });
    this.errors = '';
    this.child.stderr.on('data', (text) => { this.errors += text; });
  }

  async ended() {
    await ended(this.child);
    if (this.child.exitCode) throw new Error(`a game failed:\n${this.errors}`);
  }

  // Ends the game as if a player had closed its window.
  async quit() {
    this.child.kill('SIGINT');
    await ended(this.child);
  }
}

// Returns the scenes that `sweepstake watch` prints.
export const watched = (program, daemon) =>
  JSON.parse(execFileSync(program, ['watch', '--daemon', daemon.address, '--json'], { encoding: 'utf8' })).scenes;
