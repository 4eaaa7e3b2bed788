// Tables with a line per contestant and a column per cell, and a table of all rows.
import { bold, h, small, type Child } from '../dom';
import { bytes, compact, grouped, significant } from '../../../../../server/dashboard/src/format';
import { milliseconds, times } from '../format';
import { contestantTitle, hasGoal, largeIsGood, sceneTitle, type BenchIndex, type BenchRow, type Contestant, type Ratio, type RatioKind } from '../model/bench';
import { familyTitle } from '../palette';
import { cell, columns, drawTable, noValue, text, textCell, type Cell, type HeadCell } from '../table';

export function cellHead(index: BenchIndex, corner: string): HeadCell[][] {
  const scenes: HeadCell[] = [{ content: '' }];
  const counts: HeadCell[] = [{ content: corner }];
  for (const { name, cells } of index.scenes) {
    scenes.push({ content: sceneTitle(index, name), span: cells.length, className: 'first' });
    cells.forEach(({ objects }, i) => counts.push({ content: grouped(objects), className: i === 0 ? 'first' : '' }));
  }
  return [scenes, counts];
}

// Draws a line before the first cell of each scene. REQUIRES: `row` ends with a column per cell.
export function separateScenes(index: BenchIndex, row: Cell[]): Cell[] {
  let column = row.length - index.cells.length;
  for (const { cells } of index.scenes) {
    row[column] = { ...row[column]!, className: `${row[column]!.className ?? ''} first` };
    column += cells.length;
  }
  return row;
}

// Returns the limit of the ratio's goal. REQUIRES: the ratio has a goal.
export function boundOf({ kind, other, goal, goal_at_least }: Ratio): string {
  if (goal_at_least !== undefined) return `${compact(goal_at_least)}× to ${compact(goal!)}×`;
  return `${largeIsGood(kind) ? '≥' : '≤'} ${kind === 'memory' ? other : `${compact(goal!)}×`}`;
}

export function goalVerdict(ratio: Ratio): Child {
  if (!hasGoal(ratio)) return null;
  return small(h('span', { class: `verdict ${ratio.met ? 'met' : 'missed'}` }, `${ratio.met ? '✓ met' : '✗ missed'} (${boundOf(ratio)})`));
}

export const goalClass = (ratio: Ratio) => (hasGoal(ratio) ? (ratio.met ? 'met' : 'missed') : '');

function contestantName({ name, kind, threads, simd }: Contestant): Cell {
  const title = contestantTitle(name, threads, simd);
  return cell(kind === 'arm' ? bold(title) : [title, ' ', h('span', { class: 'none' }, 'peer')], name);
}

type Content = (row: BenchRow, contestant: Contestant) => Cell;

function contestantTable(index: BenchIndex, id: string, caption: string, oursOnly: boolean, content: Content): HTMLElement {
  const groups = index.families.map((family) => ({
    title: familyTitle(family),
    rows: index.contestants.filter((each) => each.family === family && (!oursOnly || each.kind === 'arm')).map((each) =>
      separateScenes(index, [contestantName(each), ...index.cells.map((at) => {
        const row = index.rowOf(at, each);
        return row ? content(row, each) : noValue();
      })])),
  })).filter(({ rows }) => rows.length > 0);
  return drawTable({ id, caption, head: cellHead(index, 'Family and contestant'), groups });
}

function ratioOf(index: BenchIndex, kind: RatioKind, row: BenchRow): Ratio | undefined {
  return row.kind !== 'arm' ? undefined : index.ratios.find((ratio) => ratio.kind === kind && ratio.scene === row.scene &&
    ratio.objects === row.objects && ratio.ours === row.arm && ratio.threads === row.threads && ratio.simd === row.simd);
}

// Returns a table cell that shows a figure and whether it meets its goal.
function judged(index: BenchIndex, kind: RatioKind, row: BenchRow, value: number, content: Child[]): Cell {
  const ratio = ratioOf(index, kind, row);
  return ratio ? cell([...content, goalVerdict(ratio)], value, goalClass(ratio)) : cell(content, value);
}

export const timeTable = (index: BenchIndex) => contestantTable(index, 'times',
  'Median of the milliseconds per frame; below it the ratio to the fastest of the column. ★ marks the fastest.', false, (row) => {
    const fastest = index.fastest(row)!.ms_median;
    const isBest = row.ms_median === fastest;
    return cell([isBest && '★ ', milliseconds(row.ms_median), small(times(row.ms_median / fastest)),
      row.difference && small(h('span', { class: 'verdict missed' }, '✗ wrong pairs'))], row.ms_median, isBest ? 'best' : '');
  });

export const growthTable = (index: BenchIndex) => contestantTable(index, 'growth',
  'Nanoseconds per object and frame. If they are equal along a row, the time grows linearly with the objects.', false, (row) => {
    const ns = (row.ms_median * 1e6) / row.objects;
    const ratio = ratioOf(index, 'growth', row);
    return judged(index, 'growth', row, ns, [significant(ns), ratio && small(`${times(ratio.value)} that at ${ratio.other}`)]);
  });

