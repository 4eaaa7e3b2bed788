// The frame around the views: where the reader can go, how the connection is, and what works everywhere.
import { effect, signal } from '@preact/signals';
import type { ComponentType } from 'preact';
import { useEffect, useErrorBoundary, useState } from 'preact/hooks';
import { chooseTheme, keptTheme, THEMES, type Theme } from '../theme';
import { ConnectionBadge } from './parts/badge';
import { confirmed, QuestionHost } from './parts/dialog';
import { addShortcuts, KeySheet, listenToKeys, showKeys } from './parts/keys';
import { Name } from './parts/name';
import { Empty, Failure, Loading } from './parts/states';
import { toast, ToastHost } from './parts/toast';
import { visible } from './parts/visible';
import { account, accountError, learnAccount, logout, needsLogin } from './state/account';
import { connection } from './state/connection';
import { navigate, route, type RouteName } from './state/route';
import { ApiError, asApiError } from './transport/calls';
import { Login } from './views/login';
import { Overview } from './views/overview';

type Loader = () => Promise<ComponentType>;

// What is not seen at first comes when it is asked for.
const LATER: Readonly<Partial<Record<RouteName, Loader>>> = {
  scene: async () => (await import('./views/scene')).SceneView,
  session: async () => (await import('./views/session')).SessionView,
  decisions: async () => (await import('./views/decisions')).DecisionsView,
  priors: async () => (await import('./views/priors')).Priors,
  health: async () => (await import('./views/health')).Health,
};

const PLACES: readonly { name: RouteName; href: string; title: string; key: string }[] = [
  { name: 'overview', href: '/', title: 'Overview', key: 'o' },
  { name: 'decisions', href: '/decisions', title: 'Decisions', key: 'd' },
  { name: 'priors', href: '/priors', title: 'Priors', key: 'p' },
  { name: 'health', href: '/health', title: 'Health', key: 'h' },
];

const loaded = new Map<RouteName, ComponentType>();

// A newer daemon has other files: then the page has to be loaded anew.
function Later({ name }: { name: RouteName }) {
  const [error, setError] = useState<ApiError | undefined>(undefined);
  const [, setReady] = useState(false);
  useEffect(() => {
    if (!loaded.has(name)) LATER[name]!().then((view) => { loaded.set(name, view); setReady(true); }, (reason: unknown) => setError(asApiError(reason)));
  }, [name]);
  const View = loaded.get(name);
  if (View) return <View />;
  return error ? <Failure what="This view" error={error} onRetry={() => location.reload()} /> : <Loading what="the view" />;
}

// A view that fails takes neither the frame nor the other views with it.
function Guarded() {
  const [broken] = useErrorBoundary((error: unknown) => console.error(error));
  if (!broken) return <View />;
  const error = new ApiError('UNKNOWN', '', broken instanceof Error ? broken.message : String(broken));
  return <Failure what="This view" error={error} onRetry={() => location.reload()} />;
}

function View() {
  const { name, path } = route.value;
  if (needsLogin.value) return <Login />;
  if (!account.value && accountError.value) return <Failure what="The dashboard" error={accountError.value} onRetry={() => void learnAccount()} />;
  if (name === 'overview') return <Overview />;
  if (LATER[name]) return <Later key={name} name={name} />;
  return <Empty title="There is no such page"><p><Name text={path} /> leads nowhere. <a href="/">The overview</a> has all scenes.</p></Empty>;
}

const theme = signal<Theme>(keptTheme());

function ThemeSwitch() {
  const next = THEMES[(THEMES.indexOf(theme.value) + 1) % THEMES.length]!;
  const choose = () => {
    chooseTheme(next);
    theme.value = next;
  };
  return <button type="button" class="quiet" onClick={choose} title={`Change to ${next}`}>Theme: {theme.value}</button>;
}

async function leave(): Promise<void> {
  if (!await confirmed({ title: 'Log out?', body: <p>This browser forgets the token. What runs goes on.</p>, action: 'Log out' })) return;
  await logout().catch((error: unknown) => toast(`Still logged in: ${asApiError(error).message}`, { isBad: true }));
}

function Reader() {
  const who = account.value;
  if (!who?.loggedIn) return null;
  return <button type="button" class="quiet" onClick={() => void leave()} title={`Role: ${who.role}. Log out`}><Name text={who.name} unknown="logged in" /></button>;
}

function Header() {
  return (
    <header class="top">
      <a class="skip" href="#main">To the content</a>
      <a class="brand" href="/">Sweepstake</a>
      <nav aria-label="Views">
        {PLACES.map(({ name, href, title }) => <a key={name} href={href} aria-current={route.value.name === name ? 'page' : undefined}>{title}</a>)}
      </nav>
      <div class="corner">
        {!needsLogin.value && <ConnectionBadge />}
        <Reader />
        <ThemeSwitch />
        <button type="button" class="quiet" onClick={showKeys} aria-label="Keyboard" title="Keyboard (?)">?</button>
      </div>
    </header>
  );
}

// What the page last knew is still worth reading, but must not look fresh.
const isOld = () => !['live', 'connecting'].includes(connection.value.status);

export function App() {
  return (
    <>
      <Header />
      <main id="main" tabIndex={-1} class={isOld() && !needsLogin.value ? 'old' : undefined}><Guarded key={route.value.path} /></main>
      <QuestionHost />
      <KeySheet />
      <ToastHost />
    </>
  );
}

function titleOf(): string {
  const { name, parts } = route.value;
  if (name === 'overview') return 'Sweepstake';
  const place = PLACES.find((each) => each.name === name)?.title ?? (parts.map(visible).join(' / ') || 'Not found');
  return `${place} · Sweepstake`;
}

export function startApp(): void {
  listenToKeys();
  addShortcuts(PLACES.map(({ href, title, key }) => ({ keys: `g ${key}`, what: `Go to ${title.toLowerCase()}`, run: () => navigate(href) })));
  effect(() => { document.title = titleOf(); });
}
