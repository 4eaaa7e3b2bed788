// The result of an experiment and its outputs: text tables, CSV files and one JSON document. Pure
// except for the files; safe from any thread.
#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_folder.h"
#include "tests/laboratory/experiment/experiment_summary.h"
#include "tests/laboratory/experiment/experiment_truth.h"
#include "tests/laboratory/game/machine.h"

namespace sweepstake::cli {

// The data from which all outputs are made.
struct ExperimentReport {
  ExperimentPlan plan;
  std::vector<ExperimentSession> sessions;  // the last session made this report
  Machine machine;
  std::vector<RunRecord> records;  // the finished runs
  std::vector<CellSummary> cells;  // ordered by policy, then cell; they point into `records`
  ExperimentTruths truths;

  bool complete() const { return records.size() == plan.runs.size(); }
};

// Returns "12.2±2.8" with this number of decimals, or only "12.2" for a single value.
std::string SpreadText(const Spread& spread, int decimals);

// Returns the gain of choosing an arm over the cells, in ms per frame, and the cells without any.
// Empty if no cell was replayed.
std::string WorthText(const ExperimentTruths& truths);

// Prints what choosing is worth, then Tables 3 and 4 in the paper's layout for each policy, beside
// the paper's own figures.
// `folder` is the path of the experiment.
void PrintExperiment(const ExperimentReport& report, const std::filesystem::path& folder,
                     std::ostream& out);

// Writes these CSV files into `folder`; a file without rows is empty. Errors: those of WholeFile.
// - Tables 3 and 4: tables.csv
// - rows of the runs: activations.csv, switches.csv, decisions.csv, posteriors.csv, final.csv,
//   metrics.csv, time.csv
// - truth: worth.csv, ranking.csv, regret.csv, live_regret.csv, agreement.csv, comparisons.csv
Status WriteExperimentCsv(const ExperimentReport& report, const std::filesystem::path& folder);

// Prints the document of `--json`: a row per cell and policy, then the runs and the figures of
// experiment_truth.h, from which the report draws its charts.
void PrintExperimentJson(const ExperimentReport& report, const std::filesystem::path& folder,
                         std::ostream& out);

}  // namespace sweepstake::cli
