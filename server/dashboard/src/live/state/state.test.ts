import { create, type Init } from '../transport/messages';
import { beforeEach, describe, expect, it } from 'vitest';
import { DecisionEventSchema, DecisionOutcome, ScenePosteriorSchema, type DecisionEvent, type ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionEnd, SessionEndedSchema, type SessionInfo, SessionInfoSchema, SessionState as Link } from '../../gen/sweepstake/v1/sessions_pb';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import * as scenes from './scenes';
import * as sessions from './sessions';
import { isDegraded, summaryOf } from './summaries';

const posteriorOf = (scene: string, alpha = 2, beta = 2, rewardVersion = 3): ScenePosterior => create(ScenePosteriorSchema, {
  project: 'p', scene, rewardVersion,
  arms: [{ arm: 'SAP', backendVersion: 1, posterior: { alpha, beta } }, { arm: 'Grid', backendVersion: 1, posterior: { alpha: 5, beta: 5 } }],
});
const decisionOf = (scene: string, decisionId: number, more: { rewardVersion?: number; verdict?: Verdict } = {}) =>
  create(DecisionEventSchema, { project: 'p', scene, sessionId: 's1', decisionId: BigInt(decisionId), rewardVersion: 3, ...more });
const keyOf = (scene: string, rewardVersion = 3) => scenes.sceneKey({ project: 'p', scene, machineClass: '', rewardVersion });
const stateOf = (scene: string) => scenes.scenes.peek().get(keyOf(scene))!;

describe('scenes', () => {
  beforeEach(() => {
    scenes.takeSnapshot([]);
    scenes.sceneInView.value = '';
  });

  it('are those of the snapshot, and keep their decisions', () => {
    scenes.takeSnapshot([posteriorOf('a'), posteriorOf('b')]);
    scenes.takeChanges([], [decisionOf('a', 1)]);
    scenes.takeSnapshot([posteriorOf('a', 9), posteriorOf('c')]);
    expect([...scenes.scenes.peek().keys()]).toEqual([keyOf('a'), keyOf('c')]);
    expect(stateOf('a').decisions).toHaveLength(1);
    expect(stateOf('a').posterior.arms[0]?.posterior?.alpha).toBe(9);
    expect(stateOf('c').changedMs).toBe(0);
  });

  it('have the time of their latest evidence, until a change is received', () => {
    const seen = { ...posteriorOf('a'), arms: posteriorOf('a').arms.map((arm) => ({ ...arm, unixLastSeenS: 5n })) };
    scenes.takeSnapshot([seen]);
    expect(stateOf('a').changedMs).toBe(5000);
    scenes.takeChanges([seen], []);
    expect(stateOf('a').changedMs).toBeGreaterThan(5000);
  });

  it('receive decisions with their version of the reward, and ignore those of unknown scenes', () => {
    scenes.takeSnapshot([posteriorOf('a'), posteriorOf('a', 2, 2, 1)]);
    scenes.takeChanges([], [decisionOf('a', 1), decisionOf('a', 2, { rewardVersion: 1 }), decisionOf('x', 3)]);
    expect(stateOf('a').decisions.map(({ decisionId }) => decisionId)).toEqual([1n]);
    expect(scenes.scenes.peek().get(keyOf('a', 1))!.decisions.map(({ decisionId }) => decisionId)).toEqual([2n]);
  });

  it('keep the last decisions, more of the scene in view than of the others', () => {
    const names = Array.from({ length: 400 }, (_, i) => `s${i}`);
    scenes.takeSnapshot(names.map((name) => posteriorOf(name)));
    scenes.sceneInView.value = keyOf('s0');
    const decisions = Array.from({ length: 600 }, (_, i) => [decisionOf('s0', i), decisionOf('s1', i)]).flat();
    scenes.takeChanges([], decisions);
    expect(stateOf('s0').decisions).toHaveLength(500);
    expect(stateOf('s1').decisions).toHaveLength(scenes.MAX_DECISIONS / 400);
    expect(stateOf('s1').decisions.at(-1)!.decisionId).toBe(599n);
  });
});

