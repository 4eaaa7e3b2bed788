// What administrators did, as people say it: the rows of kind `admin` (AdminRows of engine_client/decider/audit/audit_log.h).
import { type AuditRow, setupParts } from './rows';

const OPERATOR = 'operator=';

/** Returns who gave an order or did something. The last part says it; names of builds and sessions before it may look like one. */
export const operatorOf = (cell: string) => setupParts(cell).filter((part) => part.startsWith(OPERATOR)).at(-1)?.slice(OPERATOR.length) || 'an operator';

const counted = (count: string | undefined, one: string) => `${count} ${one}${count === '1' ? '' : 's'}`;
const named = (what: string, name: string | undefined) => (name && name !== '0' ? [`${what} ${name}`] : []);

function orderWords(mode: string | undefined, arm: string | undefined, session: string | undefined): string {
  return mode === 'MODE_AI' ? `that the daemon decides in session ${session}` : `that session ${session} keeps to ${arm || 'its arm'}`;
}

function sourcesWords([, sources, records, project, source, build, token, from, until]: RegExpExecArray): string {
  const which = [...named('project', project), ...named('session', source), ...named('build', build), ...named('token', token),
    ...(from === '0' ? [] : [`begun at ${from} or later`]), ...(until === '0' ? [] : [`begun at ${until} or before`])];
  return `${counted(sources, 'source')} with ${counted(records, 'record')}: ${which.length > 0 ? `of ${which.join(', ')}` : 'all'}`;
}

const SOURCES = /^sources=(\d+) records=(\d+) project=(.*) source=(.*) build=(.*) token=(\d+) from=(\d+) until=(\d+)$/s;

// By the action: what is behind it, and who did what. What is not written so stays as it is.
const SENTENCES: Readonly<Record<string, [pattern: RegExp, say: (match: RegExpExecArray, who: string) => string]>> = {
  'kick': [/^session=(\S+) may_return=([01])$/, ([, session, returns], who) => (returns === '1' ? `${who} let session ${session} connect anew.` : `${who} ended session ${session}.`)],
  'order': [/^session=(\S+) mode=(\w+) arm=(.*)$/, ([, session, mode, arm], who) => `${who} asked ${orderWords(mode, arm, session)}.`],
  'order-answer': [/^answer=(\S+) session=(\S+) mode=(\w+) arm=(.*)$/, ([, answer, session, mode, arm], who) =>
    (answer === 'OK' ? `The game did what ${who} asked, ${orderWords(mode, arm, session)}.` : `It did not come to what ${who} asked, ${orderWords(mode, arm, session)}: ${answer}.`)],
  'revoke': [SOURCES, (match, who) => `${who} revoked ${sourcesWords(match)}.`],
  'promote': [SOURCES, (match, who) => `${who} promoted ${sourcesWords(match)}.`],
  'import': [/^records=(\d+) applied=(\d+) promoted=(yes|no)$/, ([, records, applied, promoted], who) =>
    `${who} imported ${counted(records, 'record')}, ${applied} of them new or newer, which ${promoted === 'yes' ? 'count at once' : 'wait in quarantine'}.`],
  'token': [/^$/, (_, who) => `${who.charAt(0).toUpperCase()}${who.slice(1)}.`], // who made it is part of that
};

/** Returns the sentence of a row. */
export function actionText(row: AuditRow): string {
  const cell = row.text('setup');
  const who = operatorOf(cell);
  const what = setupParts(cell)[1] ?? '';
  const [, action = '', rest = ''] = /^action=(\S+) ?(.*)$/s.exec(what) ?? [];
  const [pattern, say] = SENTENCES[action] ?? [];
  const match = pattern?.exec(rest);
  if (match) return say!(match, who);
  return `${who}: ${what}.`;
}
