// What `paper_check` prints, for people and for scripts. Pure functions.
#pragma once

#include <ostream>
#include <span>

#include "tests/bench/paper_check/paper_check.h"

namespace sweepstake::cli {

void PrintPaperCheckTable(std::span<const PaperCheckRow> rows, const PaperCheckOptions& options,
                          std::ostream& out);
// "rows", one per cell, with the fit; "matches" says whether all do.
void PrintPaperCheckJson(std::span<const PaperCheckRow> rows, const PaperCheckOptions& options,
                         std::ostream& out);

}  // namespace sweepstake::cli
