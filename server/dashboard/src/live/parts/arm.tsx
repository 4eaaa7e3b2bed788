// An arm's symbol, colour and name, the same in all views.
import { colourOf, symbolOf } from '../../palette';
import { Name } from './name';

// Paths relative to their first point, within a square from −6 to 6 around it.
const SHAPES: Readonly<Record<string, string>> = {
  circle: 'm5 0a5 5 0 1 1 -10 0a5 5 0 1 1 10 0z',
  square: 'm-4.4-4.4h8.8v8.8h-8.8z',
  triangle: 'm0-5.4l5 9.4h-10z',
  diamond: 'm0-5.8l4.6 5.8l-4.6 5.8l-4.6-5.8z',
  hexagon: 'm-2.8-4.8h5.6l2.8 4.8l-2.8 4.8h-5.6l-2.8-4.8z',
  star: 'm0-6l1.6 4l4.2 .2l-3.3 2.6l1.2 4.2l-3.7-2.4l-3.7 2.4l1.2-4.2l-3.3-2.6l4.2-.2z',
  cross: 'm-2-5.4h4v3.4h3.4v4h-3.4v3.4h-4v-3.4h-3.4v-4h3.4z',
  wye: 'm-1.6 0l-3.6-2.6l1.6-2.4l3.6 2.6l3.6-2.6l1.6 2.4l-3.6 2.6v5.6h-3.2z',
};

/** Returns a relative path: prefix it with `M10 20` to draw the symbol around (10, 20). */
export const shapeOf = (arm: string) => SHAPES[symbolOf(arm)] ?? SHAPES.wye!;

// `hollow` marks arms other than the active one.
export function ArmMark({ arm, hollow = false }: { arm: string; hollow?: boolean }) {
  const colour = colourOf(arm);
  return (
    <svg class="symbol" viewBox="-7 -7 14 14" width="14" height="14" aria-hidden="true">
      <path d={shapeOf(arm)} fill={hollow ? 'none' : colour} stroke={colour} stroke-width="1.5" />
    </svg>
  );
}

export const Arms = ({ names }: { names: readonly string[] }) =>
  (names.length === 0 ? <Arm name="" /> : <>{names.map((name, i) => <span key={name}>{i > 0 && ' '}<Arm name={name} /></span>)}</>);

export const Arm = ({ name, hollow = false }: { name: string; hollow?: boolean }) =>
  <span class="arm"><ArmMark arm={name} hollow={hollow} /> <Name text={name} unknown="none" /></span>;