export const spikeTable = (index: BenchIndex) => contestantTable(index, 'spikes',
  'The time that 99 % of the frames do not exceed (p99) ÷ the median: 1× is a steady frame time. Below it the p99 in milliseconds.',
  false, (row) => judged(index, 'spike', row, row.ms_p99 / row.ms_median,
    [times(row.ms_p99 / row.ms_median), small(`${milliseconds(row.ms_p99)} ms`)]));

export const checkTable = (index: BenchIndex) => contestantTable(index, 'checks',
  'Comparisons of two boxes per frame; below it the comparisons per pair found. Peers do not count their comparisons.', true,
  ({ aabb_checks_mean: checks, pairs_mean: pairs }) => (checks === null ? noValue()
    : cell([compact(checks), small(`${compact(checks / pairs)} per pair`)], checks)));

export const memoryTable = (index: BenchIndex) => contestantTable(index, 'memory',
  'The largest memory of a backend in a measured frame, with the buffer of the pairs; below it the backend alone, per object.', true,
  (row) => {
    if (row.bytes === null) return noValue();
    const all = row.bytes_with_pairs ?? row.bytes;
    return judged(index, 'memory', row, all, [bytes(all), small(`${bytes(row.bytes / row.objects)} per object`)]);
  });

export function threadTable(index: BenchIndex): HTMLElement {
  const rows = index.contestants.filter(({ kind }) => kind === 'arm').flatMap((each) =>
    index.threadCounts.filter((threads) => threads !== each.threads).map((threads) =>
      separateScenes(index, [contestantName({ ...each, threads }),
        ...index.cells.map((at) => {
          const [several, fewest] = [index.find(at, each.name, threads, each.simd), index.rowOf(at, each)];
          if (!several || !fewest) return noValue();
          const faster = fewest.ms_median / several.ms_median;
          return judged(index, 'threads', several, faster, [times(faster), small(`${milliseconds(several.ms_median)} ms`)]);
        })])));
  return drawTable({ id: 'threads', head: cellHead(index, 'Backend and threads'), groups: [{ rows }],
    caption: 'How many times faster a backend is with several threads than with the fewest, by the median; below it the milliseconds per frame.' });
}

export function simdTable(index: BenchIndex): HTMLElement {
  const isCompared = ({ name, simd }: Contestant) => (threads: number) => index.ratios.some((ratio) =>
    ratio.kind === 'simd' && ratio.ours === name && ratio.simd === simd && ratio.threads === threads);
  const rows = index.contestants.filter(({ kind }) => kind === 'arm').flatMap((each) =>
    index.threadCounts.filter(isCompared(each)).map((threads) =>
      separateScenes(index, [contestantName({ ...each, threads }),
        ...index.cells.map((at) => {
          const row = index.find(at, each.name, threads, each.simd);
          const ratio = row && ratioOf(index, 'simd', row);
          return row && ratio ? judged(index, 'simd', row, ratio.value, [times(ratio.value), small(`that with ${ratio.other}`)]) : noValue();
        })])));
  return drawTable({ id: 'sets', head: cellHead(index, 'Backend and instruction set'), groups: [{ rows }],
    caption: 'How many times longer a frame takes with this instruction set than with the next better one that was measured, by the median.' });
}

function rowCells(row: BenchRow): Cell[] {
  const whole = (value: number | null) => (value === null ? noValue() : cell(grouped(value), value));
  const measured = row.frames === 0 ? Array.from({ length: 8 }, noValue)
    : [...[row.ms_median, row.ms_mean, row.ms_min, row.ms_p99].map((ms) => cell(milliseconds(ms), ms)),
      whole(row.pairs_mean), whole(row.aabb_checks_mean), whole(row.bytes), whole(row.bytes_with_pairs)];
  return [cell(contestantTitle(row.arm, 1, row.simd)), textCell(familyTitle(row.family)), cell(grouped(row.threads), row.threads), cell(grouped(row.frames), row.frames),
    ...measured, textCell([row.note, row.note && row.difference && '; ',
      row.difference && h('span', { class: 'verdict missed' }, `✗ wrong pairs: ${row.difference}`)])];
}

export function rowTable(index: BenchIndex): HTMLElement {
  const groups = index.cells.map(({ scene, objects }) => ({
    title: `${sceneTitle(index, scene)}, ${grouped(objects)} objects`,
    rows: index.rows.filter((row) => row.scene === scene && row.objects === objects).map(rowCells),
  }));
  return drawTable({ id: 'rows', caption: 'Every contestant in every scene. Times in milliseconds per frame.', groups,
    head: [columns('Contestant', text('Family'), 'Threads', 'Frames', 'Median', 'Mean', 'Min', 'p99', 'Pairs', 'AABB checks', 'Bytes', 'With pairs', text('Note'))] });
}
