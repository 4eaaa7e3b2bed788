// Tables 3 and 4 as the paper prints them: mean and sample standard deviation over five runs.
import type { PaperCell } from './experiment';

type Figure = [number, number];

function paperCell(scene: string, objects: number, dominance: string, interpretation: string, dominant: string, dominant_runs: number,
  switches: Figure, active: Figure, mu: Figure, n: Figure): PaperCell {
  return {
    scene, objects, dominance, interpretation, dominant, dominant_runs, runs: 5, switches: switches[0], switches_sd: switches[1],
    active_percent: active[0], active_percent_sd: active[1], mu: mu[0], mu_sd: mu[1], n: n[0], n_sd: n[1],
  };
}

export const PAPER_CELLS: PaperCell[] = [
  paperCell('brownian', 1000, 'AxisSweep 5/5', 'Stable sweep-based preference.', 'AxisSweep', 5,
    [20.2, 0.8], [45.5, 6.3], [0.977, 0.007], [196.4, 27.5]),
  paperCell('brownian', 2000, 'AxisSweep 5/5', 'Stable sweep-based preference.', 'AxisSweep', 5,
    [12.2, 2.8], [67.8, 7], [0.967, 0.004], [295.8, 32.3]),
  paperCell('brownian', 3000, 'KDTree 3/5; AxisSweep 2/5', 'Transitional workload between sweeping and hierarchy.', 'KDTree', 3,
    [16, 2.1], [52.9, 6.9], [0.9, 0.023], [203, 35.5]),
  paperCell('rotating-gravity', 1000, 'SAP 3/5; AxisSweep 2/5', 'Ambiguous low-density cyclic workload.', 'SAP', 3,
    [20, 1.2], [42.3, 2.9], [0.905, 0.006], [179, 13]),
  paperCell('rotating-gravity', 2000, 'AxisSweep 5/5', 'Stable sweep-based preference under cyclic motion.', 'AxisSweep', 5,
    [9.8, 1.5], [60.4, 8.8], [0.807, 0.113], [164.4, 35.3]),
  paperCell('rotating-gravity', 3000, 'KDTree 5/5', 'Stable hierarchical preference under dense cyclic clustering.', 'KDTree', 5,
    [11.2, 1.5], [44.7, 9.2], [0.244, 0.008], [63.6, 16.3]),
  paperCell('hurricane', 1000, 'AxisSweep 5/5', 'Stable sweep-based preference.', 'AxisSweep', 5,
    [21, 0], [41.2, 2.2], [0.97, 0.006], [176.2, 9]),
  paperCell('hurricane', 2000, 'AxisSweep 5/5', 'Strong stable sweep-based preference.', 'AxisSweep', 5,
    [6.6, 1.7], [82.5, 3.9], [0.954, 0.004], [355.8, 21.3]),
  paperCell('hurricane', 3000, 'KDTree 5/5', 'Stable hierarchical preference at high density.', 'KDTree', 5,
    [8.8, 1.8], [72, 6.1], [0.831, 0.025], [245, 40.7]),
];
