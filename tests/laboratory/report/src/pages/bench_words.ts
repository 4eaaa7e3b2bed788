// Texts of the page of a bench.
import { details, h, headline, list, paragraph, verdict, type Child } from '../dom';
import { compact, grouped, significant, times } from '../../../../../server/dashboard/src/format';
import { contestantTitle, overallSpan, sceneTitle, type BenchIndex, type BenchRow, type RatioKind } from '../model/bench';

export const GOAL_WORDS: Record<RatioKind, [string, string]> = {
  overall: ['Best against best', 'our fastest backend is so many times faster than the fastest peer'],
  family: ['Family against family', 'each backend is so many times faster than the best peer that works alike'],
  simd: ['Instruction sets', 'with a lesser instruction set a frame takes so many times what it takes with the next better one'],
  growth: ['Growth', 'time per object grows by no more than this from 10,000 objects to the largest count'],
  threads: ['Threads', 'several threads are so many times faster than one'],
  spike: ['Steady frames', 'one frame in a hundred takes no longer than so many medians'],
  memory: ['Memory', 'bytes held, pairs included, against the goal’s bytes'],
};

export function lead({ document: { machine } }: BenchIndex): Child[] {
  return [
    paragraph('A broad phase finds, in every frame of a game, all pairs of boxes that overlap. Here several of them found the ' +
      'same pairs of the same frames, one after the other on one machine; this page shows how long each took.'),
    h('p', { class: 'soft small' }, `Measured ${machine.date} on ${machine.cpu} with Sweepstake ${machine.program}.`)];
}

export function resultHeadline(index: BenchIndex): Child[] {
  const measured = overallSpan(index, false);
  const published = overallSpan(index, true);
  const text = ({ low, high, count }: { low: number; high: number; count: number }) =>
    (count === 1 ? times(low) : `${significant(low)}–${times(high)}`);
  if (!measured) {
    return [paragraph(index.document.peers
      ? 'No peer could be compared in this run, so this page compares Sweepstake’s own backends only. Below it says which were left out, and why.'
      : ['No peers took part in this run, so this page compares Sweepstake’s own backends only. With ', h('code', {}, '--peers'),
        ' the same frames go through other libraries’ broad phases too.'])];
  }
  return [
    headline(text(measured), 'the speed of the fastest peer: the best of Sweepstake’s backends in each scene' +
      `${index.sets[0] ? `, with ${index.sets[0]},` : ''} against the best of all other libraries that ran beside it on the same frames.`),
    published && h('p', { class: 'soft' }, `${text(published)} the speed of the best library that did not run here, derived ` +
      'through published ratios to one that did.')];
}

// Returns warnings about the figures: wrong pairs, and contestants that were not run.
export function warnings(index: BenchIndex): Child[] {
  const where = (row: BenchRow, what: string) =>
    `${contestantTitle(row.arm, row.threads, row.simd)} in ${sceneTitle(index, row.scene)}, ${grouped(row.objects)} objects: ${what}`;
  const { rows, document: { machine } } = index;
  const wrong = rows.filter((row) => row.difference).map((row) => where(row, row.difference!));
  const leftOut = rows.filter((row) => row.note).map((row) => where(row, row.note!)).concat(machine.absent_peers ?? []);
  return [
    wrong.length > 0 && [paragraph(verdict(false, 'Not all pairs were right. These times are not comparable:')), list(wrong)],
    leftOut.length > 0 && details('Left out or cut short', list(leftOut))];
}

export function method({ document, sets }: BenchIndex): HTMLElement {
  const { warmup, frames = 0, seed, threads = [1], cold, peers, peer_cap_s = 0 } = document;
  return list([
    'All contestants saw the same boxes in the same run. They took turns by blocks of up to 20 frames, and another one began each ' +
    `time: what disturbed the machine for a moment disturbed all alike${cold ? '' : ', yet each ran with the warm caches that it would have alone'}.`,
    cold && 'Before each frame the caches were evicted, as the rest of a game’s frame does.',
    `${grouped(warmup)} frames to warm up, then ${grouped(frames)} measured ones. Seed ${seed}: another run of the same command makes the same boxes.`,
    'A frame’s time is that of taking all boxes and finding all overlapping pairs, exactly and once each; making the boxes is not in it.',
    `Threads: ${threads.map(grouped).join(', ')}. Unless a name says so, one.`,
    sets.length > 1 && `Instruction sets: ${sets.join(', ')}. Each of our backends ran with each of them, as contestants of their own.`,
    peers && 'Peers are other libraries as Debian packages them, called the fastest way that their interfaces offer. Their pairs were ' +
    `compared with ours. A peer that took more than ${compact(peer_cap_s)} s of its own in a cell was cut short or left out there.`]);
}
