// The offline report: reads the documents in the page and draws one after the other.
import { append, h } from './dom';
import type { BenchDocument } from './model/bench';
import type { ExperimentDocument } from './model/experiment';
import type { ReplayDocument } from './model/replay';
import { onNarrowChange } from './charts/figure';
import { drawPage, type Page } from './page';
import { benchPage } from './pages/bench';
import { experimentPage } from './pages/experiment';
import { replayPage } from './pages/replay';

type Document = BenchDocument | ExperimentDocument | ReplayDocument;

function pageOf(data: Document): Page {
  switch (data.command) {
    case 'bench': return benchPage(data);
    case 'experiment': return experimentPage(data);
    case 'replay': return replayPage(data);
  }
  throw new Error(`this page cannot show documents of the command ${JSON.stringify((data as { command?: unknown }).command)}`);
}

// If a document cannot be drawn, its page contains the error, and the others are drawn.
function pageOrError(data: Document, i: number): Page {
  try {
    return pageOf(data);
  } catch (error) {
    return { title: 'Sweepstake report', sections: [],
      lead: [h('p', {}, `Document ${i + 1} cannot be drawn: ${(error as Error).message}.`)] };
  }
}

function readDocuments(): Document[] {
  const text = document.getElementById('documents')?.textContent ?? '';
  if (!text.startsWith('[')) throw new Error('it contains no documents; create a page that does with `sweepstake-lab report FILE.json --out FILE.html`');
  return JSON.parse(text) as Document[];
}

function draw(): void {
  const main = document.getElementById('report')!;
  try {
    const pages = readDocuments().map(pageOrError);
    document.title = [...new Set(pages.map(({ title }) => title))].join(', ');
    main.replaceChildren();
    append(main, pages.map((page, i) => drawPage(page, i === 0 ? '' : `d${i + 1}-`)));
  } catch (error) {
    main.replaceChildren(h('h1', {}, 'Sweepstake report'), h('p', {}, `This page cannot be drawn: ${(error as Error).message}.`));
  }
}

draw();
onNarrowChange(draw);
