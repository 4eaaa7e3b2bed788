import { expect, it } from 'vitest';
import { AlertSchema, ListAlertsResponseSchema } from '../../gen/sweepstake/v1/alerts_pb';
import { ApiError } from '../transport/calls';
import { create } from '../transport/messages';
import { alerts, alertsError, hrefOf, seriousCount } from './alerts';

it('leads from an alert to its scene, or to the health of the daemon', () => {
  expect(hrefOf(create(AlertSchema, { project: 'game', scene: 'a b', machineClass: 'desktop', rewardVersion: 3 })))
    .toBe('/scenes/game/a%20b?class=desktop&reward=3');
  expect(hrefOf(create(AlertSchema, { rule: 'check' }))).toBe('/health');
});

it('counts an answer that cannot be read as a serious problem', () => {
  expect(seriousCount.value).toBe(0);
  alerts.value = create(ListAlertsResponseSchema, { alertCount: 5, seriousCount: 2 });
  expect(seriousCount.value).toBe(2);
  alertsError.value = new ApiError('UNAVAILABLE', '', 'the daemon is draining');
  expect(seriousCount.value).toBe(3);
});
