import { activeShares, agreementCounts, chosenWell, meanRegret, noisyCells, smallestProbability, timeParts, verdictCounts, type Comparison, type ExperimentDocument, type ExperimentRow, type PaperCell, type Run, type Truth } from '../../report/src/model/experiment';
import { paperFigure } from '../../report/src/pages/experiment_cells';
import { smallestText } from '../../report/src/pages/experiment_truth';
import { sameAsPaper, trulyFastest, wordsOf } from '../../report/src/pages/experiment_words';

const player = (name: string, regret: number) => ({ name, is_policy: true, regret, ci95: [0, 0] as [number, number], after_start_up: 0, switches: 0, active_share: 1 });
const truth = (cell: string, regret: number, more: Partial<Truth> = {}): Truth => ({
  cell, scenes: 5, ranking: [{ arm: 'KDTree', mean_ns: 20, ratio: 1 }, { arm: 'SAP', mean_ns: 20.4, ratio: 1.02 }], control_ratio: 1, headroom: 0,
  players: [player('adaptive', regret)], comparisons: [], agreements: [], ...more });
const time = { scene_step_ns: 1, detection_ns: 2, rebuild_ns: 3, copying_ns: 4, around_ns: 5, frame_end_ns: 6, intake_ns: 7, decision_ns: 8, lane_ns: 9 };
const run = (active_shares: number[]) => ({ arms: ['SAP', 'KDTree'], active_shares, verdicts: { stable: 2 }, time }) as unknown as Run;
const document = { arms: ['KDTree', 'SAP'], truths: [truth('a', 0.1), truth('b', 0.3, { control_ratio: 1.05 })], rows: [
  { policy: 'paper', cell: 'a', dominant: 'KDTree' }, { policy: 'paper', cell: 'b', dominant: 'SAP' }] } as unknown as ExperimentDocument;

describe('an experiment', () => {
  it('has a mean regret over its cells', () => {
    expect(meanRegret(document, 'adaptive')).toBeCloseTo(0.2);
    expect(meanRegret(document, 'nobody')).toBeUndefined();
  });

  it('counts the cells where the choice was truly good', () => {
    expect(chosenWell(document, 'paper')).toEqual({ all: 2, fastest: 1, tied: 1 });
  });

  it('knows where the machine was disturbed', () => {
    expect(noisyCells(document)).toEqual(['b']);
    const agreement = { regret: 0.1, measured_regret: 0.3, regret_agrees: true, share_agrees: false };
    const disturbed = { truths: [truth('a', 0, { agreements: [agreement] as never })] } as unknown as ExperimentDocument;
    expect(agreementCounts(disturbed)).toEqual({ all: 1, regret: 1, share: 0, disturbed: 1 });
  });

  it('knows how small p can be, whatever the policies are', () => {
    const family = [{ pairs: 5, p_smallest: 2 / 32 }, { pairs: 4, p_smallest: 2 / 16 }, { pairs: 5, p_smallest: 2 / 32 }] as Comparison[];
    expect(smallestProbability(family)).toEqual({ p: 2 / 32, corrected: 6 / 32, pairs: 5 });
    expect(smallestText('scenes of a cell', family)).toBe('With 5 pairs (scenes of a cell), p is at least 0.063, and at least 0.19 after Holm’s ' +
      'correction for 3 comparisons. So no corrected p can be small here: a large p does not show that two policies are equal.');
    expect(smallestText('cells', [{ pairs: 15, p_smallest: 2 ** -14 } as Comparison])).not.toContain('no corrected p');
    expect(smallestProbability([])).toEqual({ p: 1, corrected: 0, pairs: 0 });
  });

  it('counts one cell as one', () => {
    const row = { policy: 'paper', cell: 'a', dominant: 'KDTree', scene: 'brownian', objects: 1000 };
    const one = { truths: [truth('a', 0.1)], rows: [row], paper: [{ ...row }], options: {} } as unknown as ExperimentDocument;
    expect(trulyFastest(one, wordsOf({ cells: [], own_policy: 'adaptive' }), 'paper')).toContain('in 1 of 1 cell.');
    expect(sameAsPaper(one)).toContain('in 1 of 1 cell that both have.');
    expect(sameAsPaper(one)).not.toContain('settling or weights');
    const decision = { decision_interval_ns: 1e9, cooldown_ns: 40e9, settling_ns: 2e9, weights: { fps: 0.55, detection: 0.25, memory: 0.12, checks: 0.08 } };
    const other = { ...one, options: { decision } } as unknown as ExperimentDocument;
    expect(sameAsPaper(other)).toContain('settling or weights of this run also differ');
  });

  it('compares posteriors with the paper only for the paper’s policy', () => {
    const paper = { switches: 20.2, switches_sd: 0.8, mu: 0.977, mu_sd: 0.007, n: 196.4, n_sd: 27.5 } as PaperCell;
    const row = (policy: string) => ({ policy }) as ExperimentRow;
    expect(paperFigure(row('paper'), paper, 'n', 1)).toBe('196.4±27.5');
    expect(paperFigure(row('default'), paper, 'n', 1)).toBe('–');
    expect(paperFigure(row('default'), paper, 'mu', 3)).toBe('–');
    expect(paperFigure(row('default'), paper, 'switches', 1)).toBe('20.2±0.8');
    expect(paperFigure(row('paper'), undefined, 'n', 1)).toBe('–');
  });

  it('sums shares by algorithm, verdicts and time by part', () => {
    expect(activeShares(document, [run([0.25, 0.75]), run([0, 1])])).toEqual([1.75, 0.25]);
    expect(verdictCounts([run([1, 0]), run([1, 0])])).toEqual([0, 4, 0, 0, 0]);
    expect(timeParts([run([1, 0])])).toEqual([1, 2, 3, 4, 5, 6, 7, 8, 9]);
  });
});
