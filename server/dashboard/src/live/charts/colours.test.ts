import { describe, expect, it } from 'vitest';
import { colourOf, FAMILIES } from '../../palette';
import { shapeOf } from '../parts/arm';
import { armStyle } from './colours';

const others = Array.from({ length: 20 }, (_, i) => `Mine ${i}`); // custom backends of a game
const arms = [...others.slice(0, 3), ...FAMILIES, ...others.slice(3)];
const styles = arms.map((arm) => armStyle(arm, arms));
const differ = (all: readonly string[]) => expect(all.filter((each, i) => all.indexOf(each) !== i)).toEqual([]);

describe('the styles of arms', () => {
  it('differ as lines: no two lines of one colour have the same dash', () => differ(styles.map(({ colour, dash }) => `${colour} ${dash.join(' ')}`)));
  it('differ in dash, hatch and shape without colour, for the built-in arms', () => {
    const known = FAMILIES.map((arm) => armStyle(arm, arms));
    differ(known.map(({ colour }) => colour));
    differ(known.map(({ dash }) => dash.join(' ')));
    differ(known.map(({ hatch }) => String(hatch)));
    differ(FAMILIES.map(shapeOf));
  });
  it('of custom arms differ from those of built-in arms', () => {
    const own = new Set(FAMILIES.flatMap((arm) => [colourOf(arm), shapeOf(arm)]));
    for (const arm of others) expect([colourOf(arm), shapeOf(arm)].filter((each) => own.has(each))).toEqual([]);
  });
});

it('A built-in arm has the same style whatever other arms a chart shows', () => expect(armStyle('SAP', ['SAP'])).toEqual(armStyle('SAP', arms)));
