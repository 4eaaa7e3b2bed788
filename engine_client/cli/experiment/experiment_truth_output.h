// The truth's figures as text and as CSV files. Pure but for the files; safe from any thread.
#pragma once

#include <filesystem>
#include <ostream>

#include "engine_client/cli/experiment/experiment_report.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// The true ranking, regret per policy, live against replay, comparisons; what is not there is left
// out.
void PrintTruth(const ExperimentReport& report, std::ostream& out);

// ranking.csv, regret.csv (per seed), live_regret.csv (per run), agreement.csv and comparisons.csv
// in `folder`. The errors of CsvFile.
Status WriteTruthCsv(const ExperimentReport& report, const std::filesystem::path& folder);

}  // namespace sweepstake::cli
