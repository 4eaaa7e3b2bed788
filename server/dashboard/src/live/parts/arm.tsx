// An algorithm's symbol, colour and name, the same everywhere.
import { colourOf, symbolOf } from '../../palette';
import { Name } from './name';

// In a box from −6 to 6.
const SHAPES: Readonly<Record<string, string>> = {
  circle: 'M5 0A5 5 0 1 1 -5 0A5 5 0 1 1 5 0Z',
  square: 'M-4.4-4.4H4.4V4.4H-4.4Z',
  triangle: 'M0-5.4L5 4H-5Z',
  diamond: 'M0-5.8L4.6 0L0 5.8L-4.6 0Z',
  hexagon: 'M-2.8-4.8H2.8L5.6 0L2.8 4.8H-2.8L-5.6 0Z',
  star: 'M0-6L1.6-2L5.8-1.8L2.5 .8L3.7 5L0 2.6L-3.7 5L-2.5 .8L-5.8-1.8L-1.6-2Z',
  cross: 'M-2-5.4H2V-2H5.4V2H2V5.4H-2V2H-5.4V-2H-2Z',
  wye: 'M-1.6 0L-5.2-2.6L-3.6-5L0-2.4L3.6-5L5.2-2.6L1.6 0V5.6H-1.6Z',
};

export const shapeOf = (arm: string) => SHAPES[symbolOf(arm)] ?? SHAPES.wye!;

// Hollow: not the live one.
export function ArmMark({ arm, hollow = false }: { arm: string; hollow?: boolean }) {
  const colour = colourOf(arm);
  return (
    <svg class="symbol" viewBox="-7 -7 14 14" width="14" height="14" aria-hidden="true">
      <path d={shapeOf(arm)} fill={hollow ? 'none' : colour} stroke={colour} stroke-width="1.5" />
    </svg>
  );
}

export function Arm({ name, hollow = false }: { name: string; hollow?: boolean }) {
  return <span class="arm"><ArmMark arm={name} hollow={hollow} /> <Name text={name} unknown="none" /></span>;
}
