// CSV by RFC 4180: reads exports of the daemon, and writes files for spreadsheets.

/** Returns the cells of one record, or undefined if its quotes are invalid. Quoted cells may contain commas, quotes and line breaks. */
export function parseRecord(record: string): string[] | undefined {
  const cells: string[] = [];
  let at = 0;
  for (;;) {
    let cell = '';
    if (record[at] === '"') {
      for (++at; ; at += 2) {
        const quote = record.indexOf('"', at);
        if (quote < 0) return undefined;
        cell += record.slice(at, quote);
        at = quote;
        if (record[at + 1] !== '"') break;
        cell += '"';
      }
      ++at;
      if (at < record.length && record[at] !== ',') return undefined;
    } else {
      const end = record.indexOf(',', at);
      cell = record.slice(at, end < 0 ? record.length : end);
      if (cell.includes('"')) return undefined;
      at += cell.length;
    }
    cells.push(cell);
    if (at >= record.length) return cells;
    ++at;
  }
}

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
