// A search field whose text is in the URL. The key "/" focuses it.
import { useEffect, useRef } from 'preact/hooks';
import { route, setQuery } from '../state/route';
import { addShortcuts } from './keys';

export function Filter({ label, parameter = 'q' }: { label: string; parameter?: string }) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => addShortcuts([{ keys: '/', what: label, run: () => input.current?.focus() }]), [label]);
  return (
    <label class="filter">
      <span class="unseen">{label}</span>
      <input ref={input} type="search" placeholder={`${label}  /`} value={route.value.query.get(parameter) ?? ''} spellcheck={false}
        onInput={(event) => setQuery({ [parameter]: event.currentTarget.value })}
        onKeyDown={(event) => event.key === 'Escape' && event.currentTarget.blur()} />
    </label>
  );
}

// Returns whether each word of the filter occurs in one of the texts.
export function matches(filter: string, texts: readonly string[]): boolean {
  const all = texts.join('\n').toLowerCase();
  return filter.toLowerCase().split(/\s+/).every((word) => all.includes(word));
}

/** The parameters of a place in pages of rows. Another filter begins at the first page. */
const PLACE = { older: undefined, newer: undefined };

// A selection whose value is in the URL. The first option is the default, which the URL omits.
export function Choice({ label, parameter, options }: { label: string; parameter: string; options: readonly (readonly [value: string, text: string])[] }) {
  const chosen = route.value.query.get(parameter) ?? options[0]?.[0] ?? '';
  return (
    <label class="choice">
      <span>{label}</span>
      <select value={chosen} onChange={(event) => setQuery({ ...PLACE, [parameter]: event.currentTarget.value === options[0]?.[0] ? undefined : event.currentTarget.value }, { step: true })}>
        {options.map(([value, text]) => <option key={value} value={value}>{text}</option>)}
      </select>
    </label>
  );
}

const inputTime = (unixMs: number) => new Date(unixMs - 60_000 * new Date(unixMs).getTimezoneOffset()).toISOString().slice(0, 19);

// A time in the browser's time zone. The URL has it in milliseconds since 1970.
export function TimeChoice({ label, parameter }: { label: string; parameter: string }) {
  const chosen = Number(route.value.query.get(parameter) ?? 0);
  const set = (text: string) => setQuery({ ...PLACE, [parameter]: text && String(new Date(text).getTime()) }, { step: true });
  return (
    <label class="choice">
      <span>{label}</span>
      <input type="datetime-local" step="1" value={chosen ? inputTime(chosen) : ''} onChange={(event) => set(event.currentTarget.value)} />
    </label>
  );
}
