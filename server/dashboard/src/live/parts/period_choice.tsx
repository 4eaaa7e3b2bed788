// The choice of the period that charts show: the latest minutes to weeks, or two times.
import { period, PERIODS, range, setRange } from '../charts/view_state';
import { setQuery } from '../state/route';
import { Select, TimeInput } from './filter';

const BETWEEN = 'between';
const OPTIONS = [...PERIODS.map(({ name, words }) => [name, words] as const), [BETWEEN, 'from … to …'] as const];

export function PeriodChoice() {
  const chosen = range.value;
  const choose = (name: string) => {
    if (name === BETWEEN) return setRange({ fromMs: Date.now() - (period.peek().lengthMs || 86_400_000), toMs: Date.now() });
    return setQuery({ period: name === PERIODS[0]!.name ? undefined : name, from: undefined, to: undefined }, { step: true });
  };
  return (
    <>
      <Select label="Period" value={chosen ? BETWEEN : period.value.name} options={OPTIONS} onChange={choose} />
      {chosen && (
        <>
          <TimeInput label="From" unixMs={chosen.fromMs} onChange={(ms) => ms && setRange({ ...chosen, fromMs: ms })} />
          <TimeInput label="To" unixMs={chosen.toMs} onChange={(ms) => ms && setRange({ ...chosen, toMs: ms })} />
          <button type="button" onClick={() => setRange(undefined)}>Show all</button>
        </>
      )}
    </>
  );
}
