// Formats numbers for display, in one language for all users.
const NONE = '–';
const SMALLEST = 1e-9; // smaller numbers are written with an exponent

const isNumber = (value: number | null | undefined): value is number => typeof value === 'number' && Number.isFinite(value);

const LANGUAGE = 'en';
const memoOf = (make: (digits: number) => Intl.NumberFormatOptions) => {
  const known: Intl.NumberFormat[] = []; // making a format is much slower than using it
  return (digits: number) => (known[digits] ??= new Intl.NumberFormat(LANGUAGE, make(digits)));
};
const withDigits = memoOf((digits) => ({ minimumSignificantDigits: digits, maximumSignificantDigits: digits }));
const withDecimals = memoOf((digits) => ({ minimumFractionDigits: digits, maximumFractionDigits: digits }));

export function significant(value: number | null | undefined, digits = 3): string {
  if (!isNumber(value)) return NONE;
  if (value === 0) return '0';
  return Math.abs(value) < SMALLEST ? value.toExponential(digits - 1) : withDigits(digits).format(value);
}

export const grouped = (value: number) => (isNumber(value) ? withDecimals(0).format(value) : NONE);

const short = new Intl.NumberFormat(LANGUAGE, { notation: 'compact', maximumSignificantDigits: 3 });
export const compact = (value: number) => (isNumber(value) ? short.format(value) : NONE);

const BYTES = ['B', 'kB', 'MB', 'GB', 'TB'];

export function bytes(value: number): string {
  if (!isNumber(value)) return NONE;
  let step = 0;
  for (; step < BYTES.length - 1 && Math.abs(value) >= 999.5; ++step) value /= 1000;
  return `${step === 0 ? grouped(value) : significant(value)} ${BYTES[step]}`;
}

// Returns a ratio as a percentage: with two decimals below 10 %, one below 100 %, none above; "0 %" if it rounds to zero.
// REQUIRES: ratio >= 0.
export function share(ratio: number): string {
  if (!isNumber(ratio)) return NONE;
  const size = 100 * ratio;
  if (size < 0.005) return '0 %';
  return `${withDecimals(size < 9.995 ? 2 : size < 99.95 ? 1 : 0).format(size)} %`;
}

// Returns a ratio as a percentage, with − if it is negative, unless it rounds to zero.
export function signedShare(ratio: number): string {
  const size = share(Math.abs(ratio));
  return ratio < 0 && size !== '0 %' ? `−${size}` : size;
}

export const counted = (count: number, one: string, many: string) => `${grouped(count)} ${count === 1 ? one : many}`;

export function mean(values: readonly number[]): number {
  return values.reduce((sum, value) => sum + value, 0) / values.length;
}
