import { describe, expect, it } from 'vitest';
import { bytes, compact, grouped, share, signedShare, significant } from './format';

describe('numbers', () => {
  it('show significant digits without an exponent', () => {
    expect([0.034567, 12.345, 9.996, 99.96, 1234, 0, 0.00001].map((value) => significant(value)))
      .toEqual(['0.0346', '12.3', '10.0', '100', '1,230', '0', '0.0000100']);
    expect([1e-9, -1.234e-12, 1e-150, 5e-324].map((value) => significant(value))).toEqual(['0.00000000100', '-1.23e-12', '1.00e-150', '4.94e-324']);
    expect(significant(NaN)).toBe('–');
    expect(significant(null)).toBe('–');
  });

  it('are grouped by thousands', () => {
    expect([0, 999, 1000, 12345678].map(grouped)).toEqual(['0', '999', '1,000', '12,345,678']);
  });

  it('use larger units', () => {
    expect([800, 1000, 2500, 999_999, 1e6, 1.7].map(compact)).toEqual(['800', '1K', '2.5K', '1M', '1M', '1.7']);
    expect([512, 11_240, 3_400_000].map(bytes)).toEqual(['512 B', '11.2 kB', '3.40 MB']);
  });

  it('of ratios are percentages, with a sign if they are negative and do not round to zero', () => {
    expect([0.0123, -0.0123, 0.00001, -0.00001].map(signedShare)).toEqual(['1.23 %', '−1.23 %', '0 %', '0 %']);
    expect([0.99996, 0.0002, 0.00001, 0].map(share)).toEqual(['100 %', '0.02 %', '0 %', '0 %']);
  });
});
