// Tables of what was compared with what: the best against the best, families, goals.
import { bold, details, h, list, small, verdict, type Child } from '../dom';
import { compact, grouped, milliseconds, times } from '../format';
import { contestantTitle, familyLines, goalLines, isPublished, sceneTitle, type BenchIndex, type Cell as At, type Ratio } from '../model/bench';
import { cell, columns, drawTable, noValue, text, textCell, type Cell } from '../table';
import { cellHead, goalClass, goalVerdict, separateScenes } from './bench_tables';
import { GOAL_WORDS } from './bench_words';

const isIn = (at: At) => ({ scene, objects }: At) => scene === at.scene && objects === at.objects;

// How many times faster, whether that is enough, and than whom.
function comparison(index: BenchIndex, ratio: Ratio): Cell {
  const row = ratio.threads === 1 ? index.find(ratio, ratio.other, 1) : undefined;
  let other = ratio.other;
  if (isPublished(ratio)) other += `, through ${ratio.derived_through}`;
  else if (row) other += row.note ? `, over its ${grouped(row.frames)} frames` : `, ${milliseconds(row.ms_median)} ms`;
  return cell([bold(times(ratio.value)), goalVerdict(ratio), small(other)], ratio.value, goalClass(ratio));
}

function overallRow(index: BenchIndex, at: At, threads: number): Cell[] | undefined {
  const all = index.ratios.filter((ratio) => ratio.kind === 'overall' && ratio.threads === threads && isIn(at)(ratio));
  const measured = all.find((ratio) => !isPublished(ratio));
  const published = all.find(isPublished);
  const any = measured ?? published;
  if (!any) return undefined;
  const ours = index.find(at, any.ours, threads);
  return [cell(grouped(at.objects), at.objects),
    textCell([contestantTitle(any.ours, threads), ours && small(`${milliseconds(ours.ms_median)} ms`)]),
    measured ? comparison(index, measured) : noValue(),
    measured?.value_mean ? cell(times(measured.value_mean), measured.value_mean) : noValue(),
    published ? comparison(index, published) : noValue()];
}

export function overallTable(index: BenchIndex): HTMLElement {
  const groups = index.scenes.map(({ name, cells }) => ({
    title: sceneTitle(index, name),
    rows: cells.flatMap((at) => index.threadCounts.map((threads) => overallRow(index, at, threads))).filter((row) => row !== undefined),
  })).filter(({ rows }) => rows.length > 0);
  return drawTable({ id: 'overall', groups, caption: 'How many times faster the fastest of Sweepstake is than the fastest peer, by the median frame.',
    head: [columns('Objects', text('Best of ours'), 'Than the peers that ran', 'By the mean', 'Than published ones')] });
}

export function fastestTable(index: BenchIndex): HTMLElement {
  const groups = index.scenes.map(({ name, cells }) => ({
    title: sceneTitle(index, name),
    rows: cells.flatMap((at) => {
      const row = index.fastest(at);
      return row ? [[cell(grouped(at.objects), at.objects), textCell(contestantTitle(row.arm, row.threads)),
        cell(milliseconds(row.ms_median), row.ms_median), cell(grouped(row.pairs_mean), row.pairs_mean)]] : [];
    }),
  }));
  return drawTable({ id: 'fastest', groups, caption: 'The fastest of each scene and number of objects, by the median frame.',
    head: [columns('Objects', text('Fastest'), 'Milliseconds', 'Pairs per frame')] });
}

function missedList(index: BenchIndex, missed: Ratio[]): Child {
  if (missed.length === 0) return h('span', { class: 'none' }, 'none');
  return details('Show which', list(missed.map(({ ours, threads, scene, objects, value, other, goal }) =>
    `${contestantTitle(ours, threads)} in ${sceneTitle(index, scene)}, ${grouped(objects)} objects: ${times(value)}` +
    `${other ? ` (${other})` : ''}, goal ${compact(goal!)}×`)));
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
  for (const { ours, threads, published } of familyLines(ratios)) {
    const title = contestantTitle(ours, threads);
    const found = (at: At) => ratios.find((ratio) => isIn(at)(ratio) && ratio.ours === ours && ratio.threads === threads &&
      (isPublished(ratio) ? ratio.other : '') === published);
    const row = [cell(published ? [published, small('did not run: by published ratios')] : 'best peer that ran'),
      ...index.cells.map((at) => {
        const ratio = found(at);
        return ratio ? cell([times(ratio.value), goalVerdict(ratio), !published && small(ratio.other)], ratio.value, goalClass(ratio)) : noValue();
      })];
    groups.set(title, [...(groups.get(title) ?? []), separateScenes(index, row)]);
  }
  return drawTable({ id: 'families', caption: 'How many times faster each of our backends is than peers of its family, by the median frame.',
    head: cellHead(index, 'Backend, and compared with'), groups: [...groups].map(([title, rows]) => ({ title, rows })) });
}
