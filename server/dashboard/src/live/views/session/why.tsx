// "Why this algorithm?": explains one decision in sentences, and shows all fields of its audit row.
import { useEffect } from 'preact/hooks';
import { kindWord } from '../words';
import { costOfSwitch, explained, explainedRow } from '../../audit/explain';
import { entriesOf, rowId } from '../../audit/log';
import type { Step } from '../../audit/steps';
import { timeText } from '../../parts/clock';
import { addShortcuts } from '../../parts/keys';
import { Name, visible } from '../../parts/name';
import { decisionsHref } from '../../state/route';

/** `done` is the step in which the game executed the switch that this decision commanded, if the view has it. `isLast`: it is
 * the session's last switch. */
export function Why({ step, done, isLast = false, sessionId, onRead, onClose }: { step: Step; done?: Step | undefined; isLast?: boolean; sessionId: string; onRead: () => void; onClose: () => void }) {
  useEffect(() => addShortcuts([{ keys: 'Escape', what: 'Close the explanation', run: onClose }]), []);
  const { placed, told, timeMs, decisionId } = step;
  const [first = '', second = '', ...others] = placed ? explainedRow(placed.row, placed.setup) : told ? explained(told) : [];
  return (
    <section class="why" aria-labelledby="why-heading">
      <header class="title">
        <h2 id="why-heading">{decisionId > 0 ? `${isLast ? 'Last switch: decision' : 'Decision'} ${decisionId}` : kindWord(step.kind).name}, {timeText(timeMs)}</h2>
        <button type="button" class="quiet" onClick={onClose}>Close</button>
      </header>
      <p><bdi>{visible(first)}</bdi></p>
      <p><bdi>{visible(second)}</bdi>{done?.placed && ` ${costOfSwitch(done.placed.row)}`}</p>
      {others.length > 0 && <details><summary>More</summary>{others.map((sentence) => <p key={sentence}><bdi>{visible(sentence)}</bdi></p>)}</details>}
      {!placed && <p class="soft">Its audit row was not read yet. <button type="button" onClick={onRead}>Read the audit row</button></p>}
      {placed && (
        <details>
          <summary>Audit row</summary>
          <dl>{entriesOf(placed.row).map(([name, text]) => [<dt key={name}>{name}</dt>, <dd key={`${name}=`}><Name text={text} /></dd>])}</dl>
          <p><a href={decisionsHref({ session: sessionId, row: rowId(placed.row) })}>Link to this row</a></p>
        </details>
      )}
    </section>
  );
}
