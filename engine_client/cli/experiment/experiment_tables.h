// Tables 3 and 4 in the paper's layout with the paper's own figures beside them: as text and as
// CSV. Pure but for the files; safe from any thread.
#pragma once

#include <filesystem>
#include <ostream>
#include <span>
#include <string>

#include "engine_client/cli/experiment/experiment_summary.h"
#include "engine_client/cli/experiment/paper_tables.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// "Brownian", "Rotating Grav", "Hurricane", as the paper's tables say; else the scene's name.
std::string PaperSceneName(const std::string& scene);

// "12.2±2.8" with that many digits after the point; of one value only "12.2".
std::string SpreadText(const Spread& spread, int decimals);
// The same of a printed figure.
std::string PaperText(const PaperFigure& figure, int decimals);

// For each policy both tables.
void PrintTables(std::span<const CellSummary> cells, std::ostream& out);

// table3.csv and table4.csv in `folder`. The errors of CsvFile.
Status WriteTables(std::span<const CellSummary> cells, const std::filesystem::path& folder);

}  // namespace sweepstake::cli
