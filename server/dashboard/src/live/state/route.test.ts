import { expect, it } from 'vitest';
import { routeOf, sceneHref, sceneNameOf, sessionHref } from './route';

const at = (path: string) => routeOf(new URL(path, 'http://daemon'));

it('has a route for each page', () => {
  expect(['/', '/decisions', '/priors', '/health', '/scenes/a/b', '/sessions/x'].map((path) => at(path).name))
    .toEqual(['overview', 'decisions', 'priors', 'health', 'scene', 'session']);
  expect(['/nothing', '/scenes/a', '/health/x', '/scenes/a/b/c'].map((path) => at(path).name)).toEqual(Array(4).fill('unknown'));
});

it('encodes any scene name in a URL and decodes it again', () => {
  for (const name of ['arena', '..', '.', '~', 'a/b?c#d', '%2e', '<script>', 'ä 日本', "'; DROP TABLE"]) {
    const scene = { project: name, scene: name, machineClass: name, rewardVersion: 3 };
    const route = at(sceneHref(scene));
    expect(route.name).toBe('scene');
    expect(sceneNameOf(route)).toEqual(scene);
    expect(at(sessionHref(name)).parts).toEqual([name]);
  }
});
