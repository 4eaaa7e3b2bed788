// Taking the evidence of sources out of the daemon: what would go is shown first.
import { signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { PriorsService, type RevokePriorsResponse } from '../../../gen/sweepstake/v1/priors_pb';
import { grouped } from '../../../format';
import { timeText } from '../../parts/clock';
import { Modal } from '../../parts/dialog';
import { Name } from '../../parts/name';
import { toast } from '../../parts/toast';
import { visible } from '../../parts/visible';
import { account, isOperator } from '../../state/account';
import { type ApiError, asApiError, call } from '../../transport/calls';

/** Which sources: those that match all that is set. Times are seconds since 1970, of when they began. */
export interface Scope { project?: string; sourceId?: string; build?: string; tokenId?: bigint; unixFromS?: bigint; unixUntilS?: bigint }

interface Asked { scope: Scope; isOpen: boolean } // open: the reader says which

const asked = signal<Asked | undefined>(undefined);
const REASON_ID = 'revoke-reason';

export const revokeReason = () => (isOperator.value ? '' : `Revoking needs the role operator; yours is ${account.value?.role ?? 'not known'}.`);

/** Why the buttons do nothing, where they do nothing. */
export const RevokeReason = () => <span id={REASON_ID} class="soft">{revokeReason()}</span>;

/** Asks about the sources of the scope, or, without `of`, lets the reader say which. */
export function RevokeButton({ scope, of }: { scope: Scope; of?: string }) {
  const reason = revokeReason();
  return (
    <button type="button" class={of ? 'quiet' : undefined} disabled={reason !== ''} title={reason || undefined} aria-describedby={reason ? REASON_ID : undefined}
      aria-label={of && `Revoke ${visible(of)}`} onClick={() => { asked.value = { scope, isOpen: !of }; }}>Revoke …</button>
  );
}

const countsText = ({ sourceCount, recordCount, windowCount }: RevokePriorsResponse) =>
  `${grouped(Number(sourceCount))} sources with ${grouped(Number(recordCount))} records of ${grouped(Number(windowCount))} windows and visits`;

// What is asked about: a scope, what the daemon says would go, or why it does not say so.
interface Preview { scope: Scope; counts?: RevokePriorsResponse; error?: ApiError }

function usePreview(scope: Scope | undefined): Preview | undefined {
  const [preview, setPreview] = useState<Preview | undefined>(undefined);
  useEffect(() => {
    let isCurrent = scope !== undefined;
    setPreview(undefined);
    if (scope) {
      call(PriorsService.method.revokePriors, { ...scope, preview: true }).then(
        (counts) => { if (isCurrent) setPreview({ scope, counts }); },
        (error: unknown) => { if (isCurrent) setPreview({ scope, error: asApiError(error) }); });
    }
    return () => { isCurrent = false; };
  }, [scope]);
  return preview?.scope === scope ? preview : undefined;
}

async function revoke(scope: Scope): Promise<void> {
  try {
    toast(`Revoked: ${countsText(await call(PriorsService.method.revokePriors, scope))}.`);
  } catch (error) {
    const { code, message } = asApiError(error);
    toast(code === 'UNREACHABLE' ? `It is not known whether it was done: ${message}. Read again.` : `Not revoked: ${message}`, { isBad: true });
  }
}

function ScopeWords({ scope: { project, sourceId, build, tokenId, unixFromS, unixUntilS } }: { scope: Scope }) {
  return (
    <p>
      All evidence {project ? <>in project <Name text={project} /></> : 'in all projects'}
      {sourceId && <> of source <Name text={sourceId} /></>}
      {build && <> of build <Name text={build} /></>}
      {tokenId !== undefined && <> of sessions that began with token {String(tokenId)}</>}
      {unixFromS !== undefined && <> from {timeText(1000 * Number(unixFromS))} on</>}
      {unixUntilS !== undefined && <> until {timeText(1000 * Number(unixUntilS))}</>}.
    </p>
  );
}

function PreviewWords({ preview }: { preview: Preview | undefined }) {
  if (!preview) return <>Asking the daemon what would go …</>;
  if (preview.error) return <span class="problem">{preview.error.message}</span>;
  return preview.counts!.sourceCount === 0n ? <>Nothing would go: no source that is not revoked already matches.</> : <b>{countsText(preview.counts!)} would go.</b>;
}

const secondsOf = (localTime: string) => (localTime ? BigInt(Math.floor(Date.parse(localTime) / 1000)) : undefined);

// The scope that a form says; undefined fields are any.
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
  const ask = (event: Event) => {
    event.preventDefault();
    onAsk(scopeOf(event.currentTarget as HTMLFormElement));
  };
  return (
    <form id="revoke-scope" class="fields" onSubmit={ask} onInput={onChange}>
      <Choose name="project" label="Project" values={projects} chosen={scope.project} />
      <Choose name="build" label="Build" values={builds} />
      <label><span>Source</span><input name="sourceId" maxLength={128} spellcheck={false} placeholder="any" /></label>
      <label><span>Number of the token</span><input name="tokenId" type="number" min="1" step="1" placeholder="any" /></label>
      <label><span>Began at or after</span><input name="from" type="datetime-local" step="1" /></label>
      <label><span>Began at or before</span><input name="until" type="datetime-local" step="1" /></label>
    </form>
  );
}

function Dialog({ question: { scope: start, isOpen }, known, onClose, onDone }: { question: Asked; known: Known; onClose(): void; onDone(): void }) {
  const [scope, setScope] = useState<Scope | undefined>(isOpen ? undefined : start);
  const preview = usePreview(scope);
  const goes = preview?.counts !== undefined && preview.counts.sourceCount > 0n;
  const act = async () => {
    onClose();
    await revoke(preview!.scope);
    onDone();
  };
  return (
    <Modal title="Revoke evidence?" onClose={onClose}>
      {isOpen && <ScopeForm scope={start} known={known} onChange={() => setScope(undefined)} onAsk={setScope} />}
      {scope && <ScopeWords scope={scope} />}
      <p role="status">{scope && <PreviewWords preview={preview} />}</p>
      <p class="soft small">New sessions begin without it. Sessions that run play on, and what they teach counts no more; no import brings it back. Sessions that begin
        later are other sources, of the same build too. <b>This cannot be undone.</b> The audit log says who did it.</p>
      <p class="buttons">
        <button type="button" autoFocus={!isOpen} onClick={onClose}>Cancel</button>
        {isOpen && <button type="submit" form="revoke-scope">Preview</button>}
        <button type="button" class="danger" disabled={!goes} onClick={() => void act()}>Revoke</button>
      </p>
    </Modal>
  );
}

/** The dialog of the buttons; `onDone` is called when something may have been revoked. */
export function RevokeHost({ known, onDone }: { known: Known; onDone(): void }) {
  const close = () => { asked.value = undefined; };
  useEffect(() => close, []);
  return asked.value ? <Dialog question={asked.value} known={known} onClose={close} onDone={onDone} /> : null;
}
