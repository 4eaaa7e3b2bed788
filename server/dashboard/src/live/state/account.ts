// The account of the page's user, as the daemon reports it.
import { computed, signal } from '@preact/signals';
import { ApiError, asApiError, send, urlOf } from '../transport/calls';

interface Account {
  version: string;  // version of the daemon
  asksForTokens: boolean;
  loggedIn: boolean;
  name: string;  // name of the token; empty without a token
  role: 'player' | 'ticket' | 'ingest' | 'watch' | 'operator' | 'admin';
  stableProbability: number;  // minimum of the leader's P(best) for the verdict "stable"
}

export const account = signal<Account | undefined>(undefined);
export const accountError = signal<ApiError | undefined>(undefined);

// Whether the user may give orders. The daemon checks every call; the page only hides calls that would be refused.
export const isOperator = computed(() => ['operator', 'admin'].includes(account.value?.role ?? ''));

// Whether this page was logged in before; the login view then explains that the login has ended.
let wasLoggedIn = false;
export const hasLostLogin = () => wasLoggedIn;

export const stableProbability = computed(() => account.value?.stableProbability ?? Number.NaN);

export const needsLogin = computed(() => account.value?.asksForTokens === true && !account.value.loggedIn);

export async function learnAccount(): Promise<void> {
  try {
    const response = await send('/api/whoami', { signal: AbortSignal.timeout(10_000) });
    account.value = { ...(await response.json() as Account) };
    wasLoggedIn ||= account.value.loggedIn;
    accountError.value = undefined;
  } catch (error) {
    accountError.value = asApiError(error);
  }
}

// Throws ApiError.
export async function login(token: string): Promise<void> {
  await send('/login', { method: 'POST', body: JSON.stringify({ token }) });
  await learnAccount();
}

export async function logout(): Promise<void> {
  await send('/logout', { method: 'POST' });
  location.assign(urlOf('/'));  // a reload removes all data from the page's memory
}
