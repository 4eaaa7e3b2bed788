// What an experiment found, and its outputs: text tables, CSV files and one JSON document. Pure but
// for the files; safe from any thread.
#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "engine_client/cli/bench/bench_machine.h"
#include "engine_client/cli/experiment/experiment_folder.h"
#include "engine_client/cli/experiment/experiment_summary.h"
#include "engine_client/cli/experiment/experiment_truth.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// All outputs are made from this and from nothing else.
struct ExperimentReport {
  ExperimentPlan plan;
  std::vector<ExperimentSitting> sittings;  // the last one wrote this
  BenchMachine machine;
  std::vector<RunRecord> records;  // the finished runs
  std::vector<CellSummary> cells;  // by policy, then cell; they point into `records`
  ExperimentTruths truths;

  bool complete() const { return records.size() == plan.runs.size(); }
};

// "12.2±2.8" with that many decimals; only "12.2" for a single value.
std::string SpreadText(const Spread& spread, int decimals);

// Tables 3 and 4 in the paper's layout for each policy, with the paper's own figures beside them;
// then the true ranking, regret by policy, live against replay, comparisons. Parts without data are
// left out. `folder` is where the experiment lies.
void PrintExperiment(const ExperimentReport& report, const std::filesystem::path& folder,
                     std::ostream& out);

// Writes the tables (table3.csv, table4.csv), the raw rows of the runs (activations.csv,
// switches.csv, decisions.csv, posteriors.csv, final.csv, metrics.csv, time.csv) and the truth
// (ranking.csv, regret.csv, live_regret.csv, agreement.csv, comparisons.csv) into `folder`. The
// errors of CsvFile.
Status WriteExperimentCsv(const ExperimentReport& report, const std::filesystem::path& folder);

// The document of `--json`: a row per cell and policy, then the runs and the truth that the
// report's charts are drawn from.
void PrintExperimentJson(const ExperimentReport& report, const std::filesystem::path& folder,
                         std::ostream& out);

}  // namespace sweepstake::cli
