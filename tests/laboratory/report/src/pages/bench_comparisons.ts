// Tables of comparisons: our best arm with the best peer, arms with the peers of their family, and figures with their goals.
import { bold, details, h, list, small, verdict, type Child } from '../dom';
import { grouped } from '../../../../../server/dashboard/src/format';
import { milliseconds, times } from '../format';
import { contestantTitle, familyLines, goalLines, isPublished, overallAt, sceneTitle, type BenchIndex, type Cell as At, type Ratio } from '../model/bench';
import { cell, columns, drawTable, noValue, text, textCell, type Cell } from '../table';
import { boundOf, cellHead, goalClass, goalVerdict, separateScenes } from './bench_tables';
import { GOAL_WORDS } from './bench_words';

const isIn = (at: At) => ({ scene, objects }: At) => scene === at.scene && objects === at.objects;

// Shows how many times faster the arm is, whether that meets the goal, and which peer it is compared with.
function comparison(index: BenchIndex, ratio: Ratio): Child[] {
  const row = ratio.threads === 1 ? index.find(ratio, ratio.other, 1, null) : undefined;
  let other = ratio.other;
  if (isPublished(ratio)) other += `, through ${ratio.derived_through}`;
  else if (row) other += row.note ? `, over its ${grouped(row.frames)} frames` : `, ${milliseconds(row.ms_median)} ms`;
  return [bold(times(ratio.value)), goalVerdict(ratio), small(other)];
}

// Returns a table cell with comparisons of one kind. The hardest one is first and gives the cell its value and colour.
function comparisons(index: BenchIndex, ratios: Ratio[]): Cell {
  const [hardest] = ratios;
  return hardest ? cell(ratios.flatMap((ratio) => comparison(index, ratio)), hardest.value, goalClass(hardest)) : noValue();
}

function overallRow(index: BenchIndex, at: At, threads: number, simd: string | null): Cell[] | undefined {
  const [measured, published] = [false, true].map((each) => overallAt(index, at, threads, simd, each)) as [Ratio[], Ratio[]];
  const any = measured[0] ?? published[0];
  if (!any) return undefined;
  const ours = index.find(at, any.ours, threads, simd);
  const mean = measured[0]?.value_mean;
  return [cell(grouped(at.objects), at.objects),
    textCell([contestantTitle(any.ours, threads, simd), ours && small(`${milliseconds(ours.ms_median)} ms`)]),
    comparisons(index, measured), mean ? cell(times(mean), mean) : noValue(), comparisons(index, published)];
}

export function overallTable(index: BenchIndex): HTMLElement {
  const groups = index.scenes.map(({ name, cells }) => ({
    title: sceneTitle(index, name),
    rows: cells.flatMap((at) => index.sets.flatMap((simd) => index.threadCounts.map((threads) => overallRow(index, at, threads, simd))))
      .filter((row) => row !== undefined),
  })).filter(({ rows }) => rows.length > 0);
  return drawTable({ id: 'overall', groups, caption: 'How many times faster Sweepstake’s fastest backend is than the fastest peer, by the median frame.',
    head: [columns('Objects', text('Best of ours'), 'Than the best peer that ran', 'By the mean frame', 'Than published peers')] });
}

function missedList(index: BenchIndex, missed: Ratio[]): Child {
  if (missed.length === 0) return h('span', { class: 'none' }, 'none');
  return details('Show which', list(missed.map((ratio) => {
    const { ours, threads, simd, scene, objects, value, other } = ratio;
    return `${contestantTitle(ours, threads, simd)} in ${sceneTitle(index, scene)}, ${grouped(objects)} objects: ${times(value)}` +
      `${other ? ` (${other})` : ''}, goal ${boundOf(ratio)}`;
  })));
}

export function goalTable(index: BenchIndex): HTMLElement | undefined {
  const rows = goalLines(index).map(({ kind, met, all, missed }) => {
    const [title, meaning] = GOAL_WORDS[kind];
    return [cell([title, small(meaning)], title), cell(verdict(met === all, `${met} of ${all} met`), met / all, met === all ? 'met' : 'missed'),
      textCell(missedList(index, missed), 'text wrap')];
  });
  if (rows.length === 0) return undefined;
  return drawTable({ id: 'goals', caption: 'The goals that this run can judge.', head: [columns('Goal', 'Met', text('Missed'))], groups: [{ rows }] });
}

export function familyTable(index: BenchIndex): HTMLElement | undefined {
  const ratios = index.ratios.filter(({ kind }) => kind === 'family');
  if (ratios.length === 0) return undefined;
  const groups = new Map<string, Cell[][]>();
  for (const { ours, threads, simd, published } of familyLines(ratios)) {
    const title = contestantTitle(ours, threads, simd);
    const found = (at: At) => ratios.find((ratio) => isIn(at)(ratio) && ratio.ours === ours && ratio.threads === threads && ratio.simd === simd &&
      (isPublished(ratio) ? ratio.other : '') === published);
    const row = [cell(published ? [published, small('did not run; derived from published ratios')] : 'best peer that ran'),
      ...index.cells.map((at) => {
        const ratio = found(at);
        return ratio ? cell([times(ratio.value), goalVerdict(ratio), !published && small(ratio.other)], ratio.value, goalClass(ratio)) : noValue();
      })];
    groups.set(title, [...(groups.get(title) ?? []), separateScenes(index, row)]);
  }
  return drawTable({ id: 'families', caption: 'How many times faster each of our backends is than peers of its family, by the median frame.',
    head: cellHead(index, 'Backend, and compared with'), groups: [...groups].map(([title, rows]) => ({ title, rows })) });
}
