import { expect, it } from 'vitest';
import { routeOf, sceneHref, sceneNameOf, sessionHref } from './route';

const at = (path: string) => routeOf(new URL(path, 'http://daemon'));

it('knows the pages', () => {
  expect(['/', '/decisions', '/priors', '/health', '/scenes/a/b', '/sessions/x'].map((path) => at(path).name))
    .toEqual(['overview', 'decisions', 'priors', 'health', 'scene', 'session']);
  expect(['/nothing', '/scenes/a', '/health/x', '/scenes/a/b/c'].map((path) => at(path).name)).toEqual(Array(4).fill('unknown'));
});

it('leads to each scene and back, whatever it is called', () => {
  for (const name of ['arena', '..', '.', '~', 'a/b?c#d', '%2e', '<script>', 'ä 日本', "'; DROP TABLE"]) {
    const scene = { project: name, scene: name, machineClass: name, rewardVersion: 3 };
    const route = at(sceneHref(scene));
    expect(route.name).toBe('scene');
    expect(sceneNameOf(route)).toEqual(scene);
    expect(at(sessionHref(name)).parts).toEqual([name]);
  }
});
