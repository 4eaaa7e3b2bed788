// The current page: path and query. Every view, filter, range and pause has a URL, so that links and the browser's Back and Forward
// buttons work. The daemon answers the paths of these pages with index.html.
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { pathIn, urlOf } from '../transport/calls';
import type { SceneName } from './scenes';

export type RouteName = 'overview' | 'scene' | 'session' | 'decisions' | 'priors' | 'health' | 'recording' | 'unknown';

export interface Route {
  name: RouteName;
  path: string;
  parts: readonly string[];  // the decoded parts of the path after the first: project and scene, or the session
  query: URLSearchParams;  // read only; setQuery changes it
}

const NAMES: Readonly<Record<string, RouteName>> = { decisions: 'decisions', priors: 'priors', health: 'health', recording: 'recording' };

// Returns a name as a part of a path. A leading "~" protects names such as "..", which would lead to another folder.
export const pathPart = (name: string) => encodeURIComponent(/^[.~]/.test(name) ? `~${name}` : name);

function decoded(part: string): string {
  try {
    return decodeURIComponent(part).replace(/^~/, '');
  } catch {
    return part;
  }
}

export function routeOf(url: URL): Route {
  const [first = '', ...rest] = pathIn(url.pathname).split('/').filter(Boolean).map(decoded);
  const route = { path: url.pathname, parts: rest, query: url.searchParams };
  if (first === '') return { ...route, name: 'overview' };
  if (first === 'scenes' && rest.length === 2) return { ...route, name: 'scene' };
  if (first === 'sessions' && rest.length === 1) return { ...route, name: 'session' };
  return { ...route, name: (rest.length === 0 && NAMES[first]) || 'unknown' };
}

const address = signal(typeof location === 'undefined' ? 'http://localhost/' : location.href);
export const route: ReadonlySignal<Route> = computed(() => routeOf(new URL(address.value)));

// Goes to a page of the dashboard, scrolls to its top and focuses its content.
export function navigate(href: string): void {
  history.pushState(null, '', href);
  address.value = location.href;
  window.scrollTo(0, 0);
  document.getElementById('main')?.focus({ preventScroll: true });
}

// Sets parameters of the query, and removes empty ones. With `step` the change is a new entry of the browser's history.
export function setQuery(changes: Readonly<Record<string, string | undefined>>, { step = false } = {}): void {
  const url = new URL(address.peek());
  for (const [name, value] of Object.entries(changes)) {
    if (value) url.searchParams.set(name, value);
    else url.searchParams.delete(name);
  }
  if (url.href === address.peek()) return;
  if (step) history.pushState(null, '', url);
  else history.replaceState(null, '', url);
  address.value = url.href;
}

const tail = (query: Readonly<Record<string, string>>) => {
  const text = new URLSearchParams(Object.entries(query).filter(([, value]) => value)).toString();
  return text && `?${text}`;
};

export const sceneHref = ({ project, scene, machineClass, rewardVersion }: SceneName) =>
  urlOf(`/scenes/${pathPart(project)}/${pathPart(scene)}${tail({ class: machineClass, reward: String(rewardVersion) })}`);
export const sessionHref = (id: string) => urlOf(`/sessions/${pathPart(id)}`);
export const decisionsHref = (filter: Readonly<Record<string, string>>) => urlOf(`/decisions${tail(filter)}`);

/** Returns the URL of this page with another value of a parameter. */
export function hrefWith(name: string, value: string): string {
  const query = new URLSearchParams(route.value.query);
  query.set(name, value);
  return `${route.value.path}?${query.toString()}`;
}

export const sceneNameOf = ({ parts, query }: Route): SceneName =>
  ({ project: parts[0] ?? '', scene: parts[1] ?? '', machineClass: query.get('class') ?? '', rewardVersion: Number(query.get('reward') ?? 3) });

// Opens links within the dashboard without reloading the page, unless the user opens another tab.
function follow(event: MouseEvent): void {
  const link = (event.target as Element | null)?.closest?.('a');
  if (!link || link.target || link.hasAttribute('download') || link.origin !== location.origin) return;
  if (event.defaultPrevented || event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
  event.preventDefault();
  if (link.href !== location.href) navigate(link.href);
}

export function followLinks(): void {
  document.addEventListener('click', follow);
  window.addEventListener('popstate', () => { address.value = location.href; });
}
