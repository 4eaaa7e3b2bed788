// A small curve in a line of text. A number beside it shows the latest value.
const WIDTH = 96;
const HEIGHT = 22;

export interface SparklineProps {
  values: readonly number[];
  low?: number;  // lower end of the axis; absent: the lowest value
  high?: number;
  mark?: number;  // a value at which a horizontal line is drawn
}

export function Sparkline({ values, low, high, mark }: SparklineProps) {
  const least = low ?? Math.min(...values);
  const most = high ?? Math.max(...values);
  const range = most > least ? most - least : 1;
  const x = (i: number) => (values.length < 2 ? WIDTH - 2 : 2 + (i * (WIDTH - 4)) / (values.length - 1));
  const y = (value: number) => HEIGHT - 2 - ((Math.min(Math.max(value, least), most) - least) * (HEIGHT - 4)) / range;
  const points = values.map((value, i) => `${x(i).toFixed(1)},${y(value).toFixed(1)}`);
  return (
    <svg class="sparkline" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} width={WIDTH} height={HEIGHT} aria-hidden="true">
      {mark !== undefined && <line class="mark" x1="0" x2={WIDTH} y1={y(mark)} y2={y(mark)} />}
      {points.length > 1 && <polyline points={points.join(' ')} />}
      {points.length > 0 && <circle cx={x(values.length - 1)} cy={y(values.at(-1)!)} r="2" />}
    </svg>
  );
}
