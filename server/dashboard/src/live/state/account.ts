// The account of the page's user, as the daemon reports it.
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { ApiError, asApiError, send } from '../transport/calls';

export type Role = 'ingest' | 'watch' | 'operator' | 'admin';
const ROLES: readonly Role[] = ['ingest', 'watch', 'operator', 'admin'];

export interface Account {
  version: string;  // version of the daemon
  asksForTokens: boolean;
  loggedIn: boolean;
  name: string;  // name of the token; empty without a token
  role: Role;
  projects: readonly string[];  // the projects that the token allows; empty: all
  stableProbability: number;  // a scene is stable when the leader's P(best) is at least this
  tieLossRatio: number;  // a scene that is not stable is a tie when the expected loss is at most this
}

const held = signal<Account | undefined>(undefined);
// Undefined until the daemon has answered.
export const account: ReadonlySignal<Account | undefined> = held;

const failed = signal<ApiError | undefined>(undefined);
export const accountError: ReadonlySignal<ApiError | undefined> = failed;

// Whether the user has at least the role `least`. The daemon checks every call; the page only hides calls that would be refused.
export const mayDo = (least: Role): ReadonlySignal<boolean> =>
  computed(() => ROLES.indexOf(held.value?.role ?? 'ingest') >= ROLES.indexOf(least));
export const isOperator = mayDo('operator');

// Whether this page was logged in before; the login view then explains that the login has ended.
let wasLoggedIn = false;
export const hasLostLogin = () => wasLoggedIn;

// The thresholds of verdicts, which charts draw. The daemon computes the verdicts.
export const thresholds = computed(() => ({ stableProbability: held.value?.stableProbability ?? Number.NaN, tieLossRatio: held.value?.tieLossRatio ?? Number.NaN }));

export const needsLogin = computed(() => held.value?.asksForTokens === true && !held.value.loggedIn);

export async function learnAccount(): Promise<void> {
  try {
    const response = await send('/api/whoami', { signal: AbortSignal.timeout(10_000) });
    held.value = { ...(await response.json() as Account) };
    wasLoggedIn ||= held.value.loggedIn;
    failed.value = undefined;
  } catch (error) {
    failed.value = asApiError(error);
  }
}

// Throws ApiError.
export async function login(token: string): Promise<void> {
  await send('/login', { method: 'POST', body: JSON.stringify({ token }) });
  await learnAccount();
}

export async function logout(): Promise<void> {
  await send('/logout', { method: 'POST' });
  location.assign('/');  // a reload removes all data from the page's memory
}
