import { describe, expect, it } from 'vitest';
import { csvOf } from '../parts/download';

describe('writing CSV', () => {
  it('quotes cells with commas, quotes and line breaks', () =>
    expect(csvOf(['h'], [['plain', 'a,b', 'say "hi"', 'two\nlines', '']])).toBe('h\r\nplain,"a,b","say ""hi""","two\nlines",\r\n'));

  it('quotes names that a spreadsheet would read as formulas, and no numbers', () => {
    expect(csvOf(['x'], [['=1+1', '@cmd', '+1', '-1', '\tx', '＝1', -1, 2n, null]])).toBe("x\r\n'=1+1,'@cmd,'+1,'-1,'\tx,'＝1,-1,2,\r\n");
  });
});
