// A search field whose text is in the URL. The key "/" focuses it.
import type { JSX } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { route, setQuery } from '../state/route';
import { addShortcuts } from './keys';

export function Filter({ label }: { label: string }) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => addShortcuts([{ keys: '/', what: label, run: () => input.current?.focus() }]), [label]);
  return (
    <label class="filter">
      <span class="unseen">{label}</span>
      <input ref={input} type="search" placeholder={`${label}  /`} value={route.value.query.get('q') ?? ''} spellcheck={false}
        onInput={(event) => setQuery({ q: event.currentTarget.value })}
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

interface SelectProps extends Pick<JSX.SelectHTMLAttributes, 'disabled' | 'onFocus'> {
  label: string;
  value: string;
  options: readonly (readonly [value: string, text: string])[];
  onChange(value: string): void;
}

export function Select({ label, options, onChange, ...rest }: SelectProps) {
  return (
    <label class="choice">
      <span>{label}</span>
      <select {...rest} onChange={(event) => onChange(event.currentTarget.value)}>
        {options.map(([value, text]) => <option key={value} value={value}>{text}</option>)}
      </select>
    </label>
  );
}

// A selection whose value is in the URL. The first option is the default, which the URL omits.
export function Choice({ parameter, ...rest }: Pick<SelectProps, 'label' | 'options'> & { parameter: string }) {
  const usual = rest.options[0]?.[0] ?? '';
  const choose = (value: string) => setQuery({ ...PLACE, [parameter]: value === usual ? undefined : value }, { step: true });
  return <Select {...rest} value={route.value.query.get(parameter) ?? usual} onChange={choose} />;
}

const inputTime = (unixMs: number) => new Date(unixMs - 60_000 * new Date(unixMs).getTimezoneOffset()).toISOString().slice(0, 19);

/** A time in the browser's time zone. An empty field is 0. */
export function TimeInput({ label, unixMs, onChange }: { label: string; unixMs: number; onChange(unixMs: number): void }) {
  return (
    <label class="choice">
      <span>{label}</span>
      <input type="datetime-local" step="1" value={unixMs ? inputTime(unixMs) : ''} onChange={(event) => onChange(new Date(event.currentTarget.value || 0).getTime())} />
    </label>
  );
}

/** A time that the URL has in milliseconds since 1970. */
export function TimeChoice({ label, parameter }: { label: string; parameter: string }) {
  const set = (unixMs: number) => setQuery({ ...PLACE, [parameter]: unixMs ? String(unixMs) : undefined }, { step: true });
  return <TimeInput label={label} unixMs={Number(route.value.query.get(parameter) ?? 0)} onChange={set} />;
}
