// All that an experiment found, as plain values: its outputs are made from this and nothing else.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/bench/bench_report.h"
#include "engine_client/cli/experiment/experiment_folder.h"
#include "engine_client/cli/experiment/experiment_summary.h"
#include "engine_client/cli/experiment/experiment_truth.h"

namespace sweepstake::cli {

struct ExperimentReport {
  ExperimentPlan plan;
  std::vector<ExperimentSitting> sittings;  // the last one wrote this
  BenchMachine machine;
  std::vector<RunRecord> records;            // the finished runs
  std::vector<CellSummary> cells;            // by policy, then cell; point into `records`
  std::vector<CellTruth> truths;             // of the cells that were traced
  std::vector<PairedComparison> over_cells;  // by replay
  std::vector<PairedComparison> over_live;

  bool complete() const { return records.size() == plan.runs.size(); }
  // Null where it was not traced.
  const CellTruth* TruthOf(const ExperimentCell& cell) const {
    for (const CellTruth& truth : truths) {
      if (truth.cell == cell) return &truth;
    }
    return nullptr;
  }
};

}  // namespace sweepstake::cli
