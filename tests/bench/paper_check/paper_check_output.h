// Formats the output of `paper_check` for readers and for scripts. Pure functions.
#pragma once

#include <ostream>
#include <span>

#include "tests/bench/paper_check/paper_check.h"

namespace sweepstake::cli {

// The predictions by rules, each list in the order of CheckPaper. best_min_samples is the list of
// with_min_samples that comes closest to the paper over all cells.
struct PaperReport {
  std::span<const PaperPrediction> paper;
  std::span<const PaperPrediction> random;
  std::vector<std::span<const PaperPrediction>> with_min_samples;
  std::span<const PaperPrediction> best_min_samples;
};
// REQUIRES: `predictions` is a result of CheckPaper for PaperRulesToCheck().
PaperReport ReportOf(std::span<const PaperPrediction> predictions);

void PrintPaperCheckTable(const PaperReport& report, const PaperCheckOptions& options,
                          std::ostream& out);
// Prints a JSON document: "rows" has an entry per rules and cell, "scores" has one per rules.
void PrintPaperCheckJson(const PaperReport& report, const PaperCheckOptions& options,
                         std::ostream& out);

}  // namespace sweepstake::cli
