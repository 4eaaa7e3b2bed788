// The dialog that revokes the evidence of sources, or promotes imports in quarantine. It shows a preview first.
import { signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { type LeaderChanges, PriorsService } from '../../../gen/sweepstake/v1/priors_pb';
import { grouped } from '../../../format';
import { timeText } from '../../parts/clock';
import { Arm } from '../../parts/arm';
import { Modal } from '../../parts/dialog';
import { Name, visible } from '../../parts/name';
import { toast } from '../../parts/toast';
import { account, isOperator } from '../../state/account';
import { asApiError, call } from '../../transport/calls';
import { type Reading, useReading } from '../../transport/reading';

/** Selects the sources that match all fields that are set. unixFromS and unixUntilS limit the start time of a source. */
export interface Scope { project?: string; sourceId?: string; build?: string; tokenId?: bigint; unixFromS?: bigint; unixUntilS?: bigint }

type Action = 'promote' | 'revoke';
interface Counts { sourceCount: bigint; recordCount: bigint; windowCount: bigint; sceneCount?: bigint; leaderChanges?: LeaderChanges }

const DEEDS = {
  revoke: { verb: 'Revoke', title: 'Revoke evidence?', done: 'Revoked', notDone: 'Not revoked', would: 'would be revoked', what: 'what would be revoked',
    none: 'Nothing would be revoked: no source matches, or each matching source is revoked already.', method: PriorsService.method.revokePriors },
  promote: { verb: 'Promote', title: 'Promote imports?', done: 'Promoted', notDone: 'Not promoted', would: 'would be promoted', what: 'what would be promoted',
    none: 'Nothing would be promoted: no evidence in quarantine matches.', method: PriorsService.method.promotePriors },
} as const;

interface Asked { action: Action; scope: Scope; isOpen: boolean } // isOpen: the user selects the sources in the dialog

const asked = signal<Asked | undefined>(undefined);
const REASON_ID = 'priors-reason';

const operatorReason = () => (isOperator.value ? '' : `Promoting and revoking need the role operator; yours is ${account.value?.role ?? 'not known'}.`);

export const OperatorReason = () => <span id={REASON_ID} class="soft">{operatorReason()}</span>;

// A button that opens the dialog. `scope` selects the sources, and `of` names them, such as "build 1.2".
interface ButtonProps { scope: Scope; of?: string }

function QuestionButton({ action, scope, of, isOpen, all }: ButtonProps & { action: Action; isOpen: boolean; all: string }) {
  const reason = operatorReason();
  return (
    <button type="button" class={of ? 'quiet' : undefined} disabled={reason !== ''} title={reason || undefined} aria-describedby={reason ? REASON_ID : undefined}
      aria-label={of && `${DEEDS[action].verb} ${visible(of)}`} onClick={() => { asked.value = { action, scope, isOpen }; }}>{of ? `${DEEDS[action].verb} …` : all}</button>
  );
}

export const RevokeButton = (props: ButtonProps) => <QuestionButton {...props} action="revoke" isOpen={!props.of} all="Revoke …" />;

export const PromoteButton = (props: ButtonProps) => <QuestionButton {...props} action="promote" isOpen={false} all="Promote all …" />;

const many = (count: bigint, one: string, several = `${one}s`) => `${grouped(Number(count))} ${count === 1n ? one : several}`;
const countsText = ({ sourceCount, recordCount, windowCount, sceneCount }: Counts) =>
  `${many(sourceCount, 'source')} with ${many(recordCount, 'record')} of ${many(windowCount, 'window or visit', 'windows and visits')}${
    sceneCount === undefined ? '' : ` for ${many(sceneCount, 'scene')}`}`;

const ask = (action: Action, sources: Scope, preview: boolean): Promise<Counts> =>
  (action === 'promote' ? call(DEEDS.promote.method, { sources, preview }) : call(DEEDS.revoke.method, { sources, preview }));

async function act(action: Action, scope: Scope): Promise<void> {
  const { done, notDone } = DEEDS[action];
  try {
    toast(`${done}: ${countsText(await ask(action, scope, false))}.`);
  } catch (error) {
    const { code, message } = asApiError(error);
    toast(code === 'UNREACHABLE' ? `The page does not know whether the daemon did this: ${message}. Click “Read again” to check.` : `${notDone}: ${message}`, { isBad: true });
  }
}

function ScopeWords({ action, scope: { project, sourceId, build, tokenId, unixFromS, unixUntilS } }: { action: Action; scope: Scope }) {
  return (
    <p>
      This concerns all {action === 'promote' ? 'imports in quarantine' : 'evidence'} {project ? <>in project <Name text={project} /></> : 'in all projects'}
      {sourceId && <> of source <Name text={sourceId} /></>}
      {build && <> of build <Name text={build} /></>}
      {tokenId !== undefined && <> of sessions that began with the token number {String(tokenId)}</>}
      {unixFromS !== undefined && <>, if its source began at or after {timeText(1000 * Number(unixFromS))}</>}
      {unixUntilS !== undefined && <>, if its source began at or before {timeText(1000 * Number(unixUntilS))}</>}.
    </p>
  );
}

const isAny = ({ sourceCount, recordCount }: Counts) => sourceCount > 0n || recordCount > 0n;

function PreviewWords({ action, preview: { value: counts, error } }: { action: Action; preview: Reading<Counts | undefined> }) {
  const { what, none, would } = DEEDS[action];
  if (error) return <span class="problem">{error.message}</span>;
  if (!counts) return <>Asking the daemon {what} …</>;
  return isAny(counts) ? <b>{countsText(counts)} {would}.</b> : <>{none}</>;
}

function Leaders({ changes }: { changes: LeaderChanges | undefined }) {
  if (!changes) return null;
  const { scenes, sceneCount } = changes;
  if (sceneCount === 0n) return <p>The same algorithm would lead in every scene.</p>;
  const hidden = Number(sceneCount) - scenes.length;
  return (
    <>
      <p>Another algorithm, or none, would lead in {many(sceneCount, 'scene')}:</p>
      <ul>
        {scenes.map(({ project, scene, machineClass, rewardVersion, arm, nextArm }) => (
          <li key={[project, scene, machineClass, rewardVersion].join('\n')}>
            <Name text={project} /> / <Name text={scene} />{machineClass && <> on <Name text={machineClass} /></>}: <Arm name={nextArm} /> in place of <Arm name={arm} />
          </li>
        ))}
        {hidden > 0 && <li>and {grouped(hidden)} more</li>}
      </ul>
    </>
  );
}

const secondsOf = (localTime: string) => (localTime ? BigInt(Math.floor(Date.parse(localTime) / 1000)) : undefined);

// Returns the scope of the form. Undefined fields match any value.
function scopeOf(form: HTMLFormElement): Scope {
  const fields = new FormData(form);
  const text = (name: string) => String(fields.get(name) ?? '').trim();
  const all = { project: text('project'), sourceId: text('sourceId'), build: text('build'), tokenId: text('tokenId') ? BigInt(Math.trunc(Number(text('tokenId')))) : undefined,
    unixFromS: secondsOf(text('from')), unixUntilS: secondsOf(text('until')) };
  return Object.fromEntries(Object.entries(all).filter(([, value]) => value !== undefined && value !== ''));
}

function Choose({ name, label, values, chosen = '' }: { name: string; label: string; values: readonly string[]; chosen?: string | undefined }) {
  return (
    <label><span>{label}</span>
      <select name={name}>
        <option value="">any</option>
        {values.map((value) => <option key={value} value={value} selected={value === chosen}>{visible(value)}</option>)}
      </select>
    </label>
  );
}

interface Known { projects: readonly string[]; builds: readonly string[] }

function ScopeForm({ scope, known: { projects, builds }, onChange, onAsk }: { scope: Scope; known: Known; onChange(): void; onAsk(scope: Scope): void }) {
  const submit = (event: Event) => {
    event.preventDefault();
    onAsk(scopeOf(event.currentTarget as HTMLFormElement));
  };
  return (
    <form id="revoke-scope" class="fields" onSubmit={submit} onInput={onChange}>
      <Choose name="project" label="Project" values={projects} chosen={scope.project} />
      <Choose name="build" label="Build" values={builds} />
      <label><span>Source</span><input name="sourceId" maxLength={128} spellcheck={false} placeholder="any" /></label>
      <label><span>Number of the token</span><input name="tokenId" type="number" min="1" step="1" placeholder="any" /></label>
      <label><span>Began at or after</span><input name="from" type="datetime-local" step="1" /></label>
      <label><span>Began at or before</span><input name="until" type="datetime-local" step="1" /></label>
    </form>
  );
}

const Consequences = ({ action }: { action: Action }) => (action === 'promote'
  ? <p class="soft small">New sessions start from this evidence, and the posteriors of its scenes change. To undo the promotion, revoke the evidence. The audit log
    records who promoted it.</p>
  : <p class="soft small">New sessions start without this evidence, and an import cannot restore it. Running sessions continue, but their later evidence does not
    count. Sessions that begin later are other sources, even with the same build. <b>This cannot be undone.</b> The audit log records who revoked it.</p>);

function Dialog({ question: { action, scope: start, isOpen }, known, onClose, onDone }: { question: Asked; known: Known; onClose(): void; onDone(): void }) {
  const [scope, setScope] = useState<Scope | undefined>(isOpen ? undefined : start);
  const preview = useReading(scope, async () => scope && ask(action, scope, true));
  const { title, verb } = DEEDS[action];
  const goes = preview.value !== undefined && isAny(preview.value);
  const confirm = async () => {
    onClose();
    await act(action, scope!);
    onDone();
  };
  return (
    <Modal title={title} onClose={onClose}>
      {isOpen && <ScopeForm scope={start} known={known} onChange={() => setScope(undefined)} onAsk={setScope} />}
      {scope && <ScopeWords action={action} scope={scope} />}
      <p role="status">{scope && <PreviewWords action={action} preview={preview} />}</p>
      {goes && <Leaders changes={preview.value!.leaderChanges} />}
      <Consequences action={action} />
      <p class="buttons">
        <button type="button" autoFocus={!isOpen} onClick={onClose}>Cancel</button>
        {isOpen && <button type="submit" form="revoke-scope">Preview</button>}
        <button type="button" class={action === 'revoke' ? 'danger' : undefined} disabled={!goes} onClick={() => void confirm()}>{verb}</button>
      </p>
    </Modal>
  );
}

/** The dialog that RevokeButton and PromoteButton open. `onDone` is called when evidence may have changed. */
export function PriorsQuestion({ known, onDone }: { known: Known; onDone(): void }) {
  const close = () => { asked.value = undefined; };
  useEffect(() => close, []);
  return asked.value ? <Dialog question={asked.value} known={known} onClose={close} onDone={onDone} /> : null;
}
