// The choice of the period that charts show: the latest minutes to weeks, or two times.
import { range, setRange } from '../charts/view_state';
import { period, PERIODS } from '../state/period';
import { setQuery } from '../state/route';

const BETWEEN = 'between';

// The form of times in <input type="datetime-local">, in the time zone of the browser.
const localText = (ms: number) => new Date(ms - new Date(ms).getTimezoneOffset() * 60_000).toISOString().slice(0, 19);

function Time({ label, ms, onChange }: { label: string; ms: number; onChange(ms: number): void }) {
  return (
    <label class="choice"><span>{label}</span>
      <input type="datetime-local" step="1" value={localText(ms)} onChange={({ currentTarget: { value } }) => { const next = new Date(value).getTime(); if (Number.isFinite(next)) onChange(next); }} />
    </label>
  );
}

export function PeriodChoice() {
  const chosen = range.value;
  const choose = (name: string) => {
    if (name === BETWEEN) return setRange({ fromMs: Date.now() - (period.peek().lengthMs || 86_400_000), toMs: Date.now() });
    return setQuery({ period: name === PERIODS[0]!.name ? undefined : name, from: undefined, to: undefined }, { step: true });
  };
  return (
    <>
      <label class="choice"><span>Period</span>
        <select value={chosen ? BETWEEN : period.value.name} onChange={({ currentTarget: { value } }) => choose(value)}>
          {PERIODS.map(({ name, words }) => <option key={name} value={name}>{words}</option>)}
          <option value={BETWEEN}>from … to …</option>
        </select>
      </label>
      {chosen && <><Time label="From" ms={chosen.fromMs} onChange={(fromMs) => setRange({ ...chosen, fromMs })} /><Time label="To" ms={chosen.toMs} onChange={(toMs) => setRange({ ...chosen, toMs })} />
        <button type="button" onClick={() => setRange(undefined)}>Show all</button></>}
    </>
  );
}
