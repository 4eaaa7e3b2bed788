// The dashboard's entry point, and the frame around the views: navigation, state of the connection, login, theme and keyboard shortcuts.
import { effect } from '@preact/signals';
import { type ComponentType, render } from 'preact';
import { useErrorBoundary } from 'preact/hooks';
import { theme, THEMES } from '../theme';
import { ConnectionBadge } from './parts/chips';
import { startClock } from './parts/clock';
import { confirmed, QuestionHost } from './parts/dialog';
import { addShortcuts, KeySheet, listenToKeys, showKeys } from './parts/keys';
import { Name, visible } from './parts/name';
import { Empty, Failure, Later } from './parts/states';
import { toast, ToastHost } from './parts/toast';
import { account, accountError, learnAccount, logout, needsLogin } from './state/account';
import { followAlerts, seriousCount } from './state/alerts';
import { connection } from './state/connection';
import { startLive } from './state/live';
import { followLinks, navigate, route, type RouteName } from './state/route';
import { followScenes } from './state/summaries';
import { ApiError, asApiError, urlOf } from './transport/calls';
import { Login } from './views/login';
import { Overview } from './views/overview';

const LATER: Readonly<Partial<Record<RouteName, () => Promise<ComponentType>>>> = {
  scene: async () => (await import('./views/scene')).SceneView,
  session: async () => (await import('./views/session')).SessionView,
  decisions: async () => (await import('./views/decisions')).DecisionsView,
  priors: async () => (await import('./views/priors')).Priors,
  health: async () => (await import('./views/health')).Health,
  recording: async () => (await import('./views/recording')).RecordingView,
};

const PLACES: readonly { name: RouteName; href: string; title: string; key: string }[] = [
  { name: 'overview', href: urlOf('/'), title: 'Overview', key: 'o' },
  { name: 'decisions', href: urlOf('/decisions'), title: 'Decisions', key: 'd' },
  { name: 'priors', href: urlOf('/priors'), title: 'Priors', key: 'p' },
  { name: 'health', href: urlOf('/health'), title: 'Health', key: 'h' },
];

// Catches an exception of a view, so that the frame and the other views still work.
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
  const load = LATER[name];
  if (load) return <Later key={name} name={name} load={load} props={{}} />;
  return <Empty title="This page does not exist"><p>The dashboard has no page <Name text={path} />. <a href={urlOf('/')}>The overview</a> lists all scenes.</p></Empty>;
}

function ThemeSwitch() {
  const next = THEMES[(THEMES.indexOf(theme.value) + 1) % THEMES.length]!;
  return <button type="button" class="quiet" onClick={() => { theme.value = next; }} title={`Change the theme to ${next}`}><span class="long">Theme: </span>{theme.value}</button>;
}

async function leave(): Promise<void> {
  if (!await confirmed({ title: 'Log out?', body: <p>You need the token to log in again. Games and sessions continue.</p>, action: 'Log out' })) return;
  await logout().catch((error: unknown) => toast(`Still logged in: ${asApiError(error).message}`, { isBad: true }));
}

function Reader() {
  const who = account.value;
  if (!who?.loggedIn) return null;
  return <button type="button" class="quiet" onClick={() => void leave()} title={`Your role is ${who.role}. Click to log out.`}><Name text={who.name} unknown="logged in" /></button>;
}

function Header() {
  return (
    <header class="top">
      <a class="skip" href="#main">Skip to the content</a>
      <a class="brand" href={urlOf('/')}>Sweepstake</a>
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

// Whether the shown data is old: without a connection the page shows the last data that it received, in grey.
const isOld = () => !['live', 'connecting'].includes(connection.value.status);

function App() {
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
  const place = PLACES.find((each) => each.name === name)?.title ?? (parts.map(visible).join(' / ') || (name === 'recording' ? 'Recording' : 'Not found'));
  return `${place} · Sweepstake`;
}

followLinks();
listenToKeys();
startClock();
addShortcuts(PLACES.map(({ href, title, key }) => ({ keys: `g ${key}`, what: `Go to ${title.toLowerCase()}`, run: () => navigate(href) })));
// The number of serious alerts is in the title, so that a tab in the background shows it.
effect(() => { document.title = seriousCount.value > 0 ? `(${seriousCount.value}) ${titleOf()}` : titleOf(); });
followScenes();
followAlerts();
startLive();
render(<App />, document.getElementById('app')!);
