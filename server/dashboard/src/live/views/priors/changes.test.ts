import { create } from '../../transport/messages';
import { expect, it } from 'vitest';
import { SceneComparisonSchema } from '../../../gen/sweepstake/v1/priors_pb';
import { byWeight } from './changes';

const scene = (name: string, leaderChanged: boolean, largestLogChange: number, knownInBoth = true) =>
  create(SceneComparisonSchema, { scene: name, leaderChanged, knownInBoth, largestLogChange });

it('orders scenes by another cheapest arm, then by the largest change, and those of one build last', () => {
  const scenes = [scene('a', false, 0.1), scene('e', false, 9, false), scene('b', false, 0.7), scene('c', true, 0), scene('d', false, 0.1)];
  expect(scenes.sort(byWeight).map((each) => each.scene)).toEqual(['c', 'b', 'a', 'd', 'e']);
});
