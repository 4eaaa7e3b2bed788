import { spread } from '../../report/src/format';

it('shows no deviation if there is one value only', () => {
  expect(spread(12.25, 2, 1, 1)).toBe('12.3');
  expect(spread(12.2, 2.81, 5, 1)).toBe('12.2±2.8');
});
