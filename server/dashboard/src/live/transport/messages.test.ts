import { describe, expect, it } from 'vitest';
import { log } from '../audit/log.test.sample';
import { ExportDecisionsResponseSchema } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionEventSchema, DecisionOutcome, RegimePosteriorSchema } from '../../gen/sweepstake/v1/posteriors_pb';
import { BoxViewSchema } from '../../gen/sweepstake/v1/telemetry_pb';
import { create, fromJsonText, toJson, toJsonText } from './messages';

describe('messages', () => {
  it('of a real log are written as they were read', () => {
    const lines = log.split('\n').filter(Boolean);
    expect(lines.length).toBeGreaterThan(0);
    for (const line of lines) expect(toJson(ExportDecisionsResponseSchema, fromJsonText(ExportDecisionsResponseSchema, line))).toEqual(JSON.parse(line));
  });

  it('have default values for missing fields, and undefined for missing optional ones', () => {
    const event = fromJsonText(DecisionEventSchema, '{}');
    expect(event).toMatchObject({ sessionId: '', decisionId: 0n, outcome: DecisionOutcome.UNSPECIFIED, expectedLossRatio: 0, arms: [] });
    expect('reward' in event).toBe(false);
    expect(toJsonText(DecisionEventSchema, event)).toBe('{}');
    expect(fromJsonText(DecisionEventSchema, '{"reward":0}').reward).toBe(0);
    expect(toJsonText(DecisionEventSchema, create(DecisionEventSchema, { reward: 0, standings: [{ liveWindowCount: 3n }] }))).toBe('{"reward":0,"standings":[{"liveWindowCount":"3"}]}');
  });

  it('may have fields and values of a newer daemon', () => {
    expect(fromJsonText(DecisionEventSchema, '{"arms":["SAP"],"news":{"a":1},"outcome":"DECISION_OUTCOME_NEWER"}')).toMatchObject({ arms: ['SAP'], outcome: DecisionOutcome.UNSPECIFIED });
    expect(fromJsonText(DecisionEventSchema, '{"outcome":"DECISION_OUTCOME_KEPT"}').outcome).toBe(DecisionOutcome.KEPT);
    expect(fromJsonText(DecisionEventSchema, '{"outcome":99}').outcome).toBe(99);
  });

  it('may have numbers as text', () => {
    expect(fromJsonText(RegimePosteriorSchema, '{"speedMean":"Infinity","ranUs":"NaN","frameShare":"0.5"}')).toMatchObject({ speedMean: Infinity, ranUs: Number.NaN, frameShare: 0.5 });
    expect(fromJsonText(DecisionEventSchema, '{"decisionId":"9007199254740993"}').decisionId).toBe(9007199254740993n);
    expect(toJson(DecisionEventSchema, create(DecisionEventSchema, { expectedLossRatio: Infinity }))).toEqual({ expectedLossRatio: 'Infinity' });
  });

  it('have bytes in Base64, also in its variant for URLs', () => {
    const view = create(BoxViewSchema, { pairs: Uint8Array.of(0xfb, 0xff) });
    expect(toJson(BoxViewSchema, view)).toEqual({ pairs: '+/8=' });
    for (const text of ['+/8=', '-_8']) expect(fromJsonText(BoxViewSchema, JSON.stringify({ pairs: text }))).toEqual(view);
  });

  it('of another type are refused', () => {
    const isRefused = (text: string) => {
      try {
        fromJsonText(DecisionEventSchema, text);
        return false;
      } catch {
        return true;
      }
    };
    const wrong = ['', '[]', '1', 'null', '{"arms":"SAP"}', '{"arms":[1]}', '{"decisionId":1.5}', '{"decisionId":"x"}', '{"expectedLossRatio":true}', '{"expectedLossRatio":""}',
      '{"measurements":[]}', '{"standings":{}}', '{"outcome":true}', '{"sessionId":1}'];
    expect(wrong.filter((text) => !isRefused(text))).toEqual([]);
    expect(isRefused('{}')).toBe(false);
  });
});
