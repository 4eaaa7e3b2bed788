import { expect, it } from 'vitest';
import { choiceOf, shownColumns } from './column_choice';

const ALL = [{ id: 'scene', title: '' }, { id: 'best', title: '' }, { id: 'loss', title: '', isDetail: true }, { id: 'age', title: '', isDetail: true }];
const shown = (chosen: string, sorted = 'scene') => shownColumns(ALL, chosen, sorted).map(({ id }) => id).join();

it('A table shows its usual columns, all columns or the chosen ones', () => {
  expect([shown(''), shown('all'), shown('age'), shown('scene,loss')]).toEqual(['scene,best', 'scene,best,loss,age', 'scene,age', 'scene,loss']);
  expect(shown('unknown,best'), 'unknown columns are ignored').toBe('scene,best');
});

it('A table shows the column that it is sorted by', () => expect([shown('', 'age'), shown('best', 'loss')]).toEqual(['scene,best,age', 'scene,best,loss']));

it('A choice is as short as possible, and shows the same columns', () => {
  expect(['', 'all', 'loss', 'scene,age'].map((chosen) => choiceOf(ALL, shownColumns(ALL, chosen, 'scene')))).toEqual(['', 'all', 'scene,loss', 'scene,age']);
  expect(shown(choiceOf(ALL, [])), 'without any other column').toBe('scene,best');
});
