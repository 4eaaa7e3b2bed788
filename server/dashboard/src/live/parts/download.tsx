// Saves files through the browser's download, and links to the tables that the daemon writes as CSV.
import { urlOf } from '../transport/calls';

export function save(name: string, blob: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const download = (name: string, text: string, type: string) => save(name, new Blob([text], { type: `${type};charset=utf-8` }));

/** A table of the daemon (server/web/csv/csv_tables.h). */
type CsvTable = 'decisions' | 'windows' | 'posteriors' | 'logs' | 'scenes' | 'sessions' | 'evidence' | 'history';

/** Returns the URL of a table as CSV. `request` is the request of the table's method, as JSON. */
export const csvUrl = (table: CsvTable, request: object = {}) => urlOf(`/csv/${table}?request=${encodeURIComponent(JSON.stringify(request))}`);

export const sessionCsvUrl = (table: 'decisions' | 'windows' | 'posteriors', sessionId: string) => csvUrl(table, { filter: { sessionId } });

/** A link that saves a table as CSV. `of` names the table for readers who do not see what is beside the link. */
export const CsvLink = ({ href, of, name = 'sweepstake' }: { href: string; of: string; name?: string }) =>
  <a class="button quiet" href={href} download={`${name}.csv`} aria-label={`${of} as CSV`} title="As a file, from the daemon">CSV</a>;
