import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import type { PlacedRow } from './log';
import { collectPage, findRow, PAGE_ROWS } from './page';
import { AuditKind, AuditRowSchema } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';

async function* log(count: number): AsyncGenerator<PlacedRow> {
  for (let i = 1; i <= count; ++i) {
    yield { row: create(AuditRowSchema, { session: 'id', segment: 1, row: BigInt(i), kind: i % 10 === 0 ? AuditKind.SWITCH : AuditKind.TICK,
      decision: { activeArm: i % 2 ? 'SAP' : 'DBVT', candidate: 'Grid', outcome: DecisionOutcome.KEPT } }) };
  }
}
const ALL = { kind: '', outcome: '', arm: '' };
const numbers = (rows: readonly PlacedRow[]) => rows.map(({ row }) => Number(row.row));

describe('pages of a log', () => {
  it('have the newest rows first, each row once', async () => {
    const pages = await Promise.all([0, 1, 2, 3].map((page) => collectPage(log(250), ALL, page)));
    expect(pages.flatMap(({ rows }) => numbers(rows))).toEqual(Array.from({ length: 250 }, (_, i) => 250 - i));
    expect(pages.map(({ rows }) => rows.length)).toEqual([PAGE_ROWS, PAGE_ROWS, 50, 0]);
    expect(pages[3]).toMatchObject({ matchCount: 250, rowCount: 250 });
  });

  it('far back are there too, however long the log is', async () => {
    const { rows } = await collectPage(log(5000), ALL, 7);
    expect(numbers(rows)).toEqual(Array.from({ length: PAGE_ROWS }, (_, i) => 4300 - i));
  });

  it('are of the rows that match', async () => {
    const { rows, matchCount } = await collectPage(log(1000), { ...ALL, kind: 'SWITCH' }, 0);
    expect(matchCount).toBe(100);
    expect(numbers(rows).slice(0, 3)).toEqual([1000, 990, 980]);
    expect((await collectPage(log(100), { ...ALL, arm: 'SAP' }, 0)).matchCount).toBe(50);
    expect((await collectPage(log(100), { ...ALL, arm: 'Grid', outcome: 'SWITCHED' }, 0)).matchCount).toBe(0);
  });

  it('say how far they are', async () => {
    const told: number[] = [];
    await collectPage(log(3500), ALL, 0, (count) => told.push(count));
    expect(told).toEqual([1000, 2000, 3000]);
  });

  it('lead to one row without reading on', async () => {
    let read = 0;
    async function* counted() {
      for await (const row of log(1000)) {
        ++read;
        yield row;
      }
    }
    expect((await findRow(counted(), 'id.1.7'))?.row.row).toBe(7n);
    expect(read).toBe(7);
    expect(await findRow(log(10), 'id.1.11')).toBeUndefined();
  });
});
