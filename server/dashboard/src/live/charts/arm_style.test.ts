import { describe, expect, it } from 'vitest';
import { colourOf, FAMILIES } from '../../palette';
import { shapeOf } from '../parts/arm';
import { armStyle } from './arm_style';

const others = Array.from({ length: 20 }, (_, i) => `Mine ${i}`); // backends of a game's own
const arms = [...others.slice(0, 3), ...FAMILIES, ...others.slice(3)];
const styles = arms.map((arm) => armStyle(arm, arms));
const differ = (all: readonly string[]) => expect(all.filter((each, i) => all.indexOf(each) !== i)).toEqual([]);

describe('arms are told apart', () => {
  it('as lines: no two of one colour have the same dash', () => differ(styles.map(({ colour, dash }) => `${colour} ${dash.join(' ')}`)));
  it('without colour, those that the page knows by their dash, their hatch and their shape', () => {
    const known = FAMILIES.map((arm) => armStyle(arm, arms));
    differ(known.map(({ colour }) => colour));
    differ(known.map(({ dash }) => dash.join(' ')));
    differ(known.map(({ hatch }) => String(hatch)));
    differ(FAMILIES.map(shapeOf));
  });
  it('from what the page knows, where it does not know them', () => {
    const own = new Set(FAMILIES.flatMap((arm) => [colourOf(arm), shapeOf(arm)]));
    for (const arm of others) expect([colourOf(arm), shapeOf(arm)].filter((each) => own.has(each))).toEqual([]);
  });
});

it('An arm that the page knows looks the same whatever arms are beside it', () => expect(armStyle('SAP', ['SAP'])).toEqual(armStyle('SAP', arms)));
