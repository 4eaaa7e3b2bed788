// The page of `sweepstake-lab bench`.
import { lineChart, type Series } from '../charts/line_chart';
import { byValue, rangeChart } from '../charts/range_chart';
import { grouped } from '../../../../../server/dashboard/src/format';
import { milliseconds, times } from '../format';
import { contestantTitle, indexBench, sceneTitle, type BenchDocument, type BenchIndex, type BenchRow, type Cell, type Contestant, type Scene } from '../model/bench';
import { commandLine, machineList, type Page } from '../page';
import { colourOf, symbolOf } from '../../../../../server/dashboard/src/palette';
import { details, h } from '../dom';
import { familyTable, goalTable, overallTable } from './bench_comparisons';
import { checkTable, growthTable, memoryTable, rowTable, simdTable, spikeTable, threadTable, timeTable } from './bench_tables';
import { lead, method, resultHeadline, warnings } from './bench_words';

function described(index: BenchIndex, row: BenchRow): string {
  const fastest = index.fastest(row)!.ms_median;
  const rank = row.ms_median > fastest ? `${times(row.ms_median / fastest)} the fastest` : 'the fastest';
  return `${grouped(row.objects)} objects: ${milliseconds(row.ms_median)} ms (${rank})\n` +
    `min ${milliseconds(row.ms_min)} ms · p99 ${milliseconds(row.ms_p99)} ms`;
}

function seriesOf(index: BenchIndex, scene: Scene, contestant: Contestant): Series {
  const { name, family, kind, threads, simd } = contestant;
  const rows = scene.cells.map((at) => index.rowOf(at, contestant)).filter((row) => row !== undefined);
  return {
    name: contestantTitle(name, threads, simd), colour: colourOf(family), symbol: symbolOf(family), solid: kind === 'arm',
    points: rows.filter((row) => row.ms_median > 0).map((row) => ({ x: row.objects, y: row.ms_median, text: described(index, row) })),
  };
}

function growthChart(index: BenchIndex, scene: Scene, id: string): HTMLElement {
  const series = index.contestants.map((each) => seriesOf(index, scene, each)).filter(({ points }) => points.length > 0);
  return lineChart({ id, title: sceneTitle(index, scene.name), xLabel: 'Objects',
    yLabel: 'Milliseconds per frame, median', series });
}

function rankingChart(index: BenchIndex, at: Cell, id: string): HTMLElement {
  const rows = index.contestants.flatMap((each) => {
    const row = index.rowOf(at, each);
    return row && row.ms_min > 0 ? [{ name: contestantTitle(each.name, each.threads, each.simd), colour: colourOf(each.family), symbol: symbolOf(each.family),
      solid: each.kind === 'arm', low: row.ms_min, value: row.ms_median, high: row.ms_p99,
      label: `${milliseconds(row.ms_median)} ms`, text: described(index, row) }] : [];
  });
  return rangeChart({ id, title: `${sceneTitle(index, at.scene)}, ${grouped(at.objects)} objects`, rows: byValue(rows),
    xLabel: 'Milliseconds per frame. Mark: median. Bar: from the fastest frame to the p99, which 99 % of the frames do not exceed' });
}

function timeCharts(index: BenchIndex): HTMLElement[] {
  return index.scenes.map((scene, i) => (scene.cells.length > 1
    ? growthChart(index, scene, `chart-${i + 1}`) : rankingChart(index, scene.cells[0]!, `chart-${i + 1}`)));
}

export function benchPage(document: BenchDocument): Page {
  const index = indexBench(document);
  const compared = index.ratios.some(({ kind }) => kind === 'overall');
  return {
    title: 'Sweepstake bench',
    lead: lead(index),
    sections: [
      { id: 'results', heading: 'Results', body: [resultHeadline(index), compared && overallTable(index), warnings(index)] },
      { id: 'judged', heading: 'Goals', body: [goalTable(index)] },
      { id: 'time', heading: 'Time against objects', body: [timeCharts(index), timeTable(index)] },
      { id: 'by-family', heading: 'Against the same family', body: [familyTable(index)] },
      { id: 'instruction-sets', heading: 'Instruction sets', body: index.sets.length > 1 ? [simdTable(index)] : [] },
      { id: 'per-object', heading: 'Time per object', body: [growthTable(index)] },
      { id: 'steady', heading: 'Steady frames', body: [spikeTable(index)] },
      { id: 'scaling', heading: 'Threads', body: index.threadCounts.length > 1 ? [threadTable(index)] : [] },
      { id: 'work', heading: 'AABB checks', body: [checkTable(index)] },
      { id: 'held', heading: 'Memory', body: [memoryTable(index)] },
      { id: 'machine', heading: 'Machine and versions', body: [machineList(document.machine),
        document.command_line && [h('h3', {}, 'Command line'), commandLine(document.command_line)]] },
      { id: 'method', heading: 'How it was measured', body: [method(index)] },
      { id: 'raw', heading: 'All rows', body: [details('Show all rows', rowTable(index))] },
    ],
  };
}
