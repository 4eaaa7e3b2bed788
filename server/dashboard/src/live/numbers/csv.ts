// Writes CSV by RFC 4180 for spreadsheets.

/** A cell to write; null and undefined give an empty cell. */
export type CsvValue = string | number | bigint | boolean | null | undefined;

// A spreadsheet reads text with such a first character as a formula. A leading apostrophe prevents that.
const FORMULA = /^[=+\-@\t\r＝＋－＠]/;

function writtenCell(value: CsvValue): string {
  if (value === null || value === undefined) return '';
  const text = typeof value === 'string' && FORMULA.test(value) ? `'${value}` : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** Returns a file with a header and its rows. Text cells cannot become formulas. */
export const csvOf = (header: readonly string[], rows: Iterable<readonly CsvValue[]>): string =>
  [header, ...rows].map((row) => row.map(writtenCell).join(',') + '\r\n').join('');
