import { describe, expect, it } from 'vitest';
import { csvOf, parseRecord } from './csv';

describe('reading CSV', () => {
  it.each([
    ['a,b,,c', ['a', 'b', '', 'c']],
    ['', ['']],
    ['a,', ['a', '']],
    ['"a,b","say ""hi""",x', ['a,b', 'say "hi"', 'x']],
    ['"two\r\nlines",1', ['two\r\nlines', '1']],
    ['"",""', ['', '']],
  ])('splits %j', (record, cells) => expect(parseRecord(record)).toEqual(cells));

  it.each(['"open', 'a"b', '"a"b,c', '"a""'])('refuses %j', (record) => expect(parseRecord(record)).toBeUndefined());
});

describe('writing CSV', () => {
  it('can be read again', () => {
    const cells = ['plain', 'a,b', 'say "hi"', 'two\nlines', ''];
    const line = csvOf(['h'], [cells]).split('\r\n').slice(1).join('\r\n').replace(/\r\n$/, '');
    expect(parseRecord(line)).toEqual(cells);
  });

  it('quotes names that a spreadsheet would read as formulas, and no numbers', () => {
    expect(csvOf(['x'], [['=1+1', '@cmd', '+1', '-1', '\tx', '＝1', -1, 2n, null]])).toBe("x\r\n'=1+1,'@cmd,'+1,'-1,'\tx,'＝1,-1,2,\r\n");
  });
});
