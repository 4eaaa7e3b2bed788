import { percent, signedMs, spread } from '../../report/src/format';

it('shows no deviation if there is one value only', () => {
  expect(spread(12.25, 2, 1, 1)).toBe('12.3');
  expect(spread(12.2, 2.81, 5, 1)).toBe('12.2±2.8');
});

it('shows the rounding error of a difference as 0', () => {
  expect(signedMs(-2.78e-17)).toBe('0');
  expect([-0.25, 0.25].map(signedMs)).toEqual(['−0.250', '+0.250']);
});

it('gives ratios a sign unless they round to zero', () => {
  expect([0.0123, -0.0123, 0.5, 12, 0.00001, -0.00001].map(percent)).toEqual(['+1.23 %', '−1.23 %', '+50.0 %', '+1,200 %', '0 %', '0 %']);
});
