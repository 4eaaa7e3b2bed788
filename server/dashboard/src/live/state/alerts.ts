// The alerts of the daemon. They are polled while the page is hidden, too, because their number is in its title.
import { computed, effect, signal } from '@preact/signals';
import { AlertsService, type Alert, type ListAlertsResponse } from '../../gen/sweepstake/v1/alerts_pb';
import { type ApiError, asApiError, call, urlOf } from '../transport/calls';
import { account, needsLogin } from './account';
import { repeat } from './health';
import { sceneHref } from './route';

const INTERVAL_MS = 10_000;

export const alerts = signal<ListAlertsResponse | undefined>(undefined);  // undefined: not known yet
export const alertsError = signal<ApiError | undefined>(undefined);

/** The number of serious alerts that are not muted. */
export const seriousCount = computed(() => (alerts.value?.seriousCount ?? 0) + (alertsError.value ? 1 : 0));

/** Returns the URL of the view about the alert. An alert without a project concerns the daemon. */
export const hrefOf = (alert: Alert) => (alert.project ? sceneHref(alert) : urlOf('/health'));

export async function learnAlerts(): Promise<void> {
  if (!account.peek() || needsLogin.peek()) return;
  try {
    alerts.value = await call(AlertsService.method.listAlerts, {});
    alertsError.value = undefined;
  } catch (error) {
    alertsError.value = asApiError(error);
  }
}

export function followAlerts(): void {
  effect(() => { if (account.value && !needsLogin.value) void learnAlerts(); });
  repeat(learnAlerts, INTERVAL_MS, true);
}
