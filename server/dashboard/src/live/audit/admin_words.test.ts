import { expect, it } from 'vitest';
import { actionText, operatorOf } from './admin_words';
import { RowReader } from './rows';

// As the daemon writes it (AdminRows): what was done and who did it, each with a backslash before what would end it.
const escaped = (text: string) => text.replace(/[\\;,]/g, '\\$&');
function said(action: string, who = 'ann'): string {
  const reader = new RowReader();
  reader.header('session,segment,row,kind,time_ns,setup');
  const cell = `unix_ms=7;${escaped(action)};operator=${escaped(who)}`;
  return actionText(reader.row(`admin,1,2,admin,5,"${cell.replaceAll('"', '""')}"`)!);
}
const sources = (project: string, build: string) => `sources=2 records=1 project=${project} source= build=${build} token=0 from=0 until=0`;

it('says who did what', () => {
  expect(said('action=kick session=a may_return=0')).toBe('ann ended session a.');
  expect(said('action=kick session=a may_return=1')).toBe('ann let session a connect anew.');
  expect(said('action=order session=a mode=MODE_AI arm=')).toBe('ann asked that the daemon decides in session a.');
  expect(said('action=order session=a mode=MODE_MANUAL arm=SAP')).toBe('ann asked that session a keeps to SAP.');
  expect(said('action=order-answer answer=OK session=a mode=MODE_MANUAL arm=')).toBe('The game did what ann asked, that session a keeps to its arm.');
  expect(said('action=order-answer answer=ORDER_SUPERSEDED session=a mode=MODE_AI arm=')).toBe('It did not come to what ann asked, that the daemon decides in session a: ORDER_SUPERSEDED.');
  expect(said('action=import records=12 applied=3 promoted=no')).toBe('ann imported 12 records, 3 of them new or newer, which wait in quarantine.');
  expect(said('action=token', 'token x was made by root: watch of all projects')).toBe('Token x was made by root: watch of all projects.');
});

it('says which sources', () => {
  expect(said(`action=revoke ${sources('arcade', '1.2')}`)).toBe('ann revoked 2 sources with 1 record: of project arcade, build 1.2.');
  expect(said(`action=promote ${sources('', '')}`)).toBe('ann promoted 2 sources with 1 record: all.');
});

it('does not take a name for who did it', () => {
  expect(said(`action=revoke ${sources('', 'b;operator=ceo')}`)).toBe('ann revoked 2 sources with 1 record: of build b;operator=ceo.');
  expect(said(`action=revoke ${sources('', 'b\\')}`)).toBe('ann revoked 2 sources with 1 record: of build b\\.');
  expect(operatorOf('operator=a\\;operator\\,b')).toBe('a;operator,b');
});

it('leaves what it does not know as it is', () => {
  expect(said('action=dance steps=3')).toBe('ann: action=dance steps=3.');
  expect(said('revoke token x')).toBe('ann: revoke token x.');
});
