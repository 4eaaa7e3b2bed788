// Saves files through the browser's download.
export function save(name: string, blob: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const download = (name: string, text: string, type: string) => save(name, new Blob([text], { type: `${type};charset=utf-8` }));

/** A cell to write; null and undefined give an empty cell. */
export type CsvValue = string | number | bigint | boolean | null | undefined;

// A spreadsheet reads text as a formula if its first character is one of these. A leading apostrophe prevents that.
const FORMULA = /^[=+\-@\t\r＝＋－＠]/;

function writtenCell(value: CsvValue): string {
  if (value === null || value === undefined) return '';
  const text = typeof value === 'string' && FORMULA.test(value) ? `'${value}` : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** Returns a file with a header and its rows. Text cells cannot become formulas. */
export const csvOf = (header: readonly string[], rows: Iterable<readonly CsvValue[]>): string =>
  [header, ...rows].map((row) => row.map(writtenCell).join(',') + '\r\n').join('');
