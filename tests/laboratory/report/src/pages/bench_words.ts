// Texts of the page of a bench.
import { details, h, headline, list, paragraph, verdict, type Child } from '../dom';
import { compact, grouped, significant } from '../../../../../server/dashboard/src/format';
import { times } from '../format';
import { contestantTitle, overallSpan, sceneTitle, type BenchIndex, type BenchRow, type RatioKind } from '../model/bench';

export const GOAL_WORDS: Record<RatioKind, [string, string]> = {
  overall: ['Best against best', 'how many times faster our fastest backend is than the fastest peer'],
  family: ['Family against family', 'how many times faster each backend is than the best peer of the same family'],
  simd: ['Instruction sets', 'time of a frame with an instruction set ÷ its time with the next better one'],
  growth: ['Growth', 'time per object at the largest count ÷ that at 10,000 objects'],
  threads: ['Threads', 'how many times faster several threads are than one'],
  spike: ['Steady frames', 'time that 99 % of the frames do not exceed (p99) ÷ the median'],
  memory: ['Memory', 'bytes in use, including the pairs, ÷ the bytes of the goal'],
};

export function lead({ document: { machine } }: BenchIndex): Child[] {
  return [
    paragraph('A broad phase finds, in every frame of a game, all pairs of boxes that overlap. This page compares how long several broad phases ' +
      'took for the same frames on one machine.'),
    h('p', { class: 'soft small' }, `Measured ${machine.date} on ${machine.cpu} with Sweepstake ${machine.program}.`)];
}

export function resultHeadline(index: BenchIndex): Child[] {
  const measured = overallSpan(index, false);
  const published = overallSpan(index, true);
  const text = ({ low, high, count }: { low: number; high: number; count: number }) =>
    (count === 1 ? times(low) : `${significant(low)}–${times(high)}`);
  if (!measured) {
    return [paragraph(index.document.peers
      ? 'No peer could be compared in this run, so this page compares Sweepstake’s own backends only. The list below says which peers were left out, and why.'
      : ['No peers took part in this run, so this page compares Sweepstake’s own backends only. The option ', h('code', {}, '--peers'),
        ' also times the broad phases of other libraries on the same frames.'])];
  }
  return [
    headline(text(measured), 'the speed of the fastest peer. This compares the best of Sweepstake’s backends in each scene' +
      `${index.sets[0] ? `, with ${index.sets[0]},` : ''} against the best of all other libraries (peers) that ran on the same frames.`),
    published && h('p', { class: 'soft' }, `${text(published)} the speed of the best library that did not run here. This is derived from ` +
      'published ratios of its times to those of a library that did run.')];
}

// Returns warnings about the figures: wrong pairs, and contestants that were not run.
export function warnings(index: BenchIndex): Child[] {
  const where = (row: BenchRow, what: string) =>
    `${contestantTitle(row.arm, row.threads, row.simd)} in ${sceneTitle(index, row.scene)}, ${grouped(row.objects)} objects: ${what}`;
  const { rows, document: { machine } } = index;
  const wrong = rows.filter((row) => row.difference).map((row) => where(row, row.difference!));
  const leftOut = rows.filter((row) => row.note).map((row) => where(row, row.note!)).concat(machine.absent_peers ?? []);
  return [
    wrong.length > 0 && [paragraph(verdict(false, 'Not all pairs were right. The times of these contestants cannot be compared:')), list(wrong)],
    leftOut.length > 0 && details('Left out or cut short', list(leftOut))];
}

export function method({ document, sets }: BenchIndex): HTMLElement {
  const { warmup, frames = 0, seed, threads = [1], cold, peers, peer_cap_s = 0 } = document;
  return list([
    'All contestants processed the same boxes in the same run. They took turns after blocks of up to 20 frames, and each round began with another ' +
    `contestant. So a short disturbance of the machine affected all of them equally${cold ? '' : ', and each ran with warm caches, as it would alone'}.`,
    cold && 'Before each frame the caches were evicted, as the other work of a game’s frame would do.',
    `Each contestant ran ${grouped(warmup)} frames to warm up, then ${grouped(frames)} measured ones. The seed is ${seed}: another run with it creates the same boxes.`,
    'The time of a frame includes the update of all boxes and the search for all overlapping pairs. It does not include the time to create the boxes.',
    `Threads: ${threads.map(grouped).join(', ')}. A contestant whose name gives no number ran with one.`,
    sets.length > 1 && `Instruction sets: ${sets.join(', ')}. Each of our backends ran with each of them, as a separate contestant.`,
    peers && 'Peers are other libraries from Debian’s packages, called in the fastest way that their interfaces offer. Their pairs were ' +
    `compared with ours. In a cell (a scene with an object count) a peer was stopped or left out if it took more than ${compact(peer_cap_s)} s.`]);
}