describe('sessions', () => {
  const info = (sessionId: string, state = Link.CONNECTED) => create(SessionInfoSchema, { sessionId, state });
  beforeEach(() => sessions.takeSnapshot([]));
  const ids = () => [...sessions.sessions.peek().keys()];

  it('have the time of the last message of the game, also from decisions with frames', () => {
    const session = { info: create(SessionInfoSchema, { unixLastMessageMs: 50n }), decisions: [] };
    const decided = (unixMs: bigint, outcome: DecisionOutcome) => create(DecisionEventSchema, { unixMs, outcome });
    expect(sessions.lastMessageMs(session)).toBe(50);
    expect(sessions.lastMessageMs({ ...session, decisions: [decided(70n, DecisionOutcome.KEPT), decided(90n, DecisionOutcome.NO_FRAMES)] })).toBe(70);
    expect(sessions.lastMessageMs({ ...session, decisions: [decided(90n, DecisionOutcome.NO_FRAMES)] })).toBe(50);
  });

  it('end with a reason or without one, and a session that comes back keeps its decisions', () => {
    sessions.takeSnapshot([info('s1'), info('s2')]);
    sessions.takeDecisions([decisionOf('a', 1)]);
    sessions.takeChanges([], [create(SessionEndedSchema, { sessionId: 's2', end: SessionEnd.KICKED })]);
    expect(sessions.sessions.peek().get('s2')!.ended!.end).toBe(SessionEnd.KICKED);
    sessions.takeSnapshot([]);
    expect(sessions.sessions.peek().get('s1')!.ended!.end).toBe(SessionEnd.UNSPECIFIED);
    expect(sessions.connectedSessions.peek()).toHaveLength(0);
    sessions.takeSnapshot([info('s1')]);
    const back = sessions.sessions.peek().get('s1')!;
    expect(back.ended).toBeUndefined();
    expect(back.decisions).toHaveLength(1);
    expect(sessions.connectedSessions.peek()).toHaveLength(1);
  });

  it('drop the sessions that ended first', () => {
    const many = Array.from({ length: sessions.MAX_ENDED_SESSIONS + 10 }, (_, i) => `e${i}`);
    sessions.takeChanges(many.map((id) => info(id)), []);
    sessions.takeChanges([], many.map((sessionId) => create(SessionEndedSchema, { sessionId, end: SessionEnd.GOODBYE })));
    expect(ids().filter((id) => id.startsWith('e'))).toHaveLength(sessions.MAX_ENDED_SESSIONS);
    expect(ids()).toContain('e59');
    expect(ids()).not.toContain('e0');
  });
});

describe('summaries', () => {
  const state = (posterior: ScenePosterior, decisions: DecisionEvent[] = []): scenes.SceneState =>
    ({ key: 'k', posterior, changedMs: 0, decisions });

  const judged = (verdict: Verdict, probability: number) => {
    const scene = posteriorOf('a');
    scene.arms[0]!.bestProbability = probability;
    return { ...scene, verdict, leaderArm: 'SAP' };
  };

  it('sort degraded scenes first, then uncertain ones', () => {
    const stable = summaryOf(state(judged(Verdict.STABLE, 0.99)));
    const open = summaryOf(state(judged(Verdict.AMBIGUOUS, 0.5)));
    const says = [decisionOf('a', 1, { verdict: Verdict.DEGRADED })];
    sessions.takeSnapshot([create(SessionInfoSchema, { sessionId: 's1', state: Link.CONNECTED })]);
    const degraded = summaryOf(state(judged(Verdict.STABLE, 0.99), says));
    expect(stable.verdict).toBe(Verdict.STABLE);
    expect(degraded.verdict).toBe(Verdict.DEGRADED);
    expect(open.uncertainty).toBeGreaterThan(stable.uncertainty);
    expect(degraded.uncertainty).toBeGreaterThan(open.uncertainty);
    sessions.takeSnapshot([]);
    expect(summaryOf(state(judged(Verdict.STABLE, 0.99), says)).verdict).toBe(Verdict.STABLE); // the session that reported it has ended
  });

  it('call a scene degraded while the last verdict of a connected session is degraded, whatever other sessions report', () => {
    const is = (...infos: Init<SessionInfo>[]) => {
      sessions.takeSnapshot(infos.map((info) => create(SessionInfoSchema, info)));
      return (...decisions: DecisionEvent[]) => isDegraded({ decisions }, sessions.sessions.peek());
    };
    const says = (sessionId: string, verdict: Verdict) => create(DecisionEventSchema, { sessionId, verdict });
    const bad = says('s1', Verdict.DEGRADED);
    const connected = { sessionId: 's1', state: Link.CONNECTED };
    expect(is(connected)(bad)).toBe(true);
    expect(is(connected)(bad, says('s2', Verdict.STABLE))).toBe(true);
    expect(is(connected)(bad, says('s1', Verdict.STABLE))).toBe(false);
    expect(is({ ...connected, state: Link.LOST })(bad)).toBe(false);
    expect(is()(bad), 'of a session that ended').toBe(false);
  });
});
