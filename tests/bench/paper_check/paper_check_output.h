// What `paper_check` prints, for people and for scripts. Pure functions.
#pragma once

#include <ostream>
#include <span>

#include "tests/bench/paper_check/paper_check.h"

namespace sweepstake::cli {

// The predictions by their rules, as CheckPaper orders them, and which of those with a least number
// of samples comes closest to the paper in all cells. REQUIRES: those of PaperRulesToCheck.
struct PaperReport {
  std::span<const PaperPrediction> paper;
  std::span<const PaperPrediction> random;
  std::vector<std::span<const PaperPrediction>> with_min_samples;
  std::span<const PaperPrediction> best_min_samples;
};
PaperReport ReportOf(std::span<const PaperPrediction> predictions);

void PrintPaperCheckTable(const PaperReport& report, const PaperCheckOptions& options,
                          std::ostream& out);
// "rows": one per rules and cell; "scores": one per rules.
void PrintPaperCheckJson(const PaperReport& report, const PaperCheckOptions& options,
                         std::ostream& out);

}  // namespace sweepstake::cli
